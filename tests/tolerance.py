"""Tolerances of the tests, each with its reason."""

EXACT = 1e-9  # float64 geometry: a handful of roundings on numbers of metre size
COMPANY = 1e-9  # the same in another batch: a row's place in a matrix product may decide how it is rounded
LEARNED = 1e-5  # float32 heads
FITTED_DEG = 1.5  # RANSAC fits on noisy points under a fixed seed
HISTOGRAM = 1e-3  # distances of histograms from features of 16 bits, of which the least are left out

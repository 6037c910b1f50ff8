"""Potentials of segments and boundaries: examples, heads, training, calibration, files."""

"""Labels near each pixel of an image, in machine code; see `features.appearance.interior`."""

from __future__ import annotations

import numpy as np
from numba import njit

from blockstab.determinism.machine_code import fingerprint_of


@njit(error_model="numpy")
def _gathered(label, row, column, steps, others):
    """Write the other labels near a pixel into `others`, ascending, each once; how many there are."""
    count = 0
    for s in range(len(steps)):
        r, c = row + steps[s, 0], column + steps[s, 1]
        if r < 0 or c < 0 or r >= label.shape[0] or c >= label.shape[1]:
            continue
        other = label[r, c]
        if other == label[row, column]:
            continue
        place = count
        while place > 0 and others[place - 1] > other:
            place -= 1
        if place > 0 and others[place - 1] == other:
            continue
        for k in range(count, place, -1):
            others[k] = others[k - 1]
        others[place] = other
        count += 1
    return count


def _kept_while(fingerprint):
    """The function below; its machine code is made again when the fingerprint is another."""

    @njit(cache=True, error_model="numpy")
    def labels_near(label, steps):
        """Pixels (N,) of an image of labels (H, W), and the other labels (N,) a step (K, 2) away from them."""
        _ = fingerprint
        others, size = np.empty(len(steps), dtype=np.int64), 0
        pixel, near = np.empty(label.size, dtype=np.int64), np.empty(label.size, dtype=np.int64)
        for row in range(label.shape[0]):
            for column in range(label.shape[1]):
                count = _gathered(label, row, column, steps, others)
                if size + count > len(pixel):
                    pixel, near = np.append(pixel, pixel), np.append(near, near)
                for k in range(count):
                    pixel[size], near[size] = row * label.shape[1] + column, others[k]
                    size += 1
        return pixel[:size].copy(), near[:size].copy()

    return labels_near


labels_near = _kept_while(fingerprint_of("features"))

"""The gap of published fluxes (reynoldsflow, V. A. Yastrebov), by which flow is checked."""

import numpy as np
import scipy

PUBLISHED_FLUXES = {256: 0.0277323297674, 512: 0.0029641494720, 1024: 0.0545516245121}
"""Flux through a unit square by number of cells along a side, for a pressure difference of 1 and a
transmissivity h^3. Its direct and iterative solvers agree to about 1e-10."""
_SEED = 23_349
_CORRELATION = 1 / 48
_MEAN = 0.35


def published_gap(cells: int) -> np.ndarray:
    """Make the gap (cells, cells) of the published fluxes.

    White Gaussian noise, smoothed by a Gaussian whose standard deviation is 1/48 of a side (at
    least a cell) with mirrored ends along the flow (y) and periodic sides, is scaled to a mean of
    0.35 and a standard deviation of 1. Negative gaps are contacts. Unit of the gap: 1.
    """
    noise = np.random.default_rng(_SEED).standard_normal((cells, cells))
    width = max(1.0, _CORRELATION * cells)
    smooth = scipy.ndimage.gaussian_filter(noise, width, mode=("reflect", "wrap"))
    return np.maximum((smooth - smooth.mean()) / smooth.std() + _MEAN, 0.0)

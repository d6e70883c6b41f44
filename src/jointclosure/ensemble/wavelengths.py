"""Mismatch wavelengths of a study's jobs: their labels, and their coordinate in results.

Independent walls have none (None); in results it is infinite.
"""

from collections.abc import Iterable

import numpy as np

INDEPENDENT = "independent"
"""Label of independent walls."""


def labelled_wavelengths(wavelengths: Iterable[float]) -> dict[str, float | None]:
    """Mismatch wavelengths [m] by label, in micrometres; independent walls last."""
    return {f"{1e6 * value:.15g}um": value for value in wavelengths} | {INDEPENDENT: None}


def wavelength_coordinate(wavelength: float | None) -> tuple[str, list[float], dict[str, str]]:
    """The coordinate of one mismatch wavelength [m], as xarray takes it."""
    return "wavelength", [np.inf if wavelength is None else wavelength], {"units": "m"}

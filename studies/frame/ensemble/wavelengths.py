"""Labels of the mismatch wavelengths in job names; independent walls have no wavelength (None)."""

from collections.abc import Iterable

INDEPENDENT = "independent"
"""Label of independent walls."""


def labelled_wavelengths(wavelengths: Iterable[float]) -> dict[str, float | None]:
    """Return mismatch wavelengths [m] by label, in micrometres; independent walls come last."""
    return {f"{1e6 * value:.15g}um": value for value in wavelengths} | {INDEPENDENT: None}

"""Labels of the mismatch wavelengths of a study's jobs; independent walls have none (None)."""

from collections.abc import Iterable

INDEPENDENT = "independent"
"""Label of independent walls."""


def labelled_wavelengths(wavelengths: Iterable[float]) -> dict[str, float | None]:
    """Mismatch wavelengths [m] by label, in micrometres; independent walls last."""
    return {f"{1e6 * value:.15g}um": value for value in wavelengths} | {INDEPENDENT: None}

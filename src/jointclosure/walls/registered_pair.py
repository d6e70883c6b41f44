"""Two registered walls on one grid, with the errors of their registration (`RegisteredPair`)."""

from typing import NamedTuple

import numpy as np

from jointclosure.inputs.remarks import Caution, cautions
from jointclosure.walls import Walls
from jointclosure.walls.mating import Mating, Mismatch
from jointclosure.walls.motion import Motion
from jointclosure.walls.rotation_search import SlopeFit
from jointclosure.walls.scan_errors import ScanErrors, noise_of
from jointclosure.walls.scan_quality import MOVED

_WIDTHS = (5.5, 6.4, 8.0, 10.0)
"""Widths of an overlap [mismatch wavelengths] at which errors of fits were measured."""
_ERRORS_OF_FITS = (2.4, 1.55, 1.15, 1.0)
"""Errors of rotation and shift over their standard errors by the fit at these `_WIDTHS` (rms of the
three errors of 24 pairs of walls each, benchmarks/results/registration_small_*; from 10 on, from
benchmarks/results/registration). Walls of 4.6 wavelengths have the same errors as at 5.5."""


class FineWalls(NamedTuple):
    """Registered walls on a grid finer than the joint's, not resolved by the scans."""

    upper: np.ndarray  # heights (y, x) [m] towards the other wall
    lower: np.ndarray  # heights (y, x) [m] towards the other wall
    holes: np.ndarray  # cells (y, x) in which a scan has no height, bool
    step: int  # spacing of the joint, in cells of this grid


class RegisteredPair(NamedTuple):
    """Two registered walls on a grid; places are (y, x), except for ``first``."""

    upper: np.ndarray  # heights (y, x) [m] towards the other wall
    lower: np.ndarray  # heights (y, x) [m] towards the other wall
    spacing: float  # of the grid [m]
    aperture: np.ndarray  # distance (y, x) [m] at first touch
    first_touch_cell: tuple[int, int]  # number (y, x) of the first cell in contact
    orientation: str  # of the upper scan, stated or found
    fits: list[SlopeFit]  # the best of each orientation, the best first; none with a flat wall
    motion: Motion  # applied to the upper wall
    mated: Motion | None  # motion of best fit; None if the fit is ambiguous or a wall is flat
    correlation: float  # of heights
    mating: Mating  # correlation of both walls by wavelength
    mismatch: Mismatch  # wavelength beyond which the walls mate
    overlap_share: float  # share of the smaller scan in the walls
    holes: np.ndarray  # cells (y, x) out of contact, as a scan has no height there, bool
    first: np.ndarray  # place (x, y) [m] of the first cell in the lower scan
    remarks: list[str]  # results of the registration in sentences; warnings are a `Caution`
    fine: FineWalls | None = None  # on the usual grid, if the scans only resolve a coarser one
    waves: tuple[float, float] = (0.0, 0.0)  # [m] below which the scans hold nothing; 0: all
    rounding: float = 0.0  # standard deviation [m] of the rounding of the sum of both walls
    levelling: Motion | None = None  # by which scans whose scanned position is kept became level
    lost_square_slope: float = 0.0
    """Mean square slope [1] of both walls over a cell of the finest grid that interpolation took,
    by the slopes between scanned points (`interpolation_remarks.slopes_by_interpolation`)."""
    scale: float = 1.0  # heights of the upper wall over heights of the lower one, 1 unless clear
    scan_noise: tuple[tuple[str, float, float], ...] = ()
    """Name of each scanned wall, and the ends [m] of the 95 % interval of the standard deviation of
    white noise, NaN if not known (`jointclosure.walls.scan_quality.ScanQuality`)."""

    @property
    def warnings(self) -> list[Caution]:
        """Warnings among the remarks."""
        return cautions(self.remarks)

    def _noise_of_sum(self, walls: Walls) -> tuple[float, float]:
        """Return the smallest and largest estimate [m] of the noise of the sum of both walls.

        ``walls`` are on the finest grid. The estimate comes from the spectra (`noise_of`): all by
        which the walls depart from each other at the shortest waves of the grid. A part may be
        roughness too short for the grid, replaced by other roughness where a turned wall was
        interpolated. If the noise of all scans was measured, the estimate is at least the measured
        noise, and equal to it if the spectra show none.
        """
        low, high = noise_of(*walls)
        intervals = np.array([ends for _, *ends in self.scan_noise]).reshape(-1, 2)
        if not np.isfinite(intervals).all() or not intervals.size:
            return low, high
        least, most = np.sqrt((intervals**2).sum(axis=0))
        return max(low, float(least)), max(high, float(least if high > 0.0 else most))

    @property
    def mismatch_wavelengths(self) -> float:
        """Width of the overlap in mismatch wavelengths; infinite if there is no such wavelength."""
        wavelength = self.mismatch.wavelength
        if not 0.0 < wavelength < np.inf:
            return np.inf
        return min(self.upper.shape) * self.spacing / wavelength

    @property
    def error_factor(self) -> float:
        """Factor from standard errors of the fit to those of rotation and shift in `errors`.

        Few waves of the walls fit each other on an overlap of few mismatch wavelengths, and the
        residuals of the fit show less than the error. The factor was measured (`_ERRORS_OF_FITS`).
        """
        return float(np.interp(self.mismatch_wavelengths, _WIDTHS, _ERRORS_OF_FITS))

    @property
    def finest(self) -> FineWalls:
        """Walls on the finest grid of the scans, to which the ``errors`` refer.

        The walls themselves, unless the scans do not resolve the finest grid and the joint has a
        coarser one.
        """
        return self.fine or FineWalls(self.upper, self.lower, self.holes, 1)

    @property
    def errors(self) -> ScanErrors:
        """Standard errors of the position, 0 if the walls stayed as scanned, and of the heights.

        Lengths are in cells of the finest grid, angles in rad. Errors of the position are the
        errors of the fit times the `error_factor`. Rounding counts as noise only if it changes the
        sum of both walls.
        """
        fine = self.finest
        walls = (fine.upper, fine.lower)
        spacing = self.spacing / fine.step
        covariance = np.zeros((3, 3))
        offset = np.zeros(3)
        if self.mated is not None and np.isfinite(self.motion.covariance).all():
            scale = np.array([1.0, spacing, spacing])
            offset = self.motion.difference_to(self.mated) / scale * self.motion.covariance.any()
            covariance = self.motion.covariance / np.outer(scale, scale) * self.error_factor**2
        middle = (self.motion.place[:2] - self.first) / spacing
        noise = self._noise_of_sum(walls)
        waves = [wave / spacing for wave in self.waves]
        steps = np.concatenate([np.diff(sum(walls), axis=axis).ravel() for axis in (0, 1)])
        if self.rounding**2 > MOVED * float(np.mean(steps**2)):
            noise = max(noise[0], self.rounding), max(noise[1], self.rounding)
        return ScanErrors(
            offset, covariance, middle, noise, fine.holes, fine.step,
            waves=(waves[0] * (waves[0] > 2.0), waves[1] * (waves[1] > 2.0)), scale=self.scale,
            lost_square=self.lost_square_slope * spacing**2,
        )  # fmt: skip

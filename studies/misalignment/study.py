"""Experiment on walls that are tilted, or rotated about the normal of the joint.

Independent walls, and walls whose longer waves mate, are simulated at every tilt and at every
rotation, on the same surfaces.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import scipy
from matplotlib.figure import Figure

from jointclosure.ensembles.quantities import QUANTITIES, titles_of_cycles
from jointclosure.inputs import InputError
from jointclosure.statistics.standard_errors import ratio_of_means
from jointclosure.walls import Walls
from jointclosure.walls.jrc import z2_of_jrc
from jointclosure.walls.planes import detrended
from jointclosure.walls.synthesis import (
    Spectrum,
    gaussian_field,
    generators,
    scaled_together,
    spectrum_of,
    wave_numbers,
)
from studies.frame.configuration import Configuration
from studies.frame.experiments import Experiment, Tables, at_wavelengths
from studies.frame.joint_tables import grouped, mean_shown
from studies.frame.panels import PanelColumn, Row, panels
from studies.frame.settings import ClosureSettings, Point, seeds_of
from studies.misalignment.section import MisalignmentSection

READ = ("max_closure", "max_closure_seated_net", "residual_closure_seated_net", "stiffness_net")
"""Quantities of the column ``response``."""
SHOWN: tuple[tuple[str, int], ...] = (
    ("max_closure_seated_net", 1),
    ("max_closure_seated_net", 2),
    ("residual_closure_seated_net", 1),
)
SHOWN += (("stiffness_net", 1), ("stiffness_net", 2))
"""Response and cycle of each row of the figure."""
WALLS = f"{__name__}:misaligned"


def misaligned(settings: ClosureSettings, tilt: float, rotation: float) -> Iterator[Walls]:
    """Generate pairs of walls (y, x) [m] that are misaligned by two angles [degrees].

    The upper wall is tilted about its middle axis along y, the lower wall rotated about the normal.
    """
    grid = settings.grid
    surface = settings.surface
    wavelength = surface.mismatch_wavelength
    for seed in seeds_of(settings):
        upper, lower = rotated_pair(
            z2_of_jrc(settings.case.jrc, grid.spacing, surface.hurst, surface.jrc_relation),
            grid.shape,
            grid.spacing,
            spectrum_of(surface.hurst, surface.rule, surface.roll_off, grid.spacing),
            seed,
            np.inf if wavelength is None else wavelength,
            rotation,
        )
        yield tilted(upper, grid.spacing, tilt), lower


def tilted(wall: np.ndarray, spacing: float, degrees: float) -> np.ndarray:
    """Tilt a wall (y, x) [m] about its middle axis along y: heights increase by x tan(degrees)."""
    nx = wall.shape[1]
    x = spacing * (np.arange(nx) - 0.5 * (nx - 1))
    return wall + np.tan(np.deg2rad(degrees)) * x


def rotated_pair(
    z2: float,
    shape: tuple[int, int],
    spacing: float,
    spectrum: Spectrum,
    seed: int,
    mismatch_wavelength: float = np.inf,
    rotation: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Make walls (y, x) [m] as `wall_pair` does, and rotate the lower one about the normal.

    The ``rotation`` [degrees] is anticlockwise. The waves of the lower wall are summed at rotated
    points, so that no interpolation damps them. ``z2`` is the RMS slope of both walls together. At
    multiples of 90 degrees cells map to cells; at other angles the last digits may differ between
    processors.

    Raises
    ------
    InputError
        If the grid is not square.
    """
    n = shape[0]
    if shape[1] != n:
        raise InputError(f"shape = {tuple(shape)!r}: a wall is rotated on a square grid only")
    size = (2 * n, 2 * n)
    upper, other = (
        scipy.fft.rfft2(gaussian_field(size, spectrum, random, oversize=1), workers=1)
        for random in generators(seed)
    )
    lower = np.where(np.hypot(*wave_numbers(*size)) < spacing / mismatch_wavelength, -upper, other)
    still = scipy.fft.irfft2(upper, s=size, workers=1)[:n, :n]
    turned = _at_rotated_points(lower, n, rotation)
    return scaled_together(detrended(still), detrended(turned), z2, spacing)


def _at_rotated_points(waves: np.ndarray, n: int, degrees: float) -> np.ndarray:
    """Sum waves of a field of 2 n by 2 n cells (by `scipy.fft.rfft2`) at n by n rotated points."""
    cosine = np.cos(np.deg2rad(degrees))
    sine = np.sin(np.deg2rad(degrees))
    middle = 0.5 * (n - 1)
    about = np.arange(n) - middle
    wave_y, wave_x = wave_numbers(2 * n, 2 * n)
    # waves of a real field with negative wave numbers along x are mirror images and not stored
    twice = np.where((wave_x > 0.0) & (wave_x < 0.5), 2.0, 1.0)
    weighted = (waves * twice).T / (2 * n) ** 2
    # rotated point: (middle + cosine x + sine y, middle - sine x + cosine y)
    of_x = _phases(cosine * about, wave_x), _phases(-sine * about, wave_y.T)
    of_y = _phases(middle + sine * about, wave_x), _phases(middle + cosine * about, wave_y.T)
    rows = []
    for along_x, along_y in zip(*of_y, strict=True):
        summed = of_x[0] @ (along_x[:, None] * weighted)
        rows.append(np.sum(summed * of_x[1] * along_y, axis=1).real)
    return np.stack(rows)


def _phases(places: np.ndarray, waves: np.ndarray) -> np.ndarray:
    """Return exp(2 pi i f x) for places x [cells] (n,) and wave numbers f (1, waves)."""
    return np.exp(2j * np.pi * places[:, None] * waves)


def misalignment_jobs(study: Configuration) -> dict[str, list[Point]]:
    """Make a job for each rock and mismatch wavelength, of aligned, tilted and rotated walls."""
    section = study.section(MisalignmentSection)
    angles = [{"tilt": tilt, "rotation": 0.0} for tilt in section.tilt_degrees]
    angles += [{"tilt": 0.0, "rotation": rotation} for rotation in section.rotation_degrees[1:]]
    return {
        f"{rock}.{name}": [
            Point({"rock": rock, "wavelength": wavelength} | angle, settings, WALLS, angle)
            for angle in angles
        ]
        for rock, name, wavelength, settings in at_wavelengths(study, section.mismatch_wavelength)
    }


def mean_changes(
    joints: pd.DataFrame, by: Sequence[str], names: Sequence[str], reference: Mapping[str, Any]
) -> pd.DataFrame:
    """Tabulate means over surfaces, and their changes [%] from a reference on the same surfaces.

    ``by`` are the columns that identify a point, ``names`` the quantities. The reference is the
    point with the values ``reference`` in some of these columns and the same values in the others.
    """
    others = [name for name in (*by, "cycle") if name not in reference]
    here = (joints[list(reference)] == pd.Series(reference)).all(axis=1)
    bases = dict(list(joints[here].groupby(others)))
    rows = []
    for at, part in grouped(joints, *by, "cycle"):
        base = bases[tuple(part[others].iloc[0])]
        for name in names:
            values = part[name].to_numpy()
            before = base[name].to_numpy()
            both = np.isfinite(values) & np.isfinite(before)
            values = values[both]
            before = before[both]
            mean = mean_shown(name, values)
            harmonic = QUANTITIES[name].has_harmonic_mean
            ratio = ratio_of_means(*((1 / before, 1 / values) if harmonic else (values, before)))
            row = {"response": name, "value": mean.value, "error": mean.standard_error}
            row["change_percent"] = 100.0 * (ratio.value - 1.0)
            row |= {"change_error": 100.0 * ratio.standard_error, "samples": int(both.sum())}
            rows.append(at | row)
    return pd.DataFrame(rows)


def tabulate_misalignment(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Compute means over surfaces, and their changes from aligned walls."""
    by = ("rock", "wavelength", "tilt", "rotation")
    table = mean_changes(joints, by, READ, {"tilt": 0.0, "rotation": 0.0})
    return table[(table.response != "residual_closure_seated_net") | (table.cycle == 1)]


def draw_misalignment(tables: Tables, settings: Mapping[str, Any]) -> Figure:
    """Draw changes from aligned walls over tilt and rotation, with 95 % intervals."""
    table = tables["misalignment"]
    rows = [
        Row(f"change of {title} (%)", part, "change_percent", "change_error")
        for (response, cycle), title in titles_of_cycles(*SHOWN).items()
        for part in [table[(table.response == response) & (table.cycle == cycle)]]
    ]
    columns = [
        PanelColumn("tilt_degrees", "rock", {"rotation_degrees": 0.0}),
        PanelColumn("rotation_degrees", "rock", {"tilt_degrees": 0.0}, "symlog"),
    ]
    lengths = {length: f"waves beyond {length:g} mm mate" for length in table.wavelength_mm}
    names = {
        "wavelength_mm": lengths | {np.inf: "independent"},
        "rock": settings["titles"],
    }
    return panels(
        rows, columns, names, styles="wavelength_mm", bars=1.96, reference=0.0, sharey=False
    )


EXPERIMENT = Experiment(
    title="effects of a tilt and a rotation of the walls",
    quantities=READ,
    jobs=misalignment_jobs,
    tables={"misalignment.csv": tabulate_misalignment},
    figures={"misalignment": draw_misalignment},
    settings=lambda study: {"titles": study.titles},
)

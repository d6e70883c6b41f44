"""Joints that are closed beside a measured curve, as `fit` and `validate` are asked for them."""

import hashlib
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from jointclosure.engine.scanned_joint import Wall, registered_walls
from jointclosure.inputs import InputError, check_number, check_positive, check_seed, naming
from jointclosure.joint.conditions import usual_seating
from jointclosure.joint.rocks import named_rock
from jointclosure.measured.calibration import Readings, joints_needed, readings_of_curve
from jointclosure.measured.curves import MeasuredCurve, check_loadings, parsed_curve
from jointclosure.parameters import PROPERTIES, Rock, check_rock, check_usual
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.storage.files import read_text
from jointclosure.walls.pairs import shifted
from jointclosure.walls.registration import RegisteredPair
from jointclosure.walls.synthesis import check_roll_off, wall_pair

SPACING = 0.25e-3
"""Usual grid spacing of random walls [m]."""


class SimulatedWalls(NamedTuple):
    """Walls of the simulated joints: random ones, or scanned ones of a ``digest``.

    The JRC is drawn from its range for each joint.
    """

    jrc: tuple[float, float]
    shape: tuple[int, int]
    spacing: float
    seed: int
    hurst: float
    roll_off: float | None
    digest: str = ""

    def pair(self, number: int, wavelength: float, scans: Any) -> tuple[np.ndarray, np.ndarray]:
        """Make the walls of a joint, from the ``scans`` displaced by up to a cell along x and y."""
        if self.digest:
            cells = generator(seed_of(self.seed, "shift", number)).integers(-1, 2, 2).tolist()
            return shifted(scans, cells)
        low, high = self.jrc
        jrc = generator(seed_of(self.seed, "jrc", number)).uniform(low, high) if low < high else low
        return wall_pair(
            float(jrc), self.shape, self.spacing, seed_of(self.seed, "fit", number), self.hurst,
            mismatch_wavelength=wavelength, roll_off=self.roll_off, unusual_values=True,
        )  # fmt: skip


class AskedJoints(NamedTuple):
    """A measured curve, and the joints that are closed beside it.

    ``wavelengths`` (n,) [m] of the mismatch of random walls; of scanned ones that of the ``pair``,
    whose walls are ``scans``.
    """

    rock: Rock
    curve: MeasuredCurve
    measured: Readings
    walls: SimulatedWalls
    wavelengths: np.ndarray
    pair: RegisteredPair | None
    scans: tuple[np.ndarray, np.ndarray] | None

    def assumed(self, strengths: Sequence[float]) -> str:
        """Describe the joints, of strengths [Pa] or between two."""
        rock, roll_off, spacing = self.rock, self.walls.roll_off, self.walls.spacing
        ny, nx = (1e3 * spacing * cells for cells in self.walls.shape)
        waves = "of all lengths"
        if roll_off is not None:
            waves = f"weaker beyond {1e3 * roll_off:g} mm (roll-off)"
        strength = " to ".join(f"{1e-6 * end:g}" for end in strengths)
        jrc = dict.fromkeys(self.walls.jrc)
        roughness = f"JRC {' to '.join(f'{end:g}' for end in jrc)}, waves {waves}"
        if self.pair is not None:
            roughness = "scanned walls, the upper one displaced by up to one cell along x and y"
        return (
            f"{roughness}, {nx:g} x {ny:g} mm at a spacing of {1e3 * spacing:g} mm, "
            f"E {1e-9 * rock.youngs_modulus:g} GPa, Poisson's ratio {rock.poisson_ratio:g},"
            f" strength {strength} MPa; measured closures net of the intact rock's deformation"
        )


def asked_joints(
    curve: str | Path | MeasuredCurve,
    *,
    rock: str | Rock,
    jrc: float | tuple[float, float] | None,
    scans: tuple[Wall, Wall] | None,
    units: str | None,
    orientation: str | None,
    pair: RegisteredPair | None,
    size: float | None,
    shape: tuple[int, int] | None,
    spacing: float | None,
    seating_stress: float | None,
    stress_unit: str | None,
    closure_unit: str | None,
    columns: Sequence[str] | None,
    surfaces: int,
    closure_error: float,
    seed: int,
    hurst: float,
    roll_off: float | None,
    wavelengths: int,
    first_loading: bool = False,
) -> AskedJoints:
    """Read a curve and check the joint, with arguments and errors as for `jointclosure.fit`."""
    intact = named_rock(rock)
    check_rock(intact)
    name = "curve" if isinstance(curve, MeasuredCurve) else str(curve)
    curve = read_curve(curve, stress_unit, closure_unit, columns)
    curve = curve.first_loading() if first_loading else curve
    if scans is not None:
        for keyword, value in (("jrc", jrc), ("size", size), ("shape", shape), ("pair", pair)):
            if value is not None:
                raise InputError(f"{keyword} = {value!r}: must be left out with scans")
        pair = registered_walls(*scans, {"units": units}, spacing, orientation=orientation)
    if pair is not None:
        shape, spacing = pair.upper.shape, pair.spacing
    jrcs = (0.0, 0.0) if pair is not None else _jrc_range(jrc)
    spacing = SPACING if spacing is None else spacing
    ny, nx = _checked(_shape(size, shape, spacing), surfaces, closure_error, seed)
    measured = _readings(curve, name, seating_stress)
    check_usual((), roll_off=roll_off)
    check_roll_off(roll_off, max(ny, nx) * spacing)
    lengths = np.geomspace(2.0 * spacing, min(ny, nx) * spacing, wavelengths)
    walls = SimulatedWalls(jrcs, (ny, nx), spacing, seed, hurst, roll_off)
    if pair is None:
        return AskedJoints(intact, curve, measured, walls, lengths, None, None)
    lengths = np.array([np.clip(pair.mismatch.wavelength, *lengths[[0, -1]])])
    arrays = np.ascontiguousarray(pair.upper), np.ascontiguousarray(pair.lower)
    walls = walls._replace(digest=hashlib.sha256(b"".join(w.tobytes() for w in arrays)).hexdigest())
    return AskedJoints(intact, curve, measured, walls, lengths, pair, arrays)


def check_surfaces(surfaces: int, nodes: tuple[int, int], measured: Readings) -> None:
    """Raise `InputError` for fewer joints than readings at all wavelengths and strengths take."""
    needed, count = joints_needed(nodes, measured.values.size), math.prod(nodes)
    if surfaces * count < needed:
        least = math.ceil(needed / count)
        raise InputError(f"surfaces = {surfaces}: must be at least {least} for this curve")


def _jrc_range(jrc: Any) -> tuple[float, float]:
    """Return the ends of the range of the JRC."""
    ends = tuple(jrc) if isinstance(jrc, tuple | list) else (jrc, jrc)
    lowest, highest = ends if len(ends) == 2 else (None, None)
    if lowest is None or highest is None:
        raise InputError(f"jrc = {jrc!r}: must be a number or (lowest, highest) without scans")
    for end in ends:
        PROPERTIES["jrc"].check("jrc", end)
    if lowest > highest:
        raise InputError(f"jrc = {jrc!r}: the lowest value must come first")
    return lowest, highest


def read_curve(
    curve: str | Path | MeasuredCurve,
    stress_unit: str | None = None,
    closure_unit: str | None = None,
    columns: Sequence[str] | None = None,
) -> MeasuredCurve:
    """Read a curve from its file; arguments and errors as for `fit`."""
    if isinstance(curve, MeasuredCurve):
        return curve
    if not Path(curve).is_file():
        raise InputError(f"{curve}: file not found")
    text = read_text(curve)
    return parsed_curve(text, str(curve), stress_unit, closure_unit, cycle=1, names=columns)


def _readings(curve: MeasuredCurve, name: str, seating_stress: float | None) -> Readings:
    """Check a curve, and read it."""
    if seating_stress is None:
        maxima = (curve.stress[curve.cycle == cycle].max() for cycle in curve.cycles)
        seating_stress = usual_seating(float(min(maxima)))
    check_positive("seating_stress", seating_stress, "Pa")
    check_loadings(curve, name, seating_stress)
    with naming(name):
        return readings_of_curve(curve, seating_stress)


def _shape(
    size: float | None, shape: tuple[int, int] | None, spacing: float
) -> tuple[int, int] | None:
    """Return the cells of the simulated joints, which may be stated by the length of their side."""
    check_positive("spacing", spacing, "m")
    if size is None and shape is None:
        raise InputError(
            "size: must be given, the side of the measured joint (or, for a smaller one, shape in "
            "Python, --cells on the command line), because closure depends on it"
        )
    if size is None:
        return shape
    check_positive("size", size, "m")
    cells = round(size / spacing)
    return cells, cells


def _checked(
    shape: tuple[int, int] | None, surfaces: int, closure_error: float, seed: int
) -> tuple[int, int]:
    """Return the shape, or raise `InputError` for it or a number."""
    if not isinstance(shape, tuple | list) or len(shape) != 2 or min(shape) < 8:
        raise InputError(
            f"shape = {shape!r}: must be (cells along y, along x), at least 8 each, so that the "
            "simulated joints are as large as the measured one: closure depends on the size"
        )
    check_number("surfaces", surfaces, whole=True)
    if surfaces < 4:
        raise InputError(f"surfaces = {surfaces}: must be at least 4, to estimate the scatter")
    check_number("closure_error", closure_error)
    if not 0.0 < closure_error <= 1.0:
        raise InputError(f"closure_error = {closure_error!r}: must be above 0 and at most 1")
    check_seed("seed", seed)
    return shape

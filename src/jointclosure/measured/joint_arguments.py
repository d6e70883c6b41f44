"""Arguments of `fit` and `validate`: a measured curve, and the joint to compare with it."""

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Required, TypedDict

import numpy as np

from jointclosure.inputs import (
    InputError,
    check_count,
    check_length,
    check_number,
    check_positive,
    naming,
)
from jointclosure.inputs.keywords import check_keywords
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.load import usual_seating
from jointclosure.joint.rocks import named_rock
from jointclosure.measured.curves import MeasuredCurve, check_curve, parsed_curve
from jointclosure.measured.likelihood import Readings, readings_of_curve
from jointclosure.parameters import (
    PROPERTIES,
    RESOLVED,
    Choices,
    Effects,
    Numerics,
    Rock,
    check_effective,
    check_model,
    check_rock,
    check_usual,
)
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.storage.files import read_text
from jointclosure.walls import shifted
from jointclosure.walls.registered_pair import RegisteredPair
from jointclosure.walls.synthesis import check_roll_off, wall_pair
from jointclosure.walls.wall_files import Wall, registered_walls

SPACING = 0.25e-3
"""Usual grid spacing of random walls [m]."""


class WallRecipe(NamedTuple):
    """Recipe of the walls of simulated joints: random walls, or scans that are displaced.

    Random walls have a JRC from the range ``jrc`` and (ny, nx) = ``shape`` cells of a ``spacing``
    [m]; ``hurst`` and ``roll_off`` [m] are as for `jointclosure.wall_pair`. Scans are known by
    their ``digest``, which is empty for random walls. Everything random follows from ``seed``.
    """

    jrc: tuple[float, float]
    shape: tuple[int, int]
    spacing: float
    seed: int
    hurst: float
    roll_off: float | None
    digest: str = ""

    def pair(self, number: int, wavelength: float, scans: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return the walls (y, x) [m] of the simulated joint with a ``number``.

        Random walls have a mismatch ``wavelength`` [m], and do not use ``scans``. Scanned walls are
        the ``scans`` (upper, lower), displaced against each other by -1, 0 or 1 cell along x and y,
        and do not use the wavelength.
        """
        if self.digest:
            cells = generator(seed_of(self.seed, "shift", number)).integers(-1, 2, 2).tolist()
            return shifted(scans, cells)
        low, high = self.jrc
        jrc = generator(seed_of(self.seed, "jrc", number)).uniform(low, high) if low < high else low
        return wall_pair(
            float(jrc), self.shape, self.spacing, seed_of(self.seed, "fit", number), self.hurst,
            mismatch_wavelength=wavelength, roll_off=self.roll_off, unusual_values=True,
        )  # fmt: skip


class MeasuredJoint(NamedTuple):
    """Joint of a measured curve, and the joints that are simulated for comparison with it.

    Functions that compare a curve with simulated joints take these fields as keywords.

    Attributes
    ----------
    rock : str or Rock
        Rock of both walls, by name (`jointclosure.joint.rocks.ROCKS`) or properties.
    jrc : float or (float, float)
        Joint roughness coefficient of both walls; or the ends of a range, in which every simulated
        joint has a random one, so that results include it. Not needed for scanned walls.
    scans : (upper, lower), optional
        Scans of the walls, if there are any. The simulated joints differ in the position of the
        walls, which is known to one cell along x and y. Without ``jrc``, ``size`` and ``shape``.
    units, orientation : str, optional
        As for `jointclosure.close`.
    pair : RegisteredPair, optional
        Scanned walls that are registered already, in place of ``scans``.
    size : float, optional
        Side of the measured joint [m], on which closure depends.
    shape : (ny, nx), optional
        Cells along the sides of a smaller joint, which takes less time and closes less far.
    spacing : float, optional
        Grid spacing [m]: by default 0.25 mm, or for scans as for `jointclosure.close`.
    seating_stress : float, optional
        Stress from which closures count [Pa]; the curve must start at or below it. By default as
        for `jointclosure.Conditions`.
    stress_unit, closure_unit : str, optional
        Units, if the headings of the columns have none, such as MPa, psi or kN, and mm or um.
    area : float, optional
        Loaded area [m2] of the measured joint, by which a column of forces becomes one of stresses.
    columns : sequence of str, optional
        Headings of the columns of stress, closure and cycle, if they are others, or their numbers.
    closure_error : float
        Relative error of measured closures, one standard deviation. At most 1.
    surfaces : int
        Number of joints at each mismatch wavelength and strength that is tried.
    seed : int
        Seed of the joints.
    hurst, roll_off
        As for `jointclosure.wall_pair`, whose default roll-off of 3 mm is for walls as in the
        paper's study. Here walls have waves of all lengths by default, as natural walls have.
    effects, choices
        As for `jointclosure.simulate`.
    """

    rock: str | Rock
    jrc: float | tuple[float, float] | None = None
    scans: tuple[Wall, Wall] | None = None
    units: str | None = None
    orientation: str | None = None
    pair: RegisteredPair | None = None
    size: float | None = None
    shape: tuple[int, int] | None = None
    spacing: float | None = None
    seating_stress: float | None = None
    stress_unit: str | None = None
    closure_unit: str | None = None
    area: float | None = None
    columns: Sequence[str] | None = None
    closure_error: float = 0.02
    surfaces: int = 12
    seed: int = 1
    hurst: float = 0.8
    roll_off: float | None = None
    effects: Effects = Effects()
    choices: Choices = Choices()


class JointKeywords(TypedDict, total=False):
    """Fields of `MeasuredJoint` as keywords, for type checkers and editors."""

    rock: Required[str | Rock]
    jrc: float | tuple[float, float] | None
    scans: tuple[Wall, Wall] | None
    units: str | None
    orientation: str | None
    pair: RegisteredPair | None
    size: float | None
    shape: tuple[int, int] | None
    spacing: float | None
    seating_stress: float | None
    stress_unit: str | None
    closure_unit: str | None
    area: float | None
    columns: Sequence[str] | None
    closure_error: float
    surfaces: int
    seed: int
    hurst: float
    roll_off: float | None
    effects: Effects
    choices: Choices


class AskedJoints(NamedTuple):
    """A measured curve with its readings, and the joints to be simulated for comparison with it.

    ``joint`` has the arguments as the caller gave them. ``rock`` is the rock that they name,
    ``curve`` the checked curve, and ``measured`` are its readings. ``wavelengths`` (n,) [m] are the
    mismatch wavelengths of random walls; for scanned walls there is one, that of the registered
    ``pair``, moved into the range for random walls. ``scans`` are the two walls (y, x) [m] of the
    pair, None for random walls.
    """

    joint: MeasuredJoint
    rock: Rock
    curve: MeasuredCurve
    measured: Readings
    walls: WallRecipe
    wavelengths: np.ndarray
    pair: RegisteredPair | None
    scans: tuple[np.ndarray, np.ndarray] | None

    def assumed(self, strengths: Sequence[float]) -> str:
        """Describe the simulated joints: walls, size and rock, with the strength [Pa].

        ``strengths`` is one strength, or the lowest and the highest one.
        """
        rock = self.rock
        roll_off = self.walls.roll_off
        spacing = self.walls.spacing
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

    def conditions(self, numerics: Numerics, usual: Numerics = RESOLVED) -> Conditions:
        """Return the conditions of one cycle to the largest stress at which the curve is read.

        Raise `InputError` for effects, choices or ``numerics`` that are not allowed, and for a
        setting without effect, unless its value is a default or one of ``usual``.
        """
        measured = self.measured
        joint = self.joint
        check_model(joint.effects, joint.choices, numerics)
        check_effective(joint.effects, joint.choices, numerics, usual)
        return Conditions(
            self.walls.spacing, self.rock, float(measured.levels[-1]), 1, measured.seating,
            joint.effects, joint.choices, numerics,
        )  # fmt: skip


def asked_joints(
    curve: str | Path | MeasuredCurve,
    stated: Mapping[str, Any],
    function: str,
    wavelength_count: int,
    first_loading: bool = False,
) -> AskedJoints:
    """Read a measured curve, and check the joint that the keywords of a ``function`` state.

    Scans are read and registered. ``stated`` are fields of `MeasuredJoint`, ``wavelength_count`` is
    the number of mismatch wavelengths of random walls: from two spacings to the shorter side, at
    equal ratios. With ``first_loading`` all later points of the curve are left out. Raise
    `InputError` if the curve or a value is not allowed, `TypeError` for an unknown keyword or if
    the rock is missing.
    """
    check_keywords(function, stated, MeasuredJoint._fields, ["rock"])
    given = MeasuredJoint(**stated)
    pair = given.pair
    shape = given.shape
    spacing = given.spacing
    intact = named_rock(given.rock)
    check_rock(intact)
    if spacing is not None:
        check_length("spacing", spacing)
        check_usual((), spacing=spacing)
    checked_curve, measured = _read_curve(curve, given, first_loading)
    if given.scans is not None:
        for keyword in ("jrc", "size", "shape", "pair"):
            if (value := getattr(given, keyword)) is not None:
                raise InputError(f"{keyword} = {value!r}: must be left out with scans")
        units = {"units": given.units}
        pair = registered_walls(*given.scans, units, spacing, orientation=given.orientation)
    if pair is not None:
        shape = pair.upper.shape
        spacing = pair.spacing
    jrcs = (0.0, 0.0) if pair is not None else _jrc_range(given.jrc)
    spacing = SPACING if spacing is None else spacing
    ny, nx = _cells_of_joint(given, shape, spacing)
    check_count("surfaces", given.surfaces, 4, 100_000)
    check_count("seed", given.seed, 0)
    error = given.closure_error
    check_number("closure_error", error)
    if not 0.0 < error <= 1.0:
        wrong = f"closure_error = {error!r} ({100.0 * error:g} %)"
        raise InputError(f"{wrong}: must be above 0 and at most 1 (100 %)")
    check_usual((), roll_off=given.roll_off)
    check_roll_off(given.roll_off, max(ny, nx) * spacing)
    wavelengths = np.geomspace(2.0 * spacing, min(ny, nx) * spacing, wavelength_count)
    walls = WallRecipe(jrcs, (ny, nx), spacing, given.seed, given.hurst, given.roll_off)
    if pair is None:
        return AskedJoints(given, intact, checked_curve, measured, walls, wavelengths, None, None)
    wavelengths = np.array([np.clip(pair.mismatch.wavelength, *wavelengths[[0, -1]])])
    arrays = np.ascontiguousarray(pair.upper), np.ascontiguousarray(pair.lower)
    walls = walls._replace(digest=hashlib.sha256(b"".join(w.tobytes() for w in arrays)).hexdigest())
    return AskedJoints(given, intact, checked_curve, measured, walls, wavelengths, pair, arrays)


def _jrc_range(jrc: Any) -> tuple[float, float]:
    """Return the lowest and the highest JRC of random walls, equal for a single number.

    Raise `InputError` unless ``jrc`` is a number or (lowest, highest), each from 0 to 20.
    """
    ends = tuple(jrc) if isinstance(jrc, tuple | list) else (jrc, jrc)
    lowest, highest = ends if len(ends) == 2 else (None, None)
    if lowest is None or highest is None:
        raise InputError(f"jrc = {jrc!r}: must be a number or (lowest, highest) without scans")
    for end in ends:
        PROPERTIES["jrc"].check("jrc", end)
    if lowest > highest:
        raise InputError(f"jrc = {jrc!r}: the lowest value must come first")
    return lowest, highest


def _read_curve(
    curve: str | Path | MeasuredCurve, given: MeasuredJoint, first_loading: bool
) -> tuple[MeasuredCurve, Readings]:
    """Return the checked curve and its readings; ``curve`` is a path or a curve that was read.

    Raise `InputError` if the file is missing, or the curve is not allowed (`check_curve`,
    `readings_of_curve`).
    """
    name = "curve" if isinstance(curve, MeasuredCurve) else str(curve)
    if not isinstance(curve, MeasuredCurve):
        if not Path(curve).is_file():
            raise InputError(f"{name}: file not found")
        if given.area is not None:
            check_positive("area", given.area, "m2")
        curve = parsed_curve(
            read_text(curve),
            name,
            given.stress_unit,
            given.closure_unit,
            cycle=1,
            names=given.columns,
            area=given.area,
        )
    else:
        curve = MeasuredCurve(*map(np.asarray, curve))
    curve = curve.first_loading() if first_loading else curve
    seating = given.seating_stress
    if seating is None:
        seating = usual_seating(
            min(float(curve.stress[curve.cycle == c].max()) for c in curve.cycles)
        )
    check_positive("seating_stress", seating, "Pa")
    check_curve(curve, name, seating)
    with naming(name):
        return curve, readings_of_curve(curve, seating)


def _cells_of_joint(given: MeasuredJoint, shape: Any, spacing: float) -> tuple[int, int]:
    """Return the numbers of cells (y, x) of the simulated joints.

    They follow from the stated side [m] and the ``spacing`` [m], or else are ``shape``. Raise
    `InputError` if neither is given, or a side has fewer than 8 cells.
    """
    check_positive("spacing", spacing, "m")
    if given.size is not None:
        check_positive("size", given.size, "m")
        shape = 2 * (round(given.size / spacing),)
    elif shape is None:
        raise InputError(
            "size: must be given, the side of the measured joint (or, for a smaller one, shape in "
            "Python, --cells on the command line), because closure depends on it"
        )
    if not isinstance(shape, tuple | list) or len(shape) != 2 or min(shape) < 8:
        raise InputError(
            f"shape = {shape!r}: must be (cells along y, along x), at least 8 each, so that the "
            "simulated joints are as large as the measured one: closure depends on the size"
        )
    ny, nx = shape
    return ny, nx

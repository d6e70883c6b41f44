"""What a simulation is told: rocks, effects, choices and numerics, all in SI.

`SI_FACTORS` is the one place where the units of a configuration (the suffix
of a key's name) become SI.
"""

import math
import sys
from collections.abc import Iterator
from decimal import Decimal
from typing import Literal, NamedTuple

import numpy as np

from jointclosure.mechanics.contact import (
    equivalent_modulus,
    plane_strain_modulus,
    substrate_compliance,
)
from jointclosure.mechanics.strength import critical_indentation, strength_factor

LENGTHS = (1e-15, 1e15)
"""Smallest and largest length [m] that spacings may have, and largest height."""

SMALLEST_TOLERANCE = 1e-14
"""Of what is to be met relatively: about fifty roundings."""

SI_FACTORS = {"GPa": 1e9, "MPa": 1e6, "mm": 1e-3, "um": 1e-6, "m": 1.0, "Pa": 1.0}


def to_si(settings: dict) -> dict:
    """Settings with unit suffixes in their keys, as SI under the bare names.

    ``{"youngs_modulus_GPa": 78}`` becomes ``{"youngs_modulus": 78e9}``; a key
    without a known unit is kept, lists and nested settings are converted too.
    """
    converted = {}
    for key, value in settings.items():
        name, _, unit = key.rpartition("_")
        factor = SI_FACTORS.get(unit) if name else None
        if isinstance(value, dict):
            converted[key] = to_si(value)
        elif factor is None:
            converted[key] = value
        elif value is None:
            converted[name] = None
        elif isinstance(value, list | tuple):
            converted[name] = [_scaled(item, unit) for item in value]
        else:
            converted[name] = _scaled(value, unit)
    return converted


def _scaled(value: float, unit: str) -> float:
    """Value times its unit, rounded as the decimal number that was written."""
    written = Decimal(f"{float(value):.15g}")
    return float(written.scaleb(round(math.log10(SI_FACTORS[unit]))))


class Rock(NamedTuple):
    """Intact rock of a wall: Young's modulus [Pa], nu [-], sigma_c [Pa]."""

    youngs_modulus: float
    poisson_ratio: float
    compressive_strength: float


class Effects(NamedTuple):
    """Which effects a scene has; see `check_scene` for the 18 well-posed ones."""

    substrate: bool = True
    interaction: bool = True
    breakage: bool = True
    gouge: bool = True
    soft_peaks: bool = True


def scene_name(effects: Effects) -> str:
    """Name of a scene: its effects joined by hyphens, or "hertz_only" where it has none."""
    return "-".join(name for name, on in effects._asdict().items() if on) or "hertz_only"


def scene_of(name: str) -> Effects:
    """The scene of a name that `scene_name` gave."""
    return Effects(*(effect in name.split("-") for effect in Effects._fields))


class Choices(NamedTuple):
    """What the paper leaves open.

    ``base_radius_in_cells`` is r/h in (0, 1]; ``peak_modulus_ratio`` the
    modulus of a peak over the rock's; ``concave`` how valleys and saddles
    count ("magnitude"); ``peaks`` whether peaks are those of the "pristine"
    or of the "current" walls; ``largest_radius`` [m] bounds each wall's
    Gaussian radius from above (None: unbounded, as in the paper);
    ``tie_tolerance`` is the difference in height that counts as lower, over
    the roughness (rms of both walls; about 1e-12 m for the paper's walls).
    """

    base_radius_in_cells: float = 0.5
    peak_modulus_ratio: float = 0.05
    concave: Literal["magnitude"] = "magnitude"
    peaks: Literal["pristine", "current"] = "pristine"
    largest_radius: float | None = None
    tie_tolerance: float = 2e-9


class Numerics(NamedTuple):
    """Steps [m] and tolerances; ``later_``: every branch after the first loading.

    ``breakage`` is the paper's "fixed_step", by which every contact that breaks
    is lowered, or "resolved": a contact loses what brings it back to its
    strength, and the displacement steps, from the given ones on, follow an
    estimate of their error. ``tolerance`` then is what mean closures may be off
    by (docs/decisions/0010-resolved-breakage.md), in (0, 0.1]; the breakage
    steps are not used.

    ``force_tolerance`` is the relative residual of equilibrium that the fast
    solver reaches; ``sweep_tolerance`` the largest relative change of a force
    between two sweeps at which the reference stops (the paper's 1 %, which is
    no bound of the error). ``stress_tolerance`` is the relative distance to the
    target stress that ends a loading when ``target`` is "equilibrate";
    "interpolate" is the paper's linear interpolation.

    Without breakage the fast solver takes no steps: it solves for
    ``curve_points`` evenly spaced stresses up to the maximum, to a residual of
    1e-10 or the ``force_tolerance``, whichever is smaller.

    A simulation ends with a status that says so beyond ``most_steps`` displacement
    steps, or ``most_breakage_steps`` breakage steps for each of its cells. Where it can
    be foreseen that it will, it is refused; infinity lifts a bound. By default they are
    some thousand times what the paper's joints take.
    """

    displacement_step: float = 12.5e-6
    breakage_step: float = 5e-6
    later_displacement_step: float = 6.25e-6
    later_breakage_step: float = 2.5e-6
    target: Literal["equilibrate", "interpolate"] = "equilibrate"
    stress_tolerance: float = 1e-3
    force_tolerance: float = 1e-8
    sweep_tolerance: float = 0.01
    solver: str = "fast"
    curve_points: int = 20
    breakage: Literal["fixed_step", "resolved"] = "fixed_step"
    tolerance: float = 0.02
    most_steps: float = 1e5
    most_breakage_steps: float = 1e6


class ContactLaw(NamedTuple):
    """Constants of every pair of cells, derived from rock, choices and grid.

    The arrays have four entries, by the pair's state: 2 x (upper cell is a
    soft peak) + (lower cell is one).
    """

    spacing: float
    base_radius: float
    least_curvature: float
    substrate_modulus: float  # 1/(1/E_t* + 1/E_b*) [Pa]
    substrate: float  # compliance A [m/N], 0 without substrate
    asperity_modulus: np.ndarray  # E_a* [Pa], Eq. (4)
    critical_indentation: np.ndarray  # q = delta_break/R_a, Eq. (22)
    breaking_force: np.ndarray  # 4/3 E_a* q^(3/2) [Pa]


class InputError(ValueError):
    """A value that the model cannot take; the message names it."""


def real_array(name: str, values) -> np.ndarray:
    """Values as a new float64 array; `InputError` where they are no real numbers.

    Floats of any size and integers are promoted (or rounded) to float64, in
    any memory order. Complex, object, boolean, text and masked values are
    refused, never converted, and so is what is not finite.
    """
    if np.ma.is_masked(values):
        raise InputError(f"{name}: has masked values; fill or crop them first")
    try:
        given = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: is not an array of numbers ({error})") from None
    if given.dtype.kind not in "fiu":
        raise InputError(
            f"{name}: values of type {given.dtype}, must be real numbers (floats or integers)"
        )
    with np.errstate(over="ignore"):  # a long double may not fit, and is then not finite
        numbers = np.array(given, dtype=np.float64, order="C")
    bad = np.argwhere(~np.isfinite(numbers))
    if bad.size:
        where = ", ".join(str(index) for index in bad[0])
        axes = " (y, x) =" if numbers.ndim == 2 else ""
        raise InputError(f"{name}: {len(bad)} values are not finite, the first at{axes} ({where})")
    return numbers


def in_double(settings):
    """A `Rock`, `Choices` or `Numerics` with its numbers as Python's own.

    A numpy.float32 in it would otherwise make single precision of all that it
    meets, as numpy lets a Python float give way to it.
    """
    kinds = {np.floating: float, np.integer: int}
    return settings._replace(
        **{
            name: kinds[kind](value)
            for name, value in settings._asdict().items()
            for kind in kinds
            if isinstance(value, kind)
        }
    )


def both_walls(rock) -> tuple[Rock, Rock]:
    """(upper, lower) rocks, from one rock or a pair of rocks.

    Raises
    ------
    InputError
        Not a rock, or a property out of its range.
    """
    pair = (rock, rock) if isinstance(rock, Rock) else rock
    if (
        not isinstance(pair, tuple | list)
        or len(pair) != 2
        or not all(isinstance(wall, Rock) for wall in pair)
    ):
        raise InputError(f"rock: {rock!r} is neither a Rock nor a pair (upper, lower) of them")
    for wall in pair:
        check_rock(wall)
    return in_double(pair[0]), in_double(pair[1])


def check_rock(rock: Rock) -> None:
    """Raise `InputError` where a property of the rock is out of its range."""
    _positive("youngs_modulus", rock.youngs_modulus, "Pa")
    _positive("compressive_strength", rock.compressive_strength, "Pa", may_be_infinite=True)
    check_number("poisson_ratio", rock.poisson_ratio)
    if not 0.0 <= rock.poisson_ratio <= 0.5:
        raise InputError(f"poisson_ratio = {rock.poisson_ratio!r}: must lie in [0, 0.5]")


def check_scene(effects: Effects) -> None:
    """Refuse the combinations of effects that have no answer.

    Raises
    ------
    InputError
        Interaction without substrate: the operator is indefinite, so that
        equilibrium need not exist nor be unique. Gouge without breakage:
        nothing makes it.
    """
    if not isinstance(effects, Effects):
        raise InputError(f"effects = {effects!r}: must be an Effects")
    for name, value in effects._asdict().items():
        if not isinstance(value, bool | np.bool_):
            raise InputError(f"effects: {name} = {value!r}: must be True or False")
    if effects.interaction and not effects.substrate:
        raise InputError(
            "effects: interaction = True needs substrate = True; without the substrate's own "
            "compliance the interaction operator is indefinite and equilibrium is not unique"
        )
    if effects.gouge and not effects.breakage:
        raise InputError("effects: gouge = True needs breakage = True, which makes the gouge")


def well_posed_scenes() -> Iterator[Effects]:
    """The 18 combinations of effects that have an answer."""
    for substrate, interaction in ((False, False), (True, False), (True, True)):
        for breakage, gouge in ((False, False), (True, False), (True, True)):
            for soft_peaks in (False, True):
                yield Effects(substrate, interaction, breakage, gouge, soft_peaks)


def check_choices(choices: Choices, spacing: float) -> None:
    """Raise `InputError` where a choice is not among those allowed on a grid of a spacing [m].

    Radii may not be bounded below the spacing: an asperity is a cell; of sharper ones
    strength is next to none, and resolved breakage takes them down in ever smaller losses.
    """
    if not isinstance(choices, Choices):
        raise InputError(f"choices = {choices!r}: must be a Choices")
    for name in ("base_radius_in_cells", "peak_modulus_ratio", "tie_tolerance"):
        check_number(name, getattr(choices, name))
    if not 0.0 < choices.base_radius_in_cells <= 1.0:
        raise InputError(
            f"base_radius_in_cells = {choices.base_radius_in_cells!r}: must lie in (0, 1]; beyond "
            "a cell the neighbour lies under the base, where Eqs. (17) and (18) do not hold"
        )
    if not 0.0 < choices.peak_modulus_ratio <= 1.0:
        raise InputError(f"peak_modulus_ratio = {choices.peak_modulus_ratio!r}: must be in (0, 1]")
    _one_of("concave", choices.concave, ("magnitude",))
    _one_of("peaks", choices.peaks, ("pristine", "current"))
    if choices.largest_radius is not None:
        check_length("largest_radius", choices.largest_radius)
        if choices.largest_radius < spacing:
            raise InputError(
                f"largest_radius = {choices.largest_radius!r} m: must be at least the grid "
                f"spacing, {spacing!r} m, as an asperity is a cell (or None: unbounded)"
            )
    if not 0.0 < choices.tie_tolerance < 1e-3:
        raise InputError(f"tie_tolerance = {choices.tie_tolerance!r}: must lie in (0, 0.001)")


def check_numerics(numerics: Numerics, solvers: tuple[str, ...]) -> None:
    """Raise `InputError` where a step or tolerance is out of its range."""
    if not isinstance(numerics, Numerics):
        raise InputError(f"numerics = {numerics!r}: must be a Numerics")
    for prefix in ("", "later_"):
        step = getattr(numerics, f"{prefix}displacement_step")
        loss = getattr(numerics, f"{prefix}breakage_step")
        _positive(f"{prefix}displacement_step", step, "m")
        _positive(f"{prefix}breakage_step", loss, "m")
        if loss >= step:
            raise InputError(
                f"{prefix}breakage_step = {loss!r} m: must be smaller than "
                f"{prefix}displacement_step = {step!r} m"
            )
    check_number("curve_points", numerics.curve_points, whole=True)
    if numerics.curve_points < 1:
        raise InputError(f"curve_points = {numerics.curve_points!r}: must be at least 1")
    _one_of("breakage", numerics.breakage, ("fixed_step", "resolved"))
    check_number("tolerance", numerics.tolerance)
    if not 0.0 < numerics.tolerance <= 0.1:
        raise InputError(f"tolerance = {numerics.tolerance!r}: must lie in (0, 0.1]")
    if numerics.breakage == "resolved" and numerics.solver != "fast":
        raise InputError(
            f"breakage = 'resolved': not with solver = {numerics.solver!r}, which is the paper's "
            "own loop; use the fast solver"
        )
    if numerics.breakage == "resolved" and numerics.target != "equilibrate":
        raise InputError("breakage = 'resolved': not with target = 'interpolate'; use equilibrate")
    _one_of("target", numerics.target, ("equilibrate", "interpolate"))
    _one_of("solver", numerics.solver, solvers)
    for name in ("most_steps", "most_breakage_steps"):
        check_number(name, getattr(numerics, name))
        if not getattr(numerics, name) >= 1.0:
            raise InputError(f"{name} = {getattr(numerics, name)!r}: must be at least 1")
    for name in ("stress_tolerance", "force_tolerance", "sweep_tolerance"):
        check_number(name, getattr(numerics, name))
        if not SMALLEST_TOLERANCE <= getattr(numerics, name) < 1.0:
            raise InputError(
                f"{name} = {getattr(numerics, name)!r}: must lie in [{SMALLEST_TOLERANCE:g}, 1); "
                "rounding allows no less"
            )


def contact_law(
    spacing: float, rock: tuple[Rock, Rock], effects: Effects, choices: Choices
) -> ContactLaw:
    """Constants of the contact law of both walls on a grid of this spacing [m]."""
    moduli = [plane_strain_modulus(wall.youngs_modulus, wall.poisson_ratio) for wall in rock]
    ratio = choices.peak_modulus_ratio if effects.soft_peaks else 1.0
    softness = [(1.0, 1.0), (1.0, ratio), (ratio, 1.0), (ratio, ratio)]
    asperity_modulus = np.array(
        [equivalent_modulus(moduli[0] * upper, moduli[1] * lower) for upper, lower in softness]
    )
    limit = min(wall.compressive_strength / strength_factor(wall.poisson_ratio) for wall in rock)
    critical = np.array([critical_indentation(limit, modulus) for modulus in asperity_modulus])
    substrate_modulus = equivalent_modulus(*moduli)
    base_radius = choices.base_radius_in_cells * spacing
    return ContactLaw(
        spacing=float(spacing),
        base_radius=float(base_radius),
        least_curvature=1.0 / choices.largest_radius if choices.largest_radius else 0.0,
        substrate_modulus=float(substrate_modulus),
        substrate=float(substrate_compliance(base_radius, substrate_modulus))
        if effects.substrate
        else 0.0,
        asperity_modulus=asperity_modulus,
        critical_indentation=critical,
        breaking_force=4.0 / 3.0 * asperity_modulus * critical * np.sqrt(critical),
    )


def check_number(name: str, value: object, whole: bool = False) -> None:
    """Raise `InputError` unless a value is a real number (a whole one), and not a boolean."""
    kinds = (int, np.integer) if whole else (int, float, np.integer, np.floating)
    if isinstance(value, bool | np.bool_) or not isinstance(value, kinds):
        raise InputError(f"{name} = {value!r}: must be a {'whole ' if whole else ''}number")
    if not whole and isinstance(value, int) and abs(value) > sys.float_info.max:
        raise InputError(f"{name} = {value!r}: must be a number that fits in double precision")


def check_length(name: str, value: float) -> None:
    """Raise `InputError` unless a length [m] is positive and within `LENGTHS`."""
    _positive(name, value, "m")
    if not LENGTHS[0] <= value <= LENGTHS[1]:
        raise InputError(
            f"{name} = {value!r} m: must lie in [{LENGTHS[0]:g}, {LENGTHS[1]:g}] m; the "
            "curvature's twelfth powers of lengths do not fit in double precision beyond"
        )


def _positive(name: str, value: float, unit: str, may_be_infinite: bool = False) -> None:
    check_number(name, value)
    if not value > 0.0 or (math.isinf(value) and not may_be_infinite):
        raise InputError(f"{name} = {value!r} {unit}: must be positive and finite")


def _one_of(name: str, value: str, allowed: tuple[str, ...]) -> None:
    if not isinstance(value, str) or value not in allowed:
        raise InputError(f"{name} = {value!r}: must be one of {', '.join(allowed)}")

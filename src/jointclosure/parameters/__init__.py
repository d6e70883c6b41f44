"""Parameters of a simulation in SI units: rocks, effects, choices and numerics."""

from collections.abc import Callable, Iterator
from functools import wraps
from typing import Annotated, Any, Literal, NamedTuple, TypeVar, get_args, get_origin

import numpy as np

from jointclosure.inputs import InputError, check_length, check_number, check_one_of, check_positive
from jointclosure.parameters.units import (
    Property,
    check_inside,
    in_unit,
    properties_of,
    unit_meant,
)


class Rock(NamedTuple):
    """Properties of the intact rock of a wall [SI].

    ``Rock(...)`` raises `InputError` for a property that is out of its range; ``_replace`` does not
    check. The annotation of each field states its unit, range, symbol and title. A property with a
    default may be left out of a configuration, and of ``Rock(...)``.

    Attributes
    ----------
    youngs_modulus : float
        Young's modulus E [Pa].
    poisson_ratio : float
        Poisson's ratio nu, from 0 to 0.5.
    compressive_strength : float
        Uniaxial compressive strength sigma_c [Pa].
    """

    youngs_modulus: Annotated[float, Property("Young's modulus", "GPa", "E", usual=(1e8, 3e11))]
    poisson_ratio: Annotated[float, Property("Poisson's ratio", "1", "nu", "[0, 0.5]")]
    compressive_strength: Annotated[
        float, Property("compressive strength", "MPa", "sigma_c", None, True, (2.5e5, 1e9))
    ]


OF_ROCK = properties_of(Rock)
"""Units, ranges, symbols and titles of the properties of a `Rock`, by name."""
_JRC = Property("JRC", "1", "JRC", "[0, 20]")
_FIRST = ("poisson_ratio", "youngs_modulus", "compressive_strength", "jrc")
"""Rows of the paper's Table 3, in its order."""
PROPERTIES = {name: (OF_ROCK | {"jrc": _JRC})[name] for name in dict.fromkeys((*_FIRST, *OF_ROCK))}
"""All properties that a study can vary, by name. Those of the paper come first, in its order."""


def key_of(name: str) -> str:
    """Return the configuration key of a property, which ends in its unit."""
    unit = PROPERTIES[name].unit
    return name if unit == "1" else f"{name}_{unit}"


USUAL = {name: (*about.usual, about.si_unit) for name, about in OF_ROCK.items() if about.usual} | {
    "max_normal_stress": (1e3, 1e9, "Pa"),
    "seating_stress": (10.0, 1e9, "Pa"),
    "snapshots": (1e3, 1e9, "Pa"),
    "spacing": (1e-6, 0.1, "m"),
    "side_of_scan": (5e-3, 10.0, "m"),
    **dict.fromkeys(("displacement_step", "later_displacement_step"), (1e-9, 1e-3, "m")),
    **dict.fromkeys(("breakage_step", "later_breakage_step"), (1e-10, 1e-3, "m")),
    "largest_radius": (1e-6, 1.0, "m"),
    **dict.fromkeys(("roll_off", "mismatch_wavelength"), (1e-5, 0.5, "m")),
}
"""Smallest and largest usual value, and their unit, of inputs by name. Another value, unless it is
0 or infinite, is probably in a wrong unit."""
AS_IT_IS = (
    "unusual_values=True (on the command line --unusual-values, in a configuration "
    "study.unusual_values: allow) takes it as it is"
)
"""Advice on accepting an unusual value: the last part of the messages that refuse one."""


class Effects(NamedTuple):
    """Physical effects that a simulation includes.

    Interaction needs the substrate, and gouge needs breakage: simulations raise `InputError` for
    other combinations, but ``Effects(...)`` does not check them.

    Attributes
    ----------
    substrate : bool
        Half-spaces below the asperities deform, Eqs. (6) and (7).
    interaction : bool
        Contacts displace each other, Eqs. (17) and (18).
    breakage : bool
        Overloaded asperities break, Eqs. (21) to (23).
    gouge : bool
        Broken material fills the valleys around.
    soft_peaks : bool
        Peaks have a lower modulus than the rock.
    """

    substrate: bool = True
    interaction: bool = True
    breakage: bool = True
    gouge: bool = True
    soft_peaks: bool = True


AUTO_TOLERANCE = 0.02  # relative change of mean closure below which `effects: auto` leaves one out


def scene_name(effects: Effects) -> str:
    """Return the name of a scene, which is a set of effects: their names joined by hyphens.

    Without any effect it is "hertz_only".
    """
    return "-".join(name for name, on in effects._asdict().items() if on) or "hertz_only"


def scene_of(name: str) -> Effects:
    """Return the effects of the scene of a name, as made by `scene_name`."""
    return Effects(*(effect in name.split("-") for effect in Effects._fields))


# Annotations of numbers in an interval, some with the reason, which messages append.
_Part = Annotated[float, "(0, 1]"]
_OfBase = Annotated[
    float,
    "(0, 1]",
    "; with larger bases a neighbour lies on the base, where Eqs. (17) and (18) do not hold",
]
_Tolerance = Annotated[float, "[1e-14, 1)", "; rounding allows no less"]
_Most = Annotated[float, "[1, inf]"]


class Choices(NamedTuple):
    """Decisions on the model that the paper leaves open.

    ``Choices(...)`` raises `InputError` for a value that is not allowed; ``_replace`` does not
    check.

    Attributes
    ----------
    base_radius_in_cells : float
        Radius of a contact's base over the grid spacing, r/h, in (0, 1].
    peak_modulus_ratio : float
        Modulus of a peak over that of the rock, in (0, 1].
    concave : {"magnitude", "flat"}
        Curvature of valleys and saddles: its absolute value, or 0 for a wall one of whose two
        profiles is not convex.
    peaks : {"pristine", "current"}
        Whether peaks are those of the walls before loading or as they are.
    largest_radius : float or None
        Upper bound of each wall's Gaussian radius [m]. None: unbounded, as in the paper.
    strength_bound : {"base", "none"}
        Upper bound of a contact's strength. "base": the force at which the mean pressure over the
        base of the asperity is that of a Hertz contact at its strength. "none": as in the paper,
        where the first cycle has no limit (docs/decisions.md#0010-resolved-breakage).
    crushed_strength_ratio : float
        Strength of crushed rock over that of the rock, in (0, 1]: of a pair of cells of which one
        lies below its pristine height when a loading begins. 1: as in the paper.
    tie_tolerance : float
        Smallest difference in height that makes a cell lower than its neighbour, over the rms
        height of both walls: about 3e-13 m in the paper's study.
    """

    base_radius_in_cells: _OfBase = 0.5
    peak_modulus_ratio: _Part = 0.05
    concave: Literal["magnitude", "flat"] = "magnitude"
    peaks: Literal["pristine", "current"] = "pristine"
    largest_radius: float | None = None
    strength_bound: Literal["base", "none"] = "base"
    crushed_strength_ratio: _Part = 1.0
    tie_tolerance: Annotated[float, "(0, 0.001)"] = 2e-9


PLAUSIBLE: dict[str, tuple[Any, Any]] = {
    "peak_modulus_ratio": (0.0125, 0.2),
    "base_radius_in_cells": (0.35, 0.71),
    "peaks": ("pristine", "current"),
}
"""Plausible values of what the paper leaves open, by field of `Choices`: the ends of a range, or
the alternatives. The usual value is the middle of a range by logarithms. ASSUMPTION: the ends; the
paper cites two sources for a ratio of 0.05. The circle around a cell has a radius of 0.71 spacings,
the circle inside it 0.5."""


class Numerics(NamedTuple):
    """Steps [m], tolerances and solver of a simulation.

    ``Numerics(...)`` raises `InputError` for a value that is not allowed; ``_replace`` does not
    check.

    Attributes
    ----------
    displacement_step : float
        Displacement step of the first loading [m].
    later_displacement_step : float
        Displacement step of every later branch [m].
    breakage_step : float
        Height that each broken contact loses in a step of the first loading [m].
    later_breakage_step : float
        Height that each broken contact loses in a step of a later branch [m].
    target : {"equilibrate", "interpolate"}
        How a loading meets its maximum: within ``stress_tolerance``, or by the linear interpolation
        of the paper.
    stress_tolerance : float
        Relative distance to the maximum stress within which a loading ends.
    force_tolerance : float
        Relative residual of equilibrium that the fast solver reaches.
    sweep_tolerance : float
        Largest relative change of a force between two sweeps at which the reference solver stops.
        It is 1 % in the paper, which does not bound the error.
    solver : {"fast", "reference"}
        Solver of equilibrium.
    curve_points : int
        Number of evenly spaced stresses up to the maximum where nothing breaks. The fast solver
        then takes no steps, and solves to a residual of 1e-8 or the ``force_tolerance``, whichever
        is smaller.
    breakage : {"fixed_step", "resolved"}
        What a broken contact loses: the breakage step, as in the paper, or only the height that
        brings it back to its strength. Then displacement steps start from those given and follow an
        estimate of their error; breakage steps are not used.
    tolerance : float
        Accepted relative error of mean closures where breakage is resolved, in (0, 0.1]
        (docs/decisions.md#0010-resolved-breakage).
    most_steps : float
        Largest number of displacement steps; infinity is no bound. A simulation that exceeds it
        ends with a status, one that is foreseen to is refused. Joints of the paper need about a
        thousandth of the default.
    most_breakage_steps : float
        Largest number of breakage steps over that of the cells, likewise.
    replay : bool
        Whether a cycle that repeats the load of the cycle before is copied from its unloading
        curve, if nothing broke on it (docs/decisions.md#0005-protocol).
    idle_interaction : float
        Share of the closure below which displacements by interaction are left out on the first
        loading (docs/effects.md).
    """

    displacement_step: float = 12.5e-6
    breakage_step: float = 5e-6
    later_displacement_step: float = 6.25e-6
    later_breakage_step: float = 2.5e-6
    target: Literal["equilibrate", "interpolate"] = "equilibrate"
    stress_tolerance: _Tolerance = 1e-3
    force_tolerance: _Tolerance = 1e-4
    sweep_tolerance: _Tolerance = 0.01
    solver: Literal["fast", "reference"] = "fast"
    curve_points: Annotated[int, "[1, 100000]"] = 20
    breakage: Literal["fixed_step", "resolved"] = "fixed_step"
    tolerance: Annotated[float, "(0, 0.1]"] = 0.02
    most_steps: _Most = 1e5
    most_breakage_steps: _Most = 1e6
    replay: bool = True
    idle_interaction: Annotated[float, "[0, 1)"] = 0.0


RESOLVED = Numerics(
    breakage="resolved",
    tolerance=0.02,
    displacement_step=3e-6,
    later_displacement_step=3e-6,
    breakage_step=1e-6,
    later_breakage_step=1e-6,
)
"""Default numerics of a scanned joint: breakage is resolved. The steps, from which resolved
breakage starts, are short enough for smooth curves and for a loading without a kink where it lands
on its maximum."""
SOLVER_NAMES: tuple[str, ...] = get_args(Numerics.__annotations__["solver"])
"""Names of the solvers of equilibrium (`solvers.registry.solver_named`)."""


_Settings = TypeVar("_Settings", Rock, Choices, Numerics)


def in_double(settings: _Settings) -> _Settings:
    """Return a `Rock`, `Choices` or `Numerics` with Python's float and int for NumPy's numbers."""
    numbers: dict[str, Any] = {
        name: float(value) if isinstance(value, np.floating) else int(value)
        for name, value in settings._asdict().items()
        if isinstance(value, np.floating | np.integer)
    }
    return settings._replace(**numbers)


def acting(rock: Rock) -> list[str]:
    """Return the names of the properties of a rock that differ from their defaults.

    A default is neutral: the property has no effect then. Properties without one are all returned.
    """
    neutral = Rock._field_defaults
    return [name for name, value in rock._asdict().items() if value != neutral.get(name)]


def check_rock(rock: Rock) -> None:
    """Raise `InputError` if a property of the rock is out of its range."""
    for name, about in OF_ROCK.items():
        about.check(name, getattr(rock, name))


def check_usual(rocks: tuple[Rock, ...], **values: Any) -> None:
    """Raise `InputError` if an input is no number or outside of its usual range (`USUAL`).

    The inputs are the properties of ``rocks``, and ``values`` [SI] by name. None, 0 and infinity
    are accepted. Names that are not in `USUAL` are not checked.
    """
    for values_by_name in (*(rock._asdict() for rock in rocks), values):
        for name, value in values_by_name.items():
            if name not in USUAL or value is None:
                continue
            check_number(name, value)
            low, high, unit = USUAL[name]
            if value < 0.0:  # no question of the unit, and never accepted
                raise InputError(f"{name} = {value!r} {unit}: must be positive")
            if not (low <= value <= high or value == 0.0 or np.isinf(value)):
                stated = OF_ROCK[name].unit if name in OF_ROCK else unit
                number = in_unit(value, stated)
                shown = f" ({number:g} {stated})" if stated != unit and number >= 1.0 else ""
                raise InputError(
                    f"{name} = {value!r} {unit}{shown}: not usual of rock ({low:g} to {high:g} "
                    f"{unit}); {unit_meant(value, low, high, unit)} {AS_IT_IS}"
                )


def check_scene(effects: Effects) -> None:
    """Raise `InputError` unless effects are an `Effects` of booleans in a well-posed combination.

    Interaction needs the substrate, and gouge needs breakage.
    """
    if not isinstance(effects, Effects):
        raise InputError(f"effects = {effects!r}: must be an Effects")
    for name, value in effects._asdict().items():
        if not isinstance(value, bool | np.bool_):
            raise InputError(f"effects: {name} = {value!r}: must be True or False")
    if effects.interaction and not effects.substrate:
        raise InputError(
            "effects: substrate = False needs interaction = False; without the compliance of the "
            "substrate the interaction operator is indefinite and equilibrium is not unique"
        )
    if effects.gouge and not effects.breakage:
        raise InputError("effects: breakage = False needs gouge = False, as breakage makes gouge")


def well_posed_scenes() -> Iterator[Effects]:
    """Generate all combinations of effects that `check_scene` accepts."""
    for substrate, interaction in ((False, False), (True, False), (True, True)):
        for breakage, gouge in ((False, False), (True, False), (True, True)):
            for soft_peaks in (False, True):
                yield Effects(substrate, interaction, breakage, gouge, soft_peaks)


def _check_fields(settings: Any, kind: type[NamedTuple]) -> None:
    """Raise `InputError` unless settings are of a ``kind``, and their fields have allowed values.

    Only fields are checked whose annotation states the allowed words (`Literal`) or the interval
    (`Annotated`), or is bool. Callers check the others.
    """
    if not isinstance(settings, kind):
        raise InputError(f"{kind.__name__.lower()} = {settings!r}: must be a {kind.__name__}")
    for name, value in settings._asdict().items():
        hint: Any = kind.__annotations__[name]
        if get_origin(hint) is Literal:
            check_one_of(name, value, get_args(hint))
        elif hint is bool and not isinstance(value, bool | np.bool_):
            raise InputError(f"{name} = {value!r}: must be True or False")
        elif hasattr(hint, "__metadata__"):
            check_number(name, value, whole=hint.__origin__ is int)
            check_inside(name, value, *hint.__metadata__)


def check_choices(choices: Choices) -> None:
    """Raise `InputError` unless choices are a `Choices` of allowed values."""
    _check_fields(choices, Choices)
    check_crushed_strength(choices)
    if choices.largest_radius is not None:
        check_length("largest_radius", choices.largest_radius)


def check_crushed_strength(choices: Choices) -> None:
    """Raise `InputError` for weaker crushed rock together with ``peaks`` = "current".

    The strength of crushed rock needs the pristine state of the walls, which is then not kept.
    """
    if choices.crushed_strength_ratio < 1.0 and choices.peaks == "current":
        raise InputError(
            f"crushed_strength_ratio = {choices.crushed_strength_ratio!r}: must be 1 with peaks = "
            "'current', where a pair's pristine state is not kept"
        )


def check_radius(choices: Choices, spacing: float) -> None:
    """Raise `InputError` if the ``largest_radius`` of choices is below the grid spacing [m]."""
    if choices.largest_radius is not None and choices.largest_radius < spacing:
        raise InputError(
            f"largest_radius = {choices.largest_radius!r} m: must be at least the grid "
            f"spacing, {spacing!r} m, as an asperity is a cell (or None: unbounded)"
        )


def check_numerics(numerics: Numerics) -> None:
    """Raise `InputError` unless numerics are a `Numerics` of allowed values that fit each other.

    A fixed breakage step must be smaller than the displacement step, and resolved breakage needs
    the fast solver and ``target`` = "equilibrate".
    """
    _check_fields(numerics, Numerics)
    for prefix in ("", "later_"):
        step = getattr(numerics, f"{prefix}displacement_step")
        loss = getattr(numerics, f"{prefix}breakage_step")
        check_positive(f"{prefix}displacement_step", step, "m")
        check_positive(f"{prefix}breakage_step", loss, "m")
        if numerics.breakage == "fixed_step" and loss >= step:
            raise InputError(
                f"{prefix}breakage_step = {loss!r} m: must be smaller than "
                f"{prefix}displacement_step = {step!r} m"
            )
    for name, needed in (("solver", "fast"), ("target", "equilibrate")):
        if numerics.breakage == "resolved" and getattr(numerics, name) != needed:
            raise InputError(
                f"breakage = 'resolved': not with {name} = {getattr(numerics, name)!r}, which is "
                f"of the loop of the paper; use {needed!r}"
            )


def check_model(effects: Effects, choices: Choices, numerics: Numerics) -> None:
    """Raise `InputError` if an effect, a choice or a numerical setting is not allowed."""
    check_scene(effects)
    check_choices(choices)
    check_numerics(numerics)


class _Need(NamedTuple):
    """Condition on effects, choices and numerics that a setting needs to have an effect.

    ``where`` completes the message "has no effect ..." if the condition does not hold.
    """

    holds: Callable[[Effects, Choices, Numerics], bool]
    where: str


def _takes_steps(effects: Effects, choices: Choices, numerics: Numerics) -> bool:
    """Return whether a simulation takes displacement steps, and is not one elastic curve."""
    return effects.breakage or numerics.solver == "reference"


def _base_acts(effects: Effects, choices: Choices, numerics: Numerics) -> bool:
    """Return whether the radius of the base of asperities has an effect.

    It has one on the compliance of the substrate, and on the bound of the strength.
    """
    return effects.substrate or (effects.breakage and choices.strength_bound == "base")


_STEPS = _Need(_takes_steps, "without breakage, where solver = 'fast' takes no steps")
_CURVE = _Need(
    lambda *model: not _takes_steps(*model),
    "with steps, which breakage and solver = 'reference' take",
)
_BREAKAGE = _Need(lambda effects, *_: effects.breakage, "without breakage")
_INTERACTION = _Need(lambda effects, *_: effects.interaction, "without interaction")
_SOFT_PEAKS = _Need(lambda effects, *_: effects.soft_peaks, "without soft_peaks")
_BASE = _Need(_base_acts, "without substrate, and without breakage with strength_bound = 'base'")
_FIXED = _Need(
    lambda *model: model[2].breakage == "fixed_step",
    "on resolved breakage, needs breakage = 'fixed_step'",
)
_RESOLVED = _Need(
    lambda *model: model[2].breakage == "resolved",
    "on fixed steps of breakage, needs breakage = 'resolved'",
)
_FAST = _Need(lambda *model: model[2].solver == "fast", "on solver = 'reference'")
_REFERENCE = _Need(lambda *model: model[2].solver == "reference", "on solver = 'fast'")
_NEEDS: dict[str, tuple[_Need, ...]] = {
    **dict.fromkeys(("displacement_step", "later_displacement_step", "target"), (_STEPS,)),
    **dict.fromkeys(("breakage_step", "later_breakage_step"), (_BREAKAGE, _FIXED)),
    "force_tolerance": (_FAST,),
    "sweep_tolerance": (_REFERENCE,),
    "curve_points": (_CURVE,),
    "tolerance": (_BREAKAGE, _RESOLVED),
    "most_breakage_steps": (_BREAKAGE,),
    "replay": (_STEPS,),
    "idle_interaction": (_INTERACTION, _STEPS),
    "base_radius_in_cells": (_BASE,),
    "peak_modulus_ratio": (_SOFT_PEAKS,),
    "peaks": (_SOFT_PEAKS, _BREAKAGE),
    "crushed_strength_ratio": (_BREAKAGE,),
    "tie_tolerance": (_BREAKAGE,),
}
"""Conditions that a field of `Choices` or `Numerics` needs to have an effect, by name.

A field that is not among them always has an effect, or all its values are usual ones, which are
accepted whatever the effects are: ``strength_bound`` is "base" in the library and "none" in the
paper, and ``breakage`` is resolved by `jointclosure.close` and not by `jointclosure.simulate`.
"""


_USUAL_SETTINGS = Choices(), Numerics(), RESOLVED


def without_effect(name: str, effects: Effects, choices: Choices, numerics: Numerics) -> str:
    """Return why a field of `Choices` or `Numerics` has no effect in a model; "" if it has one.

    The text is such as "without breakage". ``name`` is that of the field.
    """
    model = effects, choices, numerics
    return next((need.where for need in _NEEDS.get(name, ()) if not need.holds(*model)), "")


def check_effective(
    effects: Effects,
    choices: Choices,
    numerics: Numerics,
    usual: Numerics = Numerics(),
    varied: bool = False,
) -> None:
    """Raise `InputError` for a setting that was changed from a usual value, but has no effect.

    Usual values are accepted everywhere, so that effects can be left out without other changes.
    They are those of ``Choices()``, ``Numerics()`` and `RESOLVED`, and the ``usual`` ones of a
    function. ``varied`` is whether simulations with fewer effects are compared too: a setting may
    then have its effect in any of them. The settings must have passed `check_model`.
    """
    scenes = [effects]
    if varied:
        scenes += [fewer for fewer in well_posed_scenes() if _is_part(fewer, effects)]
    usual_values = *_USUAL_SETTINGS, usual
    for name, value in (choices._asdict() | numerics._asdict()).items():
        if any(value == getattr(settings, name, None) for settings in usual_values):
            continue
        reasons = [without_effect(name, scene, choices, numerics) for scene in scenes]
        if all(reasons):
            raise InputError(f"{name} = {value!r}: has no effect {reasons[0]}; leave it out")


def _is_part(fewer: Effects, effects: Effects) -> bool:
    """Return whether all effects in ``fewer`` are among the ``effects``."""
    return all(not one or other for one, other in zip(fewer, effects, strict=True))


def _check_when_made(settings: type[NamedTuple], check: Callable[[Any], None]) -> None:
    """Make the constructor of a named tuple check each instance, by replacing its ``__new__``.

    ``_replace`` and ``_make`` do not use the constructor, and so do not check.
    """
    make = settings.__new__

    @wraps(make)
    def made_and_checked(*arguments: Any, **fields: Any) -> Any:
        """Make an instance and check it."""
        instance = make(*arguments, **fields)
        check(instance)
        return instance

    settings.__new__ = made_and_checked  # type: ignore[method-assign]


_check_when_made(Rock, check_rock)
_check_when_made(Choices, check_choices)
_check_when_made(Numerics, check_numerics)

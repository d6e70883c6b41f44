"""What a simulation is told: rocks, effects, choices and numerics, all in SI."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import wraps
from typing import Annotated, Any, Literal, NamedTuple, TypeVar

import numpy as np

from jointclosure.inputs import InputError, check_length, check_number, check_one_of, check_positive
from jointclosure.parameters.properties import Property, properties_of

SMALLEST_TOLERANCE = 1e-14
"""Of what is to be met relatively: about fifty roundings."""


class Rock(NamedTuple):
    """Intact rock of a wall [SI]: all that is known of a property stands with its field.

    A property with a default may be left out of a configuration, and of ``Rock(...)``.
    """

    youngs_modulus: Annotated[float, Property("Young's modulus", "GPa", "E", usual=(1e8, 3e11))]
    poisson_ratio: Annotated[float, Property("Poisson's ratio", "1", "nu", (0.0, 0.5))]
    compressive_strength: Annotated[
        float,
        Property(
            "compressive strength", "MPa", "sigma_c", may_be_infinite=True, usual=(2.5e5, 1e9)
        ),
    ]


OF_ROCK = properties_of(Rock)
"""What is known of the properties of a `Rock`, by name."""
_JRC = Property("JRC", "1", "JRC", (0.0, 20.0), heading="Joint roughness coefficient (JRC)")
_FIRST = ("poisson_ratio", "youngs_modulus", "compressive_strength", "jrc")
"""Rows of the paper's Table 3, in its order."""
PROPERTIES = {name: (OF_ROCK | {"jrc": _JRC})[name] for name in dict.fromkeys((*_FIRST, *OF_ROCK))}
"""All properties that a study can vary, by name: those of the paper first, in its order."""


def key_of(name: str) -> str:
    """The key of a property in a configuration, with its unit."""
    unit = PROPERTIES[name].unit
    return name if unit == "1" else f"{name}_{unit}"


def rock_of(values: Mapping[str, float]) -> Rock:
    """The rock of properties by name [SI]; others are ignored, and defaults stand for missing."""
    return Rock(**{name: values[name] for name in OF_ROCK if name in values})


def strength_of(wall: Rock) -> float:
    """Compressive strength that a wall has for the model [Pa]: equations take it from here."""
    return wall.compressive_strength


USUAL = {name: (*about.usual, about.si_unit) for name, about in OF_ROCK.items() if about.usual} | {
    "max_normal_stress": (1e3, 1e9, "Pa"),
    "spacing": (1e-6, 0.1, "m"),
    "side_of_scan": (5e-3, 10.0, "m"),
}
"""Least and largest values that are usual of rock and its joints, and their unit: what lies
beyond is more often a slip of units."""
AS_IT_IS = (
    "unusual_values=True (on the command line --set study.unusual_values=allow) takes it as it is"
)
"""How a caller goes on all the same, at the end of what refuses an unusual value."""


class Effects(NamedTuple):
    """Which effects act; `check_scene` says which combinations are well-posed."""

    substrate: bool = True
    interaction: bool = True
    breakage: bool = True
    gouge: bool = True
    soft_peaks: bool = True


AUTO_TOLERANCE = 0.02
"""Change of a mean maximum closure below which `effects: auto` leaves an effect out [1]."""


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
    count: by the size of their curvature ("magnitude"), or as "flat", which a wall then is
    where either of its profiles is not convex; ``peaks`` whether peaks are those of the "pristine"
    or of the "current" walls; ``largest_radius`` [m] bounds each wall's
    Gaussian radius from above (None: unbounded, as in the paper);
    ``tie_tolerance`` is the difference in height that counts as lower, over
    the roughness (rms of both walls; about 1e-12 m for the paper's walls).
    """

    base_radius_in_cells: float = 0.5
    peak_modulus_ratio: float = 0.05
    concave: Literal["magnitude", "flat"] = "magnitude"
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

    With ``replay`` a cycle like the one before is the curve of that one's unloading, up and down,
    where that broke nothing (docs/decisions/0005-protocol.md); without, every state of it is solved
    for and searched for breakage again.

    With an ``idle_interaction`` above 0 the interaction is left out of the first loading as long as
    it would displace no contact by more than this share of the closure (docs/effects.md).

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
    force_tolerance: float = 1e-5
    sweep_tolerance: float = 0.01
    solver: str = "fast"
    curve_points: int = 20
    breakage: Literal["fixed_step", "resolved"] = "fixed_step"
    tolerance: float = 0.02
    most_steps: float = 1e5
    most_breakage_steps: float = 1e6
    replay: bool = True
    idle_interaction: float = 0.0


_Settings = TypeVar("_Settings", Rock, Choices, Numerics)


def in_double(settings: _Settings) -> _Settings:
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


def both_walls(rock: Rock | Sequence[Rock]) -> tuple[Rock, Rock]:
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
    for name, about in OF_ROCK.items():
        about.check(name, getattr(rock, name))


def check_usual(rocks: tuple[Rock, ...], **values: float) -> None:
    """Raise `InputError` where a number is not usual of rock and its joints, see `USUAL`.

    Parameters
    ----------
    rocks : tuple of Rock
    **values : float
        Others by name, [SI].
    """
    for given in (*(rock._asdict() for rock in rocks), values):
        for name, value in given.items():
            low, high, unit = USUAL.get(name, (-np.inf, np.inf, ""))
            if not low <= value <= high and not np.isinf(value):
                raise InputError(
                    f"{name} = {value!r} {unit}: not usual of rock ({low:g} to {high:g} {unit}); "
                    f"is the unit right? {AS_IT_IS}"
                )


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
    """The combinations of effects that have an answer."""
    for substrate, interaction in ((False, False), (True, False), (True, True)):
        for breakage, gouge in ((False, False), (True, False), (True, True)):
            for soft_peaks in (False, True):
                yield Effects(substrate, interaction, breakage, gouge, soft_peaks)


def check_choices(choices: Choices, spacing: float = 0.0) -> None:
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
    check_one_of("concave", choices.concave, ("magnitude", "flat"))
    check_one_of("peaks", choices.peaks, ("pristine", "current"))
    if choices.largest_radius is not None:
        check_length("largest_radius", choices.largest_radius)
        if choices.largest_radius < spacing:
            raise InputError(
                f"largest_radius = {choices.largest_radius!r} m: must be at least the grid "
                f"spacing, {spacing!r} m, as an asperity is a cell (or None: unbounded)"
            )
    if not 0.0 < choices.tie_tolerance < 1e-3:
        raise InputError(f"tie_tolerance = {choices.tie_tolerance!r}: must lie in (0, 0.001)")


def check_numerics(numerics: Numerics, solvers: tuple[str, ...] | None = None) -> None:
    """Raise `InputError` where a step or tolerance is out of its range; of solvers, where given."""
    if not isinstance(numerics, Numerics):
        raise InputError(f"numerics = {numerics!r}: must be a Numerics")
    for prefix in ("", "later_"):
        step = getattr(numerics, f"{prefix}displacement_step")
        loss = getattr(numerics, f"{prefix}breakage_step")
        check_positive(f"{prefix}displacement_step", step, "m")
        check_positive(f"{prefix}breakage_step", loss, "m")
        if loss >= step:
            raise InputError(
                f"{prefix}breakage_step = {loss!r} m: must be smaller than "
                f"{prefix}displacement_step = {step!r} m"
            )
    check_number("curve_points", numerics.curve_points, whole=True)
    if numerics.curve_points < 1:
        raise InputError(f"curve_points = {numerics.curve_points!r}: must be at least 1")
    check_one_of("breakage", numerics.breakage, ("fixed_step", "resolved"))
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
    check_one_of("target", numerics.target, ("equilibrate", "interpolate"))
    if not isinstance(numerics.replay, bool | np.bool_):
        raise InputError(f"replay = {numerics.replay!r}: must be True or False")
    check_number("idle_interaction", numerics.idle_interaction)
    if not 0.0 <= numerics.idle_interaction < 1.0:
        raise InputError(f"idle_interaction = {numerics.idle_interaction!r}: must lie in [0, 1)")
    if solvers is not None:
        check_one_of("solver", numerics.solver, solvers)
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


def _check_when_made(settings: type[NamedTuple], check: Callable[[Any], None]) -> None:
    """Have instances of a named tuple checked when they are made by its name."""
    make = settings.__new__

    @wraps(make)
    def made_and_checked(*arguments: Any, **fields: Any) -> Any:
        instance = make(*arguments, **fields)
        check(instance)
        return instance

    settings.__new__ = made_and_checked  # type: ignore[method-assign]


_check_when_made(Rock, check_rock)
_check_when_made(Choices, check_choices)
_check_when_made(Numerics, check_numerics)

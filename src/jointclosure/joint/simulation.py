"""Simulate one joint: the public functions `simulate` and `equilibrium`."""

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Unpack

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from jointclosure.inputs import LENGTHS, InputError, check_length, check_number, naming
from jointclosure.joint import cycling
from jointclosure.joint.attributes import ATTRIBUTES
from jointclosure.joint.checked_conditions import (
    CheckedConditions,
    check_together,
    model_attributes,
)
from jointclosure.joint.conditions import (
    Changes,
    Conditions,
    conditions_from,
    takes_conditions,
)
from jointclosure.joint.cycle_results import unloading_excess
from jointclosure.joint.feasibility import (
    check_elastic_steps,
    check_feasible,
    joint_strength,
)
from jointclosure.joint.history import history_of
from jointclosure.joint.load import LoadCycle, check_snapshots
from jointclosure.joint.rocks import both_walls
from jointclosure.joint.snapshots import Snapshots, fields_of
from jointclosure.joint.stated_conditions import checked_as_stated
from jointclosure.joint.status import UNLOADING
from jointclosure.joint.wall_checks import checked_walls, warn_of_doubts
from jointclosure.parameters import (
    AS_IT_IS,
    USUAL,
    Choices,
    Effects,
    Numerics,
    Rock,
    check_effective,
    check_model,
    check_radius,
    check_usual,
    in_double,
)
from jointclosure.solvers.joint import Joint, Solver
from jointclosure.solvers.registry import solver_named


@takes_conditions
def simulate(
    upper: ArrayLike,
    lower: ArrayLike,
    *,
    conditions: Conditions | CheckedConditions | None = None,
    report: cycling.StepReport | None = None,
    snapshots: Sequence[float] = (),
    pristine: Sequence[ArrayLike] | None = None,
    **changes: Unpack[Changes],
) -> xr.Dataset:
    """Simulate a joint of two walls under cycles of normal load.

    The walls are pressed together to a maximum stress and unloaded, once in each cycle. The
    equations of the model, with their sources, are in docs/model.md.

    By default rock breaks in the fixed steps of the paper. `jointclosure.close` has resolved
    breakage by default, which is more accurate and takes longer, so that both give other results
    for the same walls (docs/reference.md#steps-of-breakage has the size of the difference). Here
    ``numerics=Numerics(breakage="resolved")`` resolves breakage.

    Parameters
    ----------
    upper, lower : array (ny, nx)
        Heights towards the other wall [m], real and finite; not changed. Any
        float or integer type is converted to float64. Note that single precision
        resolves heights of 1e-3 m to 6e-11 m only, a thousandth of the overlap at
        which the flank of an asperity breaks. Complex, object, boolean and masked
        heights are refused. The dimensions of an `xarray.DataArray` are used by
        name, and the coordinates of both walls have to agree.
    conditions : Conditions, optional
        Rock, load and model.
    report : callable, optional
        Called at every step with its cycle, its branch ("loading" or "unloading") and
        its stress over the maximum of the cycle. Without breakage, where the default solver takes
        no steps, it is not called.
    snapshots : sequence of float
        Stresses from 0 to the largest [Pa] at which the state of the joint is stored, on each
        branch: where the branch first passes the stress, the state of the nearer step is
        stored. It changes no other result.
    pristine : (upper, lower), optional
        Walls (ny, nx) [m] before anything broke, for walls that were crushed before: soft peaks
        and crushed cells are determined from these. By default the walls that are closed.
    **changes
        Fields of `jointclosure.Conditions`: ``spacing``, ``rock`` and ``max_normal_stress`` are
        required if there are no ``conditions``; ``cycles``, ``seating_stress``, ``effects``,
        ``choices``, ``numerics``, ``flow``, ``unusual_values``.

    Returns
    -------
    xarray.Dataset
        Along ``step``, starting with (0, 0): ``closure`` [m] from first
        touch, ``normal_stress`` [Pa], ``contact_fraction``,
        ``bulk_indentation`` [m], ``mean_aperture`` [m] (void volume over nominal area: the mean of
        the distance of the deformed walls, which is 0 in contacts), ``mean_overlap`` [m] (the sum
        of the overlaps delta_S of contacts over the number of cells), ``equilibrium_residual``,
        with coordinates ``load_cycle`` and ``branch``. Along ``cycle`` (1, 2): ``max_closure`` and
        ``residual_closure`` [m], both also ``_seated``
        (`jointclosure.joint.history.Curve.cycle_closures`), ``locked_share`` and
        ``flat_share`` of the force at the maximum, ``unloading_excess`` [Pa], the largest
        excess of the stress on unloading over that on loading. The walls at the end,
        ``status`` (bits, below 16 a success; see its attributes), and counts of the effort.
        Rock, spacing, load, effects, choices and numerics are attributes. With ``flow`` also,
        along ``step`` and ``direction``: ``hydraulic_aperture`` [m], NaN where ``flow_status`` is
        not_solved or at_least, its bounds ``smallest_hydraulic`` and ``largest_hydraulic`` [m],
        and ``flow_imbalance``. With ``snapshots``, along ``snapshot``: ``snapshot_upper``,
        ``snapshot_lower`` [m], ``snapshot_force`` [N], ``snapshot_gap`` [m] (negative where walls
        are pressed together) and ``snapshot_broken_volume`` [m3], with the requested stress,
        cycle, branch and step as coordinates; and the walls at first touch.

    Raises
    ------
    InputError
        If an argument is out of its range, or more steps are foreseen than ``numerics``
        allows. It is raised before the simulation starts.

    Notes
    -----
    The model is that of Rezaei Niya & Selvadurai, see docs/model.md.
    The ``max_closure`` of a cycle is the closure at its maximum less that at its
    start, and its ``residual_closure`` is the closure at its end. Without
    breakage the closure does not depend on the history: the steps are then
    ``Numerics.curve_points`` stresses (and the seating stress) up and down one curve.
    """
    stated = conditions_from(conditions, changes, "simulate", "spacing")
    checked = checked_as_stated(stated, snapshots)
    return simulate_as_checked(upper, lower, checked, report, snapshots, pristine)


def simulate_as_checked(
    upper: ArrayLike,
    lower: ArrayLike,
    checked: CheckedConditions,
    report: cycling.StepReport | None = None,
    snapshots: Sequence[float] = (),
    pristine: Sequence[ArrayLike] | None = None,
) -> xr.Dataset:
    """Simulate two walls (y, x) [m] as `simulate`, under conditions from `checked_as_stated`.

    The ``snapshots`` [Pa] must have been checked with the conditions. Doubts about walls and load
    are warnings at the line that called the caller, unless unusual values are accepted.
    """
    spacing = checked.grid_spacing
    walls = checked_walls(upper, lower, spacing)
    if not checked.unusual_values:
        warn_of_doubts(*walls, spacing, stacklevel=4)
    simulation = Simulation(*walls, checked, snapshots, pristine)
    for doubt in [] if checked.unusual_values else simulation.near_strength():
        warnings.warn(doubt, stacklevel=3)
    return simulation.run(report)


def simulate_walls(
    upper: ArrayLike,
    lower: ArrayLike,
    conditions: CheckedConditions,
    report: cycling.StepReport | None = None,
    snapshots: Sequence[float] = (),
    pristine: Sequence[ArrayLike] | None = None,
    solver_of: Callable[[str], Solver] = solver_named,
) -> xr.Dataset:
    """Simulate two walls (y, x) [m] as `simulate`, under conditions that were checked before.

    Conditions that were changed since then are only checked for whether they fit each other.
    ``solver_of`` returns the solver of a name.
    """
    walls = checked_walls(upper, lower, conditions.grid_spacing)
    check_together(conditions)
    check_snapshots(snapshots, conditions.load)
    return Simulation(*walls, conditions, snapshots, pristine, solver_of).run(report)


NEAR_STRENGTH = 0.75
"""Maximum stress over the stress that all cells together carry, from which a simulation is slow."""
_USUAL_SHARE = 0.24
_TIMES_OF_USUAL = {NEAR_STRENGTH: (5, 18), 0.9: (12, 34)}
"""Smallest and largest time over the time at `_USUAL_SHARE` of the stress that all cells carry, by
the least share of it from which they apply
(benchmarks/results/near_strength/near_strength.csv)."""


class Simulation:
    """A joint of two walls, ready to be simulated once.

    Parameters
    ----------
    upper, lower : array (y, x)
        Walls [m], as from `checked_walls`.
    conditions : CheckedConditions
        With the spacing of the walls, checked for these ``snapshots``.
    snapshots, pristine
        As for `simulate`.
    solver_of : callable
        Returns the solver of a name.

    Raises
    ------
    InputError
        If the walls and the conditions do not fit each other: displacement steps are below the
        rounding of the heights, or more steps are foreseen than ``numerics`` allow.
    """

    def __init__(
        self,
        upper: np.ndarray,
        lower: np.ndarray,
        conditions: CheckedConditions,
        snapshots: Sequence[float] = (),
        pristine: Sequence[ArrayLike] | None = None,
        solver_of: Callable[[str], Solver] = solver_named,
    ) -> None:
        _check_step_lengths(upper, lower, conditions.numerics)
        choices = in_double(conditions.choices)
        numerics = in_double(conditions.numerics)
        self._has_run = False
        self.conditions = conditions
        self.snapshots = snapshots
        self.datums = height_datum(upper), height_datum(lower)
        self.solver = solver_of(numerics.solver)
        self.joint = Joint(
            upper - self.datums[0],
            lower - self.datums[1],
            conditions.grid_spacing,
            conditions.rock,
            conditions.effects,
            choices,
            numerics,
            _pristine(pristine, upper.shape, self.datums, choices),
        )
        self._strength = joint_strength(self.joint)
        largest = float(conditions.largest_stress)
        cycles = conditions.cycle_count
        if conditions.effects.breakage or self.solver.elastic_curve is None:
            check_feasible(self.joint, self._strength, largest, cycles)
        else:
            check_elastic_steps(numerics, cycles)

    @property
    def share_of_strength(self) -> float:
        """Largest stress of the load over the stress that all cells of the joint carry together.

        The joint is intact. It is 0 where nothing bounds the latter (`Strength`).
        """
        return float(self.conditions.largest_stress) / self._strength.of_joint

    def near_strength(self) -> list[str]:
        """Return a warning that the simulation will be slow, or nothing, as a list of sentences.

        It is slow if the stress is near the strength of all cells (`NEAR_STRENGTH`).
        """
        share = self.share_of_strength
        if share < NEAR_STRENGTH:
            return []
        longer = "many times as long as at lower stresses"
        if share < 1.0:
            least, most = _TIMES_OF_USUAL[max(at for at in _TIMES_OF_USUAL if at <= share)]
            longer = (
                f"roughly {least} to {most} times as long as at {100.0 * _USUAL_SHARE:.0f} % of it "
                "with 24 x 24 cells, more with more cells"
            )
        return [
            f"max_normal_stress (--stress) = {1e-6 * self.conditions.largest_stress:g} MPa is "
            f"{100.0 * share:.0f} % of the stress that all cells together carry: nearly all of "
            f"them break, and the simulation may take {longer} "
            "(docs/hard_cases.md#near-the-strength)"
        ]

    def run(self, report: cycling.StepReport | None = None) -> xr.Dataset:
        """Simulate the joint, whose walls are crushed in place; return the Dataset of `simulate`.

        ``report`` is as for `simulate`. Raise `RuntimeError` the second time, because the walls of
        the joint are then crushed.
        """
        if self._has_run:
            raise RuntimeError("a Simulation runs once: its walls are crushed now")
        self._has_run = True
        joint = self.joint
        conditions = self.conditions
        area = joint.area
        observers = list[Any]()
        if conditions.flow:
            from jointclosure.joint.flow import FlowAlongHistory  # loads scipy's sparse matrices

            observers.append(FlowAlongHistory())
        if len(self.snapshots):
            tolerance = joint.numerics.stress_tolerance
            observers.append(Snapshots(self.snapshots, tolerance, self.datums))
        forces = [
            LoadCycle(*(stress * area for stress in cycle)) for cycle in conditions.load.load_cycles
        ]
        seating_force = conditions.seating_stress * area
        history = cycling.run_cycles(joint, self.solver, forces, seating_force, report, observers)
        joint.upper += self.datums[0]
        joint.lower += self.datums[1]
        closed = _history_dataset(joint, history, area, conditions)
        for observer in observers:
            closed = observer.added_to(closed)
        return closed


def _pristine(
    walls: Sequence[ArrayLike] | None,
    shape: tuple[int, ...],
    datums: tuple[float, float],
    choices: Choices,
) -> tuple[np.ndarray, np.ndarray] | None:
    """Return checked pristine walls (y, x) [m], less the datums [m] of the walls that are closed.

    Return None if there are none. Raise `InputError` if they are not allowed or not of this
    ``shape``, or if soft peaks are those of the current walls.
    """
    if walls is None:
        return None
    if choices.peaks == "current":
        raise InputError("pristine: not with peaks = 'current', which are those of the walls")
    if not isinstance(walls, tuple | list) or len(walls) != 2:
        raise InputError(f"pristine of type {type(walls).__name__}: must be (upper, lower)")
    with naming("pristine"):
        upper, lower = checked_walls(*walls)
        if upper.shape != shape:
            raise InputError(f"shape {upper.shape}: must be that of the walls, {shape}")
    return upper - datums[0], lower - datums[1]


def height_datum(wall: np.ndarray) -> float:
    """Return a datum [m] to subtract from a wall (y, x) [m], so that an offset costs no digits.

    It is 0 unless the offset is large compared with the range of heights, so that most heights are
    not rounded anew. Otherwise it is a multiple of a power of 2. For a flat wall it is its height.
    """
    low = float(wall.min())
    high = float(wall.max())
    middle = 0.5 * low + 0.5 * high
    reach = high - low
    if reach == 0.0:
        return middle
    if abs(middle) < 4.0 * reach:
        return 0.0
    unit = 2.0 ** math.ceil(math.log2(reach))
    return round(middle / unit) * unit


def equilibrium(
    upper: ArrayLike,
    lower: ArrayLike,
    *,
    spacing: float,
    rock: str | Rock | Sequence[str | Rock],
    closure: float,
    effects: Effects = Effects(breakage=False, gouge=False),
    choices: Choices = Choices(),
    numerics: Numerics = Numerics(),
    unusual_values: bool = False,
) -> xr.Dataset:
    """Compute the forces between two walls at a closure, without breakage.

    Parameters
    ----------
    upper, lower, spacing, rock, choices, numerics, unusual_values
        As for `simulate`.
    closure : float
        Approach from first touch [m]. It is refused as unusual if it exceeds twice the depth of
        all voids plus the elastic approach under the largest usual stress.
    effects : Effects
        Breakage and gouge are always left out.

    Returns
    -------
    xarray.Dataset
        On (y, x): ``force`` [N], ``overlap`` [m] (delta_S, negative where
        the walls are apart), ``interaction_displacement`` [m]. And
        ``normal_stress`` [Pa], ``equilibrium_residual``, ``status``.

    Raises
    ------
    InputError
        If an argument is out of its range, or the closure takes a stress beyond what is usual;
        the first is raised before the computation starts.
    """
    check_length("spacing", spacing)
    upper, lower = checked_walls(upper, lower, spacing)
    pair = both_walls(rock)
    if isinstance(effects, Effects):  # else it is refused
        effects = effects._replace(breakage=False, gouge=False)
    check_model(effects, choices, numerics)
    check_effective(effects, choices, numerics)
    check_radius(choices, spacing)
    check_number("closure", closure)
    if not abs(closure) <= LENGTHS[1]:
        raise InputError(f"closure = {closure!r} m: must be at most {LENGTHS[1]:g} m")
    if not unusual_values:
        check_usual(pair, spacing=spacing)
        warn_of_doubts(upper, lower, spacing)
    spacing = float(spacing)
    closure = float(closure)
    choices = in_double(choices)
    numerics = in_double(numerics)
    upper = upper - height_datum(upper)
    lower = lower - height_datum(lower)
    joint = Joint(upper, lower, spacing, pair, effects, choices, numerics)
    largest_stress = USUAL["max_normal_stress"][1]
    most = cycling.closure_limit(joint, largest_stress * joint.area)
    if not unusual_values and closure > most:
        raise InputError(
            f"closure = {closure!r} m: not usual of this joint; usual stresses close it by at "
            f"most {most:.3g} m; is the unit right? {AS_IT_IS}"
        )
    run = solver_named(numerics.solver).settle(joint, closure, numerics.breakage_step)
    overlap, displacement = fields_of(joint, closure)
    status = np.int16(cycling.FLAG_OF_OUTCOME.get(run.outcome, 0))
    stress = run.total_force / joint.area
    if not unusual_values and stress > largest_stress:
        raise InputError(
            f"closure = {closure!r} m: takes a stress of {stress:.3g} Pa, must be at most the "
            f"usual {largest_stress:g} Pa; is the unit right? {AS_IT_IS}"
        )
    cells = {"force": joint.force, "overlap": overlap, "interaction_displacement": displacement}
    once = {"normal_stress": stress, "equilibrium_residual": run.residual, "status": status}
    attributes = {"title": "equilibrium of a rough joint"}
    attributes |= model_attributes(pair, spacing, effects, choices, numerics)
    variables = _variables((("y", "x"), cells), ((), once))
    return xr.Dataset(variables, _grid(upper.shape, spacing), attributes)


def _history_dataset(
    joint: Joint, history: cycling.StepRecord, area: float, conditions: CheckedConditions
) -> xr.Dataset:
    """Arrange the record of a simulated joint of an area [m2] as the Dataset of `simulate`."""
    load = conditions.load.load_cycles
    cycle, branch, settled, heights = zip(*history.steps, strict=True)
    attributes = {"title": "closure of a rough joint"} | conditions.attributes()

    def along(field: str) -> np.ndarray:
        return np.array([getattr(point, field) for point in settled])

    closure = along("closure")
    bulk = along("mean_interaction")
    overlap = along("mean_overlap")
    distance = joint.first_touch - np.array(heights) - closure + bulk
    along_step = {
        "closure": closure,
        "normal_stress": along("total_force") / area,
        "contact_fraction": along("contacts") / joint.upper.size,
        "bulk_indentation": bulk,
        "equilibrium_residual": along("residual"),
        "mean_aperture": np.maximum(distance + overlap, 0.0),  # not below by rounding
        "mean_overlap": overlap,
    }
    numbers = np.array(cycle, dtype=np.int32)
    coordinates = {
        "cycle": ("cycle", np.arange(1, len(load) + 1), {"long_name": "load cycle"}),
        "load_cycle": ("step", numbers, {"long_name": "load cycle of the step"}),
        "branch": ("step", np.array(branch), {"long_name": "branch of the load cycle"}),
    }
    coordinates |= _grid(joint.upper.shape, joint.law.spacing)
    closed = xr.Dataset(_variables(("step", along_step)), coordinates, attributes)
    reached = (1.0 + 1.01 * joint.numerics.stress_tolerance) * np.array(load)[:, 1]
    of_steps = history_of(closed)
    unloading = [of_steps.branch(number, UNLOADING) for number in range(1, len(load) + 1)]
    maxima = [settled[branch.steps[0]] if branch.steps.size else None for branch in unloading]
    along_cycle = of_steps.gross.cycle_closures(reached)
    along_cycle["unloading_excess"] = unloading_excess(closed, reached)
    for field in ("mean_interaction", "locked_share", "flat_share"):
        name = "max_bulk_indentation" if field == "mean_interaction" else field
        along_cycle[name] = np.array([getattr(point, field, np.nan) for point in maxima])
    effort = history.effort
    once = {
        "status": np.int16(history.status),
        "least_force": min(point.least_force for point in settled),
        "settled_states": effort.settled,
        "equilibria": effort.rounds,
        "newton_steps": effort.newton_steps,
        "breakage_steps": effort.breakage_steps,
        "replayed_cycles": history.replayed,
        "idle_steps": history.idle_steps,
        "idle_displacement": history.idle_displacement,
        "locked_contacts": max(point.locked_contacts for point in settled),
        "solver_iterations": effort.products,
    }
    walls = {"upper_final": joint.upper, "lower_final": joint.lower}
    groups = ("step", along_step), ("cycle", along_cycle), (("y", "x"), walls), ((), once)
    return xr.Dataset(_variables(*groups), closed.coords, attributes)


def _variables(*groups: tuple[Any, Mapping[str, Any]]) -> dict[str, tuple[Any, ...]]:
    """Return the variables of a Dataset by name, each as (dimensions, values, attributes).

    A group is the dimensions and the values by name that have them.
    """
    return {
        name: (dimensions, value, ATTRIBUTES[name])
        for dimensions, values in groups
        for name, value in values.items()
    }


def _grid(shape: tuple[int, int], spacing: float) -> dict[str, Any]:
    """Return coordinates [m] of the cells of a grid of a shape (y, x), with their attributes."""
    return {
        name: (name, np.arange(size) * spacing, {"long_name": f"{name} of the cell", "units": "m"})
        for name, size in zip(("y", "x"), shape, strict=True)
    }


def _check_step_lengths(upper: np.ndarray, lower: np.ndarray, numerics: Numerics) -> None:
    """Raise `InputError` for displacement steps of less than four roundings of the heights."""
    resolution = float(np.spacing(np.abs(upper).max() + np.abs(lower).max()))
    for name in ("displacement_step", "later_displacement_step"):
        if getattr(numerics, name) < 4.0 * resolution:
            raise InputError(
                f"{name} = {getattr(numerics, name)!r} m: must be at least four times the "
                f"resolution {resolution:.3g} m of the walls' heights in double precision"
            )

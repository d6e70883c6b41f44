"""Curves of a closed joint: closures of its history, per cycle and at given stresses, as tables."""

import json
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.joint.status import BRANCHES, FLAGS, LOADING, UNLOADING

NET, GROSS = "closure_net", "closure"
"""Names of closures: net, as laboratories report it, without the displacement of the half-spaces
under the loaded patch as a whole (docs/model.md, "Interaction"), or with it."""
LEVELS = 20  # most intervals of stress of a table, from seating to the maximum
_ROUND = 1.0, 2.0, 2.5, 5.0, 10.0  # first digits of a round interval
_APART = 0.25  # least distance of a round stress from the ends of a table, over the interval
POINTS = 60  # intervals of stress by which the slope of a curve is computed
_NEARLY = 1.01  # largest stress over that of a branch at which it counts as reached
LAST_CHORD = 0.15  # least part of the range of stress over which its last stiffness is read
WATER = 9.81 * 998.2 / (12.0 * 1.002e-3)
"""Transmissivity of water at 20 degrees [m2/s] over the cube of the hydraulic aperture [m]."""
KINDS = {"net": NET, "gross": GROSS}  # in names of columns
HYDRAULIC = "hydraulic_aperture", "smallest_hydraulic", "largest_hydraulic"
"""Variables of flow: the hydraulic aperture where it is known, and its bounds."""
TRANSMISSIVITIES = {
    "hydraulic_aperture_mm": "transmissivity_m2_per_s",
    "smallest_hydraulic_mm": "smallest_transmissivity_m2_per_s",
    "largest_hydraulic_mm": "largest_transmissivity_m2_per_s",
}
"""Columns of the transmissivity of water, and of its bounds, by those of apertures."""
FLOW_STATUSES = "flows", "blocked", "at_least", "not_solved"
"""Words of the status of a flow, from the one by which most is known."""
ONLY_BOUNDS = FLOW_STATUSES[2:]
"""Statuses at which the hydraulic aperture is missing, and only its bounds are known."""


def read_along(history: xr.Dataset, of: str | np.ndarray = NET) -> np.ndarray:
    """Return a variable by name, or given values, at each step (steps,); by default net closure."""
    if isinstance(of, np.ndarray):
        return of
    if of == NET:
        return history.closure.values - history.bulk_indentation.values
    return history[of].values


def branch_of(history: xr.Dataset, cycle: int, branch: str) -> np.ndarray:
    """Return indices of the steps (n,) on one branch of one cycle, including its start."""
    here = np.flatnonzero((history.load_cycle.values == cycle) & (history.branch.values == branch))
    if here.size and here[0] > 0:
        here = np.concatenate([[here[0] - 1], here])
    return here


def _branches(history: xr.Dataset, cycles: int) -> Iterator[tuple[tuple[int, int], np.ndarray]]:
    """Generate the place (cycle, branch) and the steps (n,) of each branch that has any."""
    for place in np.ndindex(cycles, 2):
        here = branch_of(history, place[0] + 1, BRANCHES[place[1]])
        if here.size > 1:
            yield place, here


def maxima_of(history: xr.Dataset) -> np.ndarray:
    """Return the stated maximum stress (cycles,) [Pa] of each cycle that was begun."""
    stated = np.atleast_1d(history.attrs["max_normal_stress_Pa"])[::2]  # turning points, or one
    begun = int(history.load_cycle.max())
    return stated[:begun] if stated.size > 1 else np.broadcast_to(stated, begun)


def former_maximum(history: xr.Dataset, cycle: int) -> float:
    """Return the largest stated maximum [Pa] before a cycle that exceeds it; 0 if it does not."""
    stated = maxima_of(history)
    former = float(stated[: cycle - 1].max(initial=0.0))
    return former if stated[cycle - 1] > former else 0.0


def with_snapshots(history: xr.Dataset, stresses: Sequence[float]) -> xr.Dataset:
    """Return a history with the snapshots at some stresses [Pa] only; as if closed with these."""
    if len(stresses):
        return history.isel(snapshot=history.snapshot_stress.isin(stresses))
    states = [name for name in history.variables if str(name).startswith("snapshot_")]
    return history.drop_vars([*states, "upper_first", "lower_first"], errors="ignore")


def _whole_cycles(
    history: xr.Dataset, minima: np.ndarray
) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Generate index, loading and unloading of the cycles that were unloaded to a minimum [Pa]."""
    stress = history.normal_stress.values
    for index, minimum in enumerate(minima):
        loading, unloading = (branch_of(history, index + 1, name) for name in BRANCHES)
        if min(loading.size, unloading.size) > 1 and stress[unloading[-1]] <= minimum:
            yield index, loading, unloading


def crossing(stress: np.ndarray, values: np.ndarray, level: float, branch: str = LOADING) -> float:
    """Return the value where the stress (n,) [Pa] is first (unloading: last) at a level, or NaN."""
    reached = np.flatnonzero(stress >= level)
    if reached.size == 0:
        return float("nan")
    at = int(reached[0 if branch == LOADING else -1])
    before = at - 1 if branch == LOADING else at
    if not 0 <= before < stress.size - 1:
        return float(values[at])
    rise = stress[before + 1] - stress[before]
    part = (level - stress[before]) / rise
    return float(values[before] + part * (values[before + 1] - values[before]))


def by_fixed_steps(history: xr.Dataset) -> bool:
    """Return whether the history has the paper's fixed steps."""
    return json.loads(history.attrs.get("numerics", "{}")).get("breakage") == "fixed_step"


def cubic_over(stress: np.ndarray, values: np.ndarray) -> Callable[[Any], Any]:
    """Return values (n,) as a monotone cubic of stress where that exceeds all before; or NaN.

    NaN also between two stresses of which one has an unknown value, NaN.
    """
    rises = np.concatenate([[True], stress[1:] > np.maximum.accumulate(stress)[:-1]])
    stress, values = stress[rises], values[rises]
    known = np.isfinite(values)
    if known.sum() < 2:
        at = dict(zip(stress.tolist(), values.tolist(), strict=True))
        return np.vectorize(lambda level: at.get(level, np.nan), otypes=[float])
    cubic = scipy.interpolate.PchipInterpolator(stress[known], values[known], extrapolate=False)
    if known.all():
        return cubic

    def where_known(level: Any) -> np.ndarray:
        sides = (np.searchsorted(stress, level, side) for side in ("left", "right"))
        after, beyond = (np.minimum(at, stress.size - 1) for at in sides)
        before = np.where(stress[after] == level, after, np.maximum(beyond - 1, 0))
        return np.where(known[before] & known[after], cubic(level), np.nan)

    return where_known


def values_where(
    history: xr.Dataset, here: np.ndarray, values: np.ndarray, levels: np.ndarray, branch: str
) -> np.ndarray:
    """Read values where the stress of steps ``here`` first reaches levels (n,) [Pa], or NaN."""
    stress, known = history.normal_stress.values[here], values[here]
    if by_fixed_steps(history):
        return np.array([crossing(stress, known, level, branch) for level in levels])
    order = slice(None, None, 1 if branch == LOADING else -1)
    return cubic_over(stress[order], known[order])(levels)


def seat_of(history: xr.Dataset, cycle: int, branch: str, of: str = NET) -> float:
    """Read the net closure [m], or the variable ``of``, at the seating stress of a branch."""
    here = branch_of(history, cycle, branch)
    seating = float(history.attrs["seating_stress_Pa"])
    if not here.size or history.normal_stress.values[here].min() > seating:
        return float("nan")
    along = read_along(history, of)
    return float(values_where(history, here, along, np.array([seating]), branch)[0])


def cycle_closures(
    history: xr.Dataset, of: str = NET, minima: np.ndarray | None = None
) -> dict[str, np.ndarray]:
    """Compute the closures of each cycle (cycles,) [m]; NaN unless unloaded to its minimum [Pa]."""
    closure = read_along(history, of)
    minima = np.full(int(history.load_cycle.max()), np.inf) if minima is None else minima
    names = ("max_closure", "residual_closure", "max_closure_seated", "residual_closure_seated")
    closures = np.full((len(names), len(minima)), np.nan)
    for index, loading, unloading in _whole_cycles(history, minima):
        seat, back = (seat_of(history, index + 1, name, of) for name in BRANCHES)
        maximum, end = closure[loading[-1]], closure[unloading[-1]]
        closures[:, index] = maximum - closure[loading[0]], end, maximum - seat, back - seat
    return dict(zip(names, closures, strict=True))


def unloading_excess(history: xr.Dataset, minima: np.ndarray) -> np.ndarray:
    """Return the largest excess of unloading over loading at equal closure (cycles,) [Pa]."""
    closure, stress = history.closure.values, history.normal_stress.values
    excess = np.full(len(minima), np.nan)
    for index, loading, unloading in _whole_cycles(history, minima):
        # keep the last of several steps at one closure
        at, last = np.unique(closure[loading][::-1], return_index=True)
        loaded = stress[loading][::-1][last]
        after = closure[unloading[1:]]
        next_one = np.minimum(np.searchsorted(at, after), at.size - 1)
        if np.array_equal(at[next_one], after):
            below = loaded[next_one]  # both branches have the same steps: no interpolation
        else:
            below = np.minimum(loaded[next_one], loaded[np.maximum(next_one - 1, 0)])
            if at.size > 1 and np.any(stress[unloading[1:]] >= below):
                # a monotone cubic lies between its neighbours, and is not needed above unloading
                cubic = scipy.interpolate.PchipInterpolator(at, loaded)
                below = cubic(np.clip(after, at[0], at[-1]))
        below[after < at[0]] = 0.0 if stress[loading[0]] == 0.0 else np.inf
        excess[index] = max(0.0, float(np.max(stress[unloading[1:]] - below)))
    return excess


def values_at_stresses(
    history: xr.Dataset, values: np.ndarray, cycles: int, levels: np.ndarray, tolerance: float = 0.0
) -> np.ndarray:
    """Read values of steps, such as closures, at stresses of both branches (cycles, 2, levels)."""
    answer = np.full((cycles, 2, levels.size), np.nan)
    near = 1.0 + 1.01 * tolerance
    for place, here in _branches(history, cycles):
        stress = history.normal_stress.values[here]
        maximum, minimum = stress.max(), stress.min()
        read = np.where((levels < minimum) & (minimum <= levels * near), minimum, levels)
        read = np.where((maximum < read) & (read <= maximum * near), maximum, read)
        asked = read >= minimum
        branch = BRANCHES[place[1]]
        answer[(*place, asked)] = values_where(history, here, values, read[asked], branch)
    return answer


def loop_between(loading: Any, unloading: Any) -> Any:
    """Return closures of unloading less those of loading, both at the same stress."""
    loop = unloading - loading
    return loop * (abs(loop) > 1e-12 * abs(loading))  # less is rounding


def spacing_of(history: xr.Dataset) -> float:
    """Return the spacing of a joint's cells [m], from their coordinates."""
    axes = (history[name].values for name in ("y", "x"))
    return next(float(axis[1] - axis[0]) for axis in axes if axis.size > 1)


def area_of(history: xr.Dataset) -> float:
    """Return the nominal area of a joint [m2], from the coordinates of its cells."""
    return spacing_of(history) ** 2 * history.sizes["y"] * history.sizes["x"]


def curve_table(history: xr.Dataset) -> pd.DataFrame:
    """Tabulate closure over stress by cycle and branch, one row per step."""
    area, rows = area_of(history), []
    closures = {kind: read_along(history, of) for kind, of in KINDS.items()}
    for (index, side), here in _branches(history, int(history.load_cycle.max())):
        columns: dict[str, Any] = {"cycle": index + 1, "branch": BRANCHES[side]}
        columns["normal_stress_MPa"] = 1e-6 * history.normal_stress.values[here]
        for kind, of in KINDS.items():
            since = closures[kind][here] - seat_of(history, index + 1, LOADING, of)
            columns[f"closure_{kind}_since_seating_mm"] = 1e3 * since
        columns |= {f"closure_{kind}_mm": 1e3 * along[here] for kind, along in closures.items()}
        aperture = history.mean_aperture.values[here]
        contact = history.contact_fraction.values[here]
        columns |= {
            "mean_aperture_mm": 1e3 * aperture,
            "void_volume_mm3": 1e9 * area * aperture,
            "contact_area_mm2": 1e6 * area * contact,
            "contact_fraction": contact,
        }
        flow = {name: values[here] for name, values in _flow_columns(history).items()}
        rows.append(pd.DataFrame(columns | flow))
    return pd.concat(rows, ignore_index=True)


def has_flow(history: xr.Dataset) -> bool:
    """Return whether a history has hydraulic apertures."""
    return "hydraulic_aperture" in history


def flow_statuses(history: xr.Dataset) -> np.ndarray:
    """Return the status of the flow in words (steps, directions)."""
    words = np.array(history.flow_status.attrs["flag_meanings"].split(), dtype=object)
    return words[history.flow_status.values.astype(int)]


def flow_status_at(history: xr.Dataset, levels: np.ndarray) -> np.ndarray:
    """Return the status of the flow (cycles, 2, levels) at stresses [Pa], in words.

    It is the one by which least is known, along both directions and at the steps on both sides of
    the stress; "" where the stress is not reached.
    """
    rank = np.vectorize(FLOW_STATUSES.index)(flow_statuses(history)).max(axis=1)
    ranks = np.zeros((int(history.load_cycle.max()), 2, levels.size), dtype=int)
    for least in range(1, len(FLOW_STATUSES)):
        ranks += closures_at(history, levels, (rank >= least).astype(float)) > 0.0
    reached = np.isfinite(closures_at(history, levels, np.zeros(rank.size)))
    return np.where(reached, np.array(FLOW_STATUSES, dtype=object)[ranks], "")


def _flow_columns(history: xr.Dataset) -> dict[str, np.ndarray]:
    """Return hydraulic apertures (steps,), their bounds, status, and ratio to the mean aperture."""
    columns: dict[str, np.ndarray] = {}
    for at, along in enumerate(history.direction.values if has_flow(history) else ()):
        known = {name: history[name].sel(direction=along).values for name in HYDRAULIC}
        columns |= {f"{name}_{along}_mm": 1e3 * values for name, values in known.items()}
        aperture, mean = known["hydraulic_aperture"], history.mean_aperture.values
        ratio = np.divide(aperture, mean, out=np.full(mean.shape, np.nan), where=mean > 0.0)
        columns[f"hydraulic_ratio_{along}"] = ratio
        columns[f"flow_status_{along}"] = flow_statuses(history)[:, at]
    return columns


def net_responses(history: xr.Dataset) -> dict[str, np.ndarray]:
    """Return the net closures of each cycle, as a laboratory reports them, and the stiffness: the
    chord of a loading from half of its maximum, or from a higher former maximum.
    """
    completed = np.isfinite(history.max_closure.values)
    begun, net = int(history.load_cycle.max()), cycle_closures(history)
    seated = "max_closure_seated", "residual_closure_seated"
    responses = {f"{name}_net": net[name] for name in ("max_closure", *seated)}
    stiffness = [
        secant_stiffness(history, cycle, max(0.5 * end, former_maximum(history, cycle)), end)
        for cycle, end in enumerate(maxima_of(history).tolist(), start=1)
    ]
    landing = [landing_stress(history, cycle + 1) for cycle in range(begun)]
    responses |= {"stiffness_net": np.array(stiffness), "landing_stress": np.array(landing)}
    missing = (0, completed.size - begun)
    return {
        name: np.where(completed, np.pad(values, missing, constant_values=np.nan), np.nan)
        for name, values in responses.items()
    }


def cycle_table(history: xr.Dataset) -> pd.DataFrame:
    """Tabulate the closures of each cycle, since seating as in laboratory reports."""
    numbers = np.unique(history.load_cycle.values)
    columns = {"cycle": numbers}
    for net, of in (("_net", NET), ("", GROSS)):
        read = cycle_closures(history, of)
        closures = {name: 1e3 * values[numbers - 1] for name, values in read.items()}
        since, residual = closures["max_closure_seated"], closures["residual_closure_seated"]
        columns[f"max_closure_seated{net}_mm"] = since
        columns[f"residual_closure_seated{net}_mm"] = residual
        columns[f"residual_share{net}"] = residual / since
        columns[f"max_closure{net}_mm"] = closures["max_closure"]
    seats = [seat_of(history, number, LOADING, "mean_aperture") for number in numbers]
    columns["mean_aperture_at_seating_mm"] = 1e3 * np.array(seats)
    highest = [next(iter(branch_of(history, number, UNLOADING)), -1) for number in numbers]
    states = {"mean_aperture_mm": 1e3 * history.mean_aperture.values} | _flow_columns(history)
    for name, values in (states | {"contact": history.contact_fraction.values}).items():
        if "ratio" not in name:
            column = f"{name.removesuffix('_mm')}_at_max{'_mm' if name.endswith('_mm') else ''}"
            columns[column] = np.where(np.array(highest) < 0, np.nan, values[highest])
    return pd.DataFrame(columns)


def hysteresis(closed: xr.Dataset) -> np.ndarray:
    """Compute the share (cycles,) of each cycle's work of loading lost on unloading."""
    closure, stress = closed.closure.values, closed.normal_stress.values
    shares = np.full(closed.max_closure.size, np.nan)
    for index, loading, unloading in _whole_cycles(closed, np.full(shares.size, np.inf)):
        given = np.trapezoid(stress[loading], closure[loading])
        back = -np.trapezoid(stress[unloading], closure[unloading])
        shares[index] = 1.0 - back / given if given > 0.0 else np.nan
    return shares


def stress_levels(history: xr.Dataset, count: int = LEVELS, cycle: int | None = None) -> np.ndarray:
    """Return evenly spaced stresses [Pa] from the seating stress to the largest reached stress."""
    seating = float(history.attrs["seating_stress_Pa"])
    largest = float(history.normal_stress.max())
    if cycle is not None:
        reached = float(history.normal_stress.values[history.load_cycle.values == cycle].max())
        largest = largest if largest <= _NEARLY * reached else reached
    return np.linspace(seating, largest, count + (seating == 0.0))[(seating == 0.0) :]


def round_levels(low: float, high: float) -> np.ndarray:
    """Return both stresses [Pa], a low one of 0 excepted, and multiples of a round one between."""
    least = (high - low) / LEVELS
    power = 10.0 ** np.floor(np.log10(least))
    interval = next(digits * power for digits in _ROUND if digits * power >= (1.0 - 1e-9) * least)
    inner = interval * np.arange(np.floor(low / interval) + 1.0, np.ceil(high / interval))
    inner = inner[np.minimum(inner - low, high - inner) > _APART * interval]
    return np.array([*[low] * (low > 0.0), *inner, high])


def table_levels(history: xr.Dataset, at: Sequence[float] = ()) -> np.ndarray:
    """Return the stresses [Pa] of `stress_table`: round ones from the seating stress to the stated
    maximum, the maximum of every cycle, and those that are named, ``at``.

    A joint that did not reach its maximum has its largest stress in place of it.
    """
    maxima, reached = maxima_of(history), float(history.normal_stress.max())
    seating, stated = float(history.attrs["seating_stress_Pa"]), float(maxima.max())
    largest = stated if stated <= _NEARLY * reached else reached
    if not largest > seating:
        return np.union1d([largest], at)
    levels = np.union1d(round_levels(seating, largest), maxima[maxima <= largest])
    return np.union1d(levels, at)


def closures_at(history: xr.Dataset, levels: np.ndarray, of: str | np.ndarray = NET) -> np.ndarray:
    """Read the closure (cycles, 2, levels) [m] on loading and unloading at stresses [Pa]."""
    closures = np.full((int(history.load_cycle.max()), 2, levels.size), np.nan)
    for (index, side), here in _branches(history, len(closures)):
        here = here[::-1] if side else here
        stress, closure = history.normal_stress.values[here], read_along(history, of)[here]
        largest = float(stress.max())
        reached = np.where((levels > largest) & (levels <= _NEARLY * largest), largest, levels)
        end = np.inf if side else landing_stress(history, index + 1)
        for known, asked in ((stress <= end, reached <= end), (stress >= end, reached > end)):
            if known.any():  # one cubic up to the landing, and one beyond
                read = cubic_over(stress[known], closure[known])(reached[asked])
                closures[index, side, asked] = read
    return closures


def landing_stress(history: xr.Dataset, cycle: int) -> float:
    """Return the stress [Pa] from which a loading lands on its maximum; infinite if none."""
    if not by_fixed_steps(history) or not json.loads(history.attrs["effects"])["breakage"]:
        return np.inf
    numerics = json.loads(history.attrs["numerics"])
    if numerics["target"] == "interpolate":
        return np.inf
    here = branch_of(history, cycle, LOADING)
    stress = history.normal_stress.values
    former = stress[history.load_cycle.values < cycle].max(initial=0.0)
    within = 1.0 + 3.0 * numerics["stress_tolerance"]  # both within the tolerance
    if here.size < 2 or stress[here].max() <= former * within:
        return np.inf
    step = numerics["displacement_step" if cycle == 1 else "later_displacement_step"]
    whole = np.flatnonzero(np.diff(history.closure.values[here]) >= 0.999 * step)
    return float(stress[here][whole[-1] + 1 if whole.size else 0])


def secant_stiffness(
    history: xr.Dataset, cycle: int, low: float, high: float, of: str = NET
) -> float:
    """Compute the normal stiffness [Pa/m] of a loading by the chord between two stresses."""
    here = branch_of(history, cycle, LOADING)
    if here.size < 2:
        return np.nan
    reached = float(history.normal_stress.values[here].max())
    levels = np.array([low, min(high, reached, landing_stress(history, cycle))])
    rise = float(np.diff(closures_at(history, levels, of)[cycle - 1, 0])[0])
    return float(np.diff(levels)[0]) / rise if levels[1] > low and rise > 0.0 else np.nan


def normal_stiffness(history: xr.Dataset, levels: np.ndarray, of: str = NET) -> np.ndarray:
    """Compute the stiffness (cycles, 2, levels) [Pa/m] at stresses [Pa], which rises with them.

    It is the slope of the concave curve nearest to the closure over stress, as that of the closure
    itself goes up and down where contacts break; of another one beyond the former maximum.
    """
    cycles = range(1, int(history.load_cycle.max()) + 1)
    formers = np.array([former_maximum(history, cycle) for cycle in cycles])
    first, last = table_levels(history)[[0, -1]]  # whatever the levels are
    turns = formers[(formers > first) & (formers < last)]
    fine = np.union1d(np.linspace(first, last, POINTS + 1), turns)
    fine = np.union1d(fine, levels[(levels < first) | (levels > last)])
    closures = closures_at(history, fine, of)
    stiffness = np.full((*closures.shape[:2], levels.size), np.nan)
    for index, side in np.ndindex(closures.shape[:2]):
        closure = closures[index, side]
        end = np.inf if side else landing_stress(history, index + 1)
        former = 0.0 if side else formers[index]
        for part in (fine <= former, fine >= former):
            known = part & np.isfinite(closure) & (fine <= end)
            if known.sum() > 2:
                inside = (levels >= fine[known][0]) & (levels <= fine[known][-1])
                slopes = rising_slopes(fine[known], closure[known], levels[inside])
                stiffness[index, side, inside] = slopes
    return stiffness


def rising_slopes(stress: np.ndarray, closure: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Return slopes of stresses (n,) over the concave curve nearest to closures (n,), at levels."""
    run = np.diff(stress)
    fit = scipy.optimize.isotonic_regression(np.diff(closure) / run, weights=run, increasing=False)
    # no later slope corrects the last ones, which are one chord therefore
    blocks = fit.blocks[stress[fit.blocks] <= stress[-1] - LAST_CHORD * np.ptp(stress)]
    blocks = np.append(blocks, stress.size - 1)
    middle = 0.5 * (stress[blocks[:-1]] + stress[blocks[1:]])
    compliance = np.diff(closure[blocks]) / np.diff(stress[blocks])
    middle, slopes = middle[compliance > 0.0], 1.0 / compliance[compliance > 0.0]
    if slopes.size < 2:
        return np.full(levels.size, slopes[0] if slopes.size else np.nan)
    rise = np.diff(slopes)[[0, -1]] / np.diff(middle)[[0, -1]]
    ends = slopes[[0, -1]] + rise * (stress[[0, -1]] - middle[[0, -1]])
    ends = np.clip(ends, slopes[[0, -1]] * [0.5, 1.0], slopes[[0, -1]] * [1.0, 2.0])
    at, values = np.r_[stress[0], middle, stress[-1]], np.r_[ends[0], slopes, ends[1]]
    return np.interp(levels, at, values)


def monotone_curve(at: np.ndarray, values: np.ndarray, rises: bool) -> np.ndarray:
    """Return a monotone curve near values (n,) at ascending places, without steps.

    Neighbours that are against the order have one mean (isotonic regression). A monotone cubic
    leads through the middles of such groups, so that the curve is not flat along them. It is
    straight beyond the outer middles, and changes there by at most half of the outer mean.
    """
    fit = scipy.optimize.isotonic_regression(values, increasing=rises)
    equal = np.logical_and.reduceat(fit.x == values, fit.blocks[:-1])  # and no mean of others
    kept = np.flatnonzero(np.repeat(equal, np.diff(fit.blocks)))
    starts = np.union1d(fit.blocks[:-1], kept)
    weights = np.diff(np.append(starts, values.size))
    if starts.size < 2 or starts.size == values.size:
        return fit.x
    middle, means = np.add.reduceat(at, starts) / weights, fit.x[starts]
    slopes = np.diff(means)[[0, -1]] / np.diff(middle)[[0, -1]]
    change = slopes * (at[[0, -1]] - middle[[0, -1]])
    most = 0.5 * np.abs(means[[0, -1]])
    ends = means[[0, -1]] + np.clip(change, -most, most)
    inner = (middle > at[0]) & (middle < at[-1])
    places = np.r_[at[0], middle[inner], at[-1]]
    through = np.r_[ends[0], means[inner], ends[1]]
    return scipy.interpolate.PchipInterpolator(places, through)(at)


def stress_table(history: xr.Dataset, levels: np.ndarray | None = None) -> pd.DataFrame:
    """Tabulate closure, stiffness, aperture and flow at stresses [Pa], by cycle and branch.

    By default the stresses are those of `table_levels`.
    """
    levels = table_levels(history) if levels is None else levels
    columns: dict[str, np.ndarray] = {}
    begun = int(history.load_cycle.max())
    for kind, of in KINDS.items():
        seats = np.array([seat_of(history, cycle + 1, LOADING, of) for cycle in range(begun)])
        since = closures_at(history, levels, of) - seats[:, None, None]
        columns[f"closure_{kind}_since_seating_mm"] = 1e3 * since
    for kind, of in KINDS.items():
        stiffness = 1e-9 * normal_stiffness(history, levels, of)
        columns[f"normal_stiffness_{kind}_MPa_per_mm"] = stiffness
    columns["mean_aperture_mm"] = 1e3 * closures_at(history, levels, "mean_aperture")
    if has_flow(history):
        for name in HYDRAULIC:  # geometric means along x and y
            mean = np.sqrt(history[name].prod("direction", skipna=False).values)
            columns[f"{name}_mm"] = 1e3 * np.maximum(closures_at(history, levels, mean), 0.0)
        columns["flow_status"] = flow_status_at(history, levels)
    index = pd.MultiIndex.from_product(
        [range(1, begun + 1), BRANCHES, levels / 1e6],
        names=["cycle", "branch", "normal_stress_MPa"],
    )
    flat = {name: values.ravel() for name, values in columns.items()}
    return with_transmissivity(pd.DataFrame(flat, index).reset_index())


def with_transmissivity(curves: pd.DataFrame) -> pd.DataFrame:
    """Add the transmissivity of every hydraulic aperture and bound of it in `stress_table`, or in
    its bands, by `TRANSMISSIVITIES`.
    """
    added = {}
    for name, words in TRANSMISSIVITIES.items():
        for column in dict.fromkeys([*members(curves, name), name]) if name in curves else ():
            added[column.replace(name, words)] = WATER * (1e-3 * curves[column]) ** 3
    return curves.assign(**added)


def has_bands(curves: pd.DataFrame) -> bool:
    """Return whether a `stress_table` has bands."""
    return "closure_net_since_seating_mm_low" in curves


def members(curves: pd.DataFrame, name: str) -> list[str]:
    """Return the columns of a quantity: that of the joint, and low and high if it has a band."""
    if f"{name}_low" in curves:
        return [name, f"{name}_low", f"{name}_high"]
    return [name]


_VARIABLES = {
    "closure": ("m", "closure from first touch"),
    "normal_stress": ("Pa", "nominal normal stress"),
    "contact_fraction": ("1", "fraction of the cells in contact"),
    "bulk_indentation": ("m", "mean displacement by the interaction"),
    "mean_aperture": (
        "m",
        "mean aperture",
        "void volume over nominal area: mean distance of the deformed walls, 0 in contacts",
    ),
    "mean_overlap": ("m", "sum of the overlaps of contacts over the number of cells"),
    "equilibrium_residual": ("1", "recomputed residual of the forces over their sum"),
    "max_closure": ("m", "maximum closure", "from the start of the cycle"),
    "residual_closure": ("m", "residual closure", "from first touch"),
    "max_closure_seated": ("m", "maximum gross closure since seating"),
    "residual_closure_seated": ("m", "residual closure at seating"),
    "max_bulk_indentation": ("m", "bulk indentation at the maximum stress"),
    "unloading_excess": ("Pa", "largest excess of unloading over loading at equal closure"),
    "least_force": ("N", "least force on any cell at any step"),
    "locked_share": ("1", "share of the force on locked contacts at the maximum stress"),
    "flat_share": ("1", "share of the force on other flat contacts at the maximum stress"),
    "upper_final": ("m", "upper wall at the end, towards the lower"),
    "lower_final": ("m", "lower wall at the end, towards the upper"),
    "settled_states": ("1", "states brought to rest, those thrown away included"),
    "equilibria": ("1", "equilibria solved on the way (reference: sweeps)"),
    "newton_steps": ("1", "steps of Newton's method"),
    "breakage_steps": ("1", "breakage steps taken"),
    "replayed_cycles": ("1", "cycles that are the unloading curve of the one before"),
    "idle_steps": ("1", "steps of the first loading without interaction, as it was idle"),
    "idle_displacement": ("1", "largest displacement of a contact left out so, over closure"),
    "locked_contacts": ("1", "largest number of locked contacts at a step"),
    "solver_iterations": ("1", "products with the interaction, or sweeps (reference)"),
    "force": ("N", "normal force of each contact"),
    "overlap": ("m", "overlap delta_S, negative where the walls are apart"),
    "interaction_displacement": ("m", "displacement by all other contacts"),
    "hydraulic_aperture": (
        "m",
        "aperture of parallel plates that pass as much, 0 if blocked",
        "missing where flow_status is not_solved or at_least, and only bounds are known",
    ),
    "smallest_hydraulic": (
        "m",
        "lower bound of the hydraulic aperture",
        "the hydraulic aperture where it is known, 0 where the flow is not solved",
    ),
    "largest_hydraulic": (
        "m",
        "upper bound of the hydraulic aperture",
        "as if the open cells of every line across the flow were connected",
    ),
    "flow_imbalance": ("1", "sum of the cells' mass balances over the inflow"),
}
ATTRIBUTES: dict[str, dict[str, Any]] = {
    name: {"long_name": text, "units": unit} | ({"comment": comment[0]} if comment else {})
    for name, (unit, text, *comment) in _VARIABLES.items()
}
ATTRIBUTES["status"] = {
    "long_name": "status of the simulation: 0 success, below 16 success with a remark",
    "flag_masks": np.array(list(FLAGS), dtype=np.int16),
    "flag_meanings": " ".join(FLAGS.values()),
}

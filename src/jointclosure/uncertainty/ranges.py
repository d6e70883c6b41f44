"""Ranges of the results of a joint, and the share of each source in them.

The range is due to what is not known of this joint: errors of the scans and of the numerics, the
order of breakage, and properties whose ranges are stated. If all these sources change at once, the
change of a result is expected to be the sum of its changes with each source varied alone. Joints
that were simulated with random values of all sources depart from this sum. The expected changes are
computed for many further sets of random values, which need no simulations, and to each of them a
departure is added, which is drawn from Student's t distribution of the few departures that are
known (JCGM 101:2008). The range lies between the 5 and 95 % quantiles of these changes, and
contains the joint itself. Changes of a positive result are differences of its logarithm, and
changes of a share are differences of the logarithm of its odds.

Choices of the model, such as the grid spacing, hold for all joints. Each is changed alone; their
effects are added in the wider range with other choices, centred on the usual ones. Half of the
spacing is not simulated: its change is taken as opposite to the change by twice the spacing.

The share of a source is its total index: the part of the variance that it takes part in, alone or
together with others (Homma & Saltelli 1996). The variance by a random source is that among its
draws, less the variance by the order of breakage, which is another one in every simulation. What
these variances do not explain of the departures is attributed to pairs of sources, in proportion to
the products of their variances. Only pairs of sources that vary in the random joints count.
"""

from collections.abc import Collection, Mapping
from functools import lru_cache

import numpy as np
import pandas as pd
import scipy

from jointclosure.ensembles.quantities import CURVES
from jointclosure.joint.interpolation import monotone_curve
from jointclosure.joint.result_tables import ENDS, WIDER, with_transmissivity
from jointclosure.joint.status import FLOW_STATUSES, ONLY_BOUNDS, UNLOADING
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.uncertainty.ranged_results import (
    APERTURE,
    CLOSURE_GROSS,
    CLOSURE_NET,
    CONTACT,
    RANGED_RESULTS,
    RESIDUAL_NET,
    STIFFNESS,
    UNRESOLVED,
)
from jointclosure.uncertainty.sources import ALL, MULTIPLE, ORDER, SHARED, Source

_ALMOST_ALL = 1.0 - 1e-6  # largest share of cells in contact whose odds are used
OUTSIDE = 0.05  # probability of a result below the range, and of one above it
APERTURES = ("aperture", "hydraulic")
"""Words of the names of results that are apertures."""
WIDENED = dict.fromkeys((*APERTURES, "contact"), 1.6)
"""Factors of the width of ranges of apertures and contact, by a word of the name of the result.
Nine in ten of 34 pairs of known truth (seeds 2000 to 2042 of benchmarks/range_coverage.py) needed
them, because the sources do not contain all effects of noise and interpolation on cells that just
touch."""
WIDENED_OTHERS = 1.25
"""Factor of the width of ranges of all other results. Without it 79 to 86 % of the closures,
stiffnesses and Vm of the first cycle were in their ranges (43 pairs, seeds 3000 to 3053), and 83 %
of the results of second cycles (34 pairs, seeds 2000 to 2042)."""
_SAME = 1e-6  # relative difference of two numbers that are one result
MEANT = "meant to contain the true result of nine in ten joints"
"""What ranges are, in the words of screens, files and figures."""
RANGE_FLOW_STATUS = "range_flow_status"
"""Column of `Budget.curves` with the flow status of the variant whose flow is known least."""
NUMBERS = ["best", *ENDS, *WIDER]
"""Columns of `Budget.ranges` other than shares of sources."""


def ranges_of(
    results: pd.DataFrame,
    sources: Mapping[str, Source],
    positions: np.ndarray,
    further_positions: np.ndarray,
    limits: Mapping[tuple[int, str], float] = {},
) -> pd.DataFrame:
    """Compute the ranges of the results of a joint (`Budget.ranges`) from those of its variants.

    ``results`` are `Budget.results` without the joint by another rule of steps (`OTHER_RULE`).
    ``positions`` (draws, sources), in [0, 1) as for `Source.at`, are those of the joints that were
    simulated with all sources at random (`ALL`), in the order of these joints.
    ``further_positions`` (n, sources) are those of joints whose results are only estimated.
    ``limits`` [1] are numerical errors as from `limits_of_error`: a range contains its best value
    times and divided by 1 plus the error. The share of cells in contact has the range of its odds,
    so that it stays below 1.
    """
    rows = {}
    for cycle, of_cycle in results.groupby("cycle"):
        for quantity in RANGED_RESULTS:
            of_quantity = of_cycle[quantity]
            if quantity == CONTACT:  # odds have no upper limit, so that a share stays below 1
                touching = of_quantity.clip(upper=_ALMOST_ALL)
                of_quantity = touching / (1.0 - touching)
            values = of_quantity.groupby(of_cycle.source).apply(np.array).to_dict()
            error = _limit_of(quantity, of_cycle, limits, int(cycle))
            rows[cycle, quantity] = _range_of(
                values, sources, positions, further_positions, quantity, error=error
            )
        share = rows[cycle, CONTACT]
        share.update({end: share[end] / (1.0 + share[end]) for end in NUMBERS[1:]})
        share[NUMBERS[0]] = float(of_cycle.loc[of_cycle.source == "", CONTACT].iloc[0])
        net = rows[cycle, CLOSURE_NET]
        gross = rows[cycle, CLOSURE_GROSS]
        for end in NUMBERS[1:]:  # of every joint the net closure is the smaller one
            net[end], gross[end] = sorted((net[end], gross[end]))
    index = pd.MultiIndex.from_tuples(rows, names=["cycle", "quantity"])
    return pd.DataFrame(list(rows.values()), index=index)


def _limit_of(
    quantity: str,
    of_cycle: pd.DataFrame,
    limits: Mapping[tuple[int, str], float],
    cycle: int,
) -> float:
    """Return the numerical error of a result over the result [1]; 0 if it is not known.

    Gross closure and residual closure have the error [m] of the net closure, because the
    indentation and the elastic recovery by which they differ from it are known well. Their error is
    0 if they are at most `UNRESOLVED` of the net closure, where nothing remains.
    """
    if quantity not in (CLOSURE_GROSS, RESIDUAL_NET):
        return limits.get((cycle, quantity), 0.0)
    error = limits.get((cycle, CLOSURE_NET), 0.0)
    best = of_cycle[of_cycle.source == ""].iloc[0]
    net, result = float(best[CLOSURE_NET]), float(best[quantity])
    return error * net / result if result > UNRESOLVED * net else 0.0


def widening_of(quantity: str) -> float:
    """Return the factor by which the range or band of a result is widened about the joint's value.

    It is that of a word of `WIDENED` in the name of the result, or else `WIDENED_OTHERS`.
    """
    return next((factor for word, factor in WIDENED.items() if word in quantity), WIDENED_OTHERS)


def _range_of(
    values: dict[str, np.ndarray],
    sources: Mapping[str, Source],
    positions: np.ndarray,
    further_positions: np.ndarray,
    quantity: str,
    least: float | None = None,
    error: float = 0.0,
) -> dict[str, float]:
    """Return a row of `Budget.ranges`, for one result, from its values in the variants.

    ``values`` are arrays by source, with that of the joint itself under "", which is removed from
    them. ``positions`` and ``further_positions`` are as for `ranges_of`; ``quantity`` is the name
    of the result. Changes are taken as factors if the ``least`` value, by default that of all
    variants, is positive, else as differences. The ranges are widened about the joint
    (`widening_of`), and contain its numerical ``error`` [1]. All is NaN if no variant has the
    result.
    """
    best = float(values.pop("")[0])
    known = np.concatenate([[best], *values.values()])
    if np.isnan(known).all():
        return dict.fromkeys((*NUMBERS, *sources), np.nan)
    factors = bool((np.nanmin(known) if least is None else least) > 0.0)
    shared = next((name for name in sources if sources[name].kind == SHARED), "")
    by_shared = values[shared][0] if shared else best
    changes = {}
    for name, of_source in values.items():
        from_here = best if name == shared or np.isnan(by_shared) else by_shared
        if name in sources and sources[name].kind == MULTIPLE:
            inverse = _by_inverse_multiple(from_here, of_source[0], factors, quantity)
            of_source = np.append(inverse, of_source)
        changes[name] = np.log(of_source / from_here) if factors else of_source - from_here
    drawn = changes.pop(ALL)
    expected, of_further = (
        {
            name: source.changes_at(changes[name], at)
            for (name, source), at in zip(sources.items(), of_joints.T, strict=True)
        }
        for of_joints in (positions, further_positions)
    )
    slope, departures = _departures(drawn, _sum(expected, sources, True))
    centre = departures.mean()
    scatter = np.sqrt((departures.size + 1) / departures.size)
    scatter *= departures.std(ddof=1) if departures.size > 1 else 0.0
    further_departures = centre + scatter * _student_t(
        len(further_positions), max(departures.size - 1, 1)
    )
    of_range = slope * _sum(of_further, sources, True) + further_departures
    wider = of_range + _sum(of_further, sources, False)
    ends = np.quantile([of_range, wider], [OUTSIDE, 1.0 - OUTSIDE], axis=1).T
    ends = widening_of(quantity) * np.column_stack(
        [np.minimum(ends[:, 0], 0.0), np.maximum(ends[:, 1], 0.0)]
    )
    if error > 0.0:
        above = np.log1p(error) if factors else error * abs(best)
        below = -above
        ends = np.column_stack([np.minimum(ends[:, 0], below), np.maximum(ends[:, 1], above)])
    ends[1] = min(ends[0, 0], ends[1, 0]), max(ends[0, 1], ends[1, 1])
    numbers = best * np.exp(ends.ravel()) if factors else best + ends.ravel()
    numbers = np.maximum(numbers, min(0.0, np.nanmin(known)))  # below 0 where a joint was
    variances = {
        name: (slope**2 if sources[name].varied else 1.0) * float(of_source.var())
        for name, of_source in of_further.items()
    }
    random = {name: changes[name] for name in sources if sources[name].kind == "random"}
    row = dict(zip(NUMBERS, (best, *numbers), strict=True))
    fixed = {n for n, source in sources.items() if source.kind == SHARED or not source.varied}
    return row | total_indices(variances, random, float(departures.var()), fixed)


def _by_inverse_multiple(best: float, by_multiple: float, factors: bool, quantity: str) -> float:
    """Return the result that is expected with the inverse of a multiple, which is not simulated.

    ``best`` is the result with the usual value of a source, ``by_multiple`` that with a multiple of
    it. The expected change is opposite to the change by the multiple: as a factor with ``factors``,
    else as a difference. The change of an aperture is a difference with ``factors`` too, as long as
    the result is positive, because an aperture is that at seating less the net closure.
    """
    opposite = 2.0 * best - by_multiple
    is_aperture = any(word in quantity for word in APERTURES)
    if not factors or (is_aperture and opposite > 0.0):
        return opposite
    return best**2 / by_multiple


@lru_cache
def _student_t(count: int, freedom: int) -> np.ndarray:
    """Return quantiles (count,) of Student's t with ``freedom`` degrees of freedom.

    They are at evenly spaced probabilities, in a random order that is the same in each call.
    Callers must not change the array, which is kept.
    """
    order = generator(seed_of(1, "departures")).permutation(count)
    return scipy.stats.t.ppf((order + 0.5) / count, freedom)


def _sum(
    changes: Mapping[str, np.ndarray], sources: Mapping[str, Source], varied: bool
) -> np.ndarray:
    """Return the sum (n,) of the changes of a result by those sources whose `varied` is as stated.

    It is 0 if there are no such sources.
    """
    chosen = [values for name, values in changes.items() if sources[name].varied == varied]
    return np.sum(chosen, axis=0) if chosen else np.zeros(next(iter(changes.values())).shape)


_LIMIT_OF_BAND = {
    "closure_net_since_seating_mm": CLOSURE_NET,
    "normal_stiffness_net_MPa_per_mm": STIFFNESS,
}
"""Result whose numerical error the band of a curve contains, by column of `stress_table`."""
_AT_MAXIMUM = {"closure_net_since_seating_mm": CLOSURE_NET, "mean_aperture_mm": APERTURE}
"""Result that a curve has at the maximum stress of its cycle, by column of `stress_table`."""


def _limit_on_branch(
    limits: Mapping[tuple[int, str], float], cycle: int, branch: str, name: str
) -> float:
    """Return the numerical error [1] of a curve of `stress_table` on a branch of a cycle.

    ``name`` is the column of the curve. Curves without a known error have 0. As unloading breaks
    nothing, its stiffness equals that of the next loading, and has the error of the next cycle, if
    this is known: not that of the loading before it, in which asperities break.
    """
    result = _LIMIT_OF_BAND.get(name, "")
    of_cycle = limits.get((cycle, result), 0.0)
    if branch == UNLOADING and result == STIFFNESS:
        return limits.get((cycle + 1, result), of_cycle)
    return of_cycle


def bands_of(
    curves: pd.DataFrame,
    sources: Mapping[str, Source],
    positions: np.ndarray,
    further_positions: np.ndarray,
    limits: Mapping[tuple[int, str], float] = {},
    ranges: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Compute the curves of a joint with bands (`Budget.curves`) from those of its variants.

    ``curves`` are the `stress_table` of all variants in one, with the column ``source``, "" for the
    joint; other arguments are as for `ranges_of`. Bands are ranges at each stress, made monotone
    along the stress. If any source is a choice of the model, there are also the wider bands with
    other choices (`WIDER`). Net closure and mean aperture at the maximum stress of a cycle are
    results too: if their ``ranges`` (from `ranges_of`) are given, their bands end in these ranges.
    """
    with_choices = any(not of.varied and of.kind != SHARED for of in sources.values())
    ends = [*ENDS, *WIDER] if with_choices else ENDS
    places = ["cycle", "branch", "normal_stress_MPa"]
    rows = []
    shown = [name for name in CURVES if name in curves]
    above = curves.normal_stress_MPa > curves.normal_stress_MPa.min()  # where closures begin
    least = {True: curves.loc[above, shown].min(), False: dict.fromkeys(shown)}
    for (cycle, branch, stress), here in curves.groupby(places, sort=False):
        row = here[here.source == ""].drop(columns="source").to_dict("records")[0]
        of_source = here.groupby("source", sort=False).indices
        if "flow_status" in row:
            known_statuses = [word for word in FLOW_STATUSES if (here.flow_status == word).any()]
            row[RANGE_FLOW_STATUS] = known_statuses[-1] if known_statuses else ""
        for name in shown:
            of_curve = here[name].to_numpy()
            values = {source: of_curve[rows_of] for source, rows_of in of_source.items()}
            known = np.isfinite(row[name])
            if name == "hydraulic_aperture_mm":  # quantiles of those with a known flow mislead
                known &= row[RANGE_FLOW_STATUS] not in ONLY_BOUNDS
            smallest = least[stress > curves.normal_stress_MPa.min()][name]
            error = _limit_on_branch(limits, int(cycle), branch, name)
            numbers = {}
            if known:
                numbers = _range_of(
                    values, sources, positions, further_positions, name, smallest, error
                )
            for number in ends:
                row[f"{name}_{number}"] = numbers.get(number, np.nan)
        rows.append(row)
    bands = pd.DataFrame(rows).infer_objects().reset_index(drop=True)
    for name in shown:
        rises = CURVES[name][1]
        columns = [f"{name}_{end}" for end in ends]
        for (cycle, _), rows in bands.groupby(places[:2]):
            known = rows[[name, *columns]].dropna()
            if known.empty:
                continue
            stress = rows.normal_stress_MPa[known.index].to_numpy()
            joint = known[name].to_numpy()
            smooth = [monotone_curve(stress, known[end].to_numpy(), rises) for end in columns]
            if (np.diff(joint) * (1.0 if rises else -1.0) >= 0.0).all():
                smooth[:2] = np.minimum(smooth[0], joint), np.maximum(smooth[1], joint)
            if with_choices:  # the wider band contains the other one
                smooth[2:] = np.minimum(smooth[0], smooth[2]), np.maximum(smooth[1], smooth[3])
            if ranges is not None and name in _AT_MAXIMUM:
                result = ranges.loc[(cycle, _AT_MAXIMUM[name])]
                if np.isclose(joint[-1], result["best"], rtol=_SAME):  # the maximum was reached
                    limit = np.minimum if rises else np.maximum  # no curve goes beyond its end
                    smooth = [limit(end, result[of]) for end, of in zip(smooth, ends, strict=True)]
                    for end, of in zip(smooth, ends, strict=True):
                        end[-1] = result[of]
            bands.loc[known.index, columns] = np.transpose(smooth)
    return with_transmissivity(_within_bounds(bands))


def _within_bounds(bands: pd.DataFrame) -> pd.DataFrame:
    """Return bands in which the band of the hydraulic aperture is limited by its two bounds.

    Its low end is at least the low end of the band of the lower bound, its high end at most the
    high end of the band of the upper bound. The hydraulic aperture of a joint lies between its
    bounds, whatever the inputs are, but the change that is assumed for a variant that was not
    simulated can exceed them.
    """
    limited = {}
    for bound, limit, sides in (
        ("smallest_hydraulic_mm", np.fmax, (ENDS[0], WIDER[0])),
        ("largest_hydraulic_mm", np.fmin, (ENDS[1], WIDER[1])),
    ):
        for end in sides:
            name = f"hydraulic_aperture_mm_{end}"
            if name in bands and f"{bound}_{end}" in bands:
                known = bands[name].notna()
                limited[name] = limit(bands[name], bands[f"{bound}_{end}"]).where(known)
    return bands.assign(**limited)


def _departures(drawn: np.ndarray, sums: np.ndarray) -> tuple[float, np.ndarray]:
    """Return how much of the expected changes joints with random values show, and departures.

    ``drawn`` (draws,) are the changes of a result in these joints, NaN for those that failed, and
    ``sums`` (draws,) the sums of the changes expected by source. The first value is the slope of
    the changes over the sums: at least 0, and at most 1, because sources with the same effect do
    not add up. The departures are the changes less the slope times the sums, without joints that
    failed. With fewer than two joints the slope is 1, and the only departure is 0.
    """
    known = np.isfinite(drawn)
    drawn = drawn[known]
    sums = sums[known]
    if drawn.size < 2:
        return 1.0, np.zeros(1)
    centred = sums - sums.mean()
    square = float(centred @ centred)
    slope = float(np.clip(centred @ drawn / square, 0.0, 1.0)) if square > 0.0 else 1.0
    return slope, drawn - slope * sums


def total_indices(
    alone: Mapping[str, float],
    random: Mapping[str, np.ndarray],
    departures: float,
    fixed: Collection[str] = (),
) -> dict[str, float]:
    """Return the total index of each source in the variance of a result (see the module) [1].

    ``alone`` are the variances of the expected changes by each source, ``random`` the changes of
    the result in the draws of each random source, NaN for failed ones. ``departures`` is the
    variance of the departures, in joints in which the ``fixed`` sources did not vary. All are NaN
    if there is no variance.
    """
    scatter = {}
    for name, values in random.items():
        draws = values[np.isfinite(values)]
        draws = np.append(draws, 0.0) if name == ORDER else draws  # the joint is a copy too
        scatter[name] = float(draws.var(ddof=1)) if draws.size > 1 else 0.0
    order = scatter.get(ORDER, 0.0)
    scatter = {name: v if name == ORDER else max(v - order, 0.0) for name, v in scatter.items()}
    most = departures / total if (total := sum(scatter.values())) > departures else 1.0
    variances = dict(alone) | {name: most * variance for name, variance in scatter.items()}
    left = departures - most * total
    varied = {name: variance for name, variance in variances.items() if name not in fixed}
    acting = {name: variance for name, variance in varied.items() if name != ORDER}
    whole = sum(acting.values())
    pairs = {name: variance * (whole - variance) for name, variance in acting.items()}
    if not any(pairs.values()):  # less than two sources act
        pairs = next((some for some in (acting, varied) if any(some.values())), variances)
        left = 0.5 * left
    products = 0.5 * sum(pairs.values()) or np.nan
    everything = sum(alone.values()) + departures or np.nan
    return {
        name: (variance + left * pairs.get(name, 0.0) / products) / everything
        for name, variance in variances.items()
    }

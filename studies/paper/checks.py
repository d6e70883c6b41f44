"""Checks of the results of an ensemble, and the effect of joints with a remark on mean closures.

A remark is a flag of the status of a joint that did not fail.
"""

import itertools
import json
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.joint.status import FAILURE, FLAGS
from jointclosure.parameters import Numerics, scene_of
from jointclosure.statistics.number_texts import rounded
from jointclosure.statistics.standard_errors import Estimate, jackknife_error
from studies.frame.joint_tables import succeeded
from studies.paper.closure_tables import estimate_columns
from studies.paper.requirements import REPORTED

CLOSURE = "max_closure_seated_net"
"""Closure whose means with and without remarked joints are tabulated: net, since seating."""
VOLUME_TOLERANCE = 1e-12
"""Largest relative change of a wall's volume that passes the check."""
REMARKED = "simulations flagged"
"""Beginning of the names of checks that count joints with a remark."""
FEWEST_USED = 2
"""Smallest number of realisations of a case for which a standard deviation exists."""


REMARKS = {mask: name for mask, name in FLAGS.items() if mask < FAILURE}
"""Names of the remarks, by their bit of the status."""


def remarked_joints(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate joints with a remark, and the change [%] of mean net closures without them.

    There is a row for each cycle of each case that has joints with a remark, and for each remark.
    It has the number of ``joints`` with the remark, the number ``samples`` of all joints that are
    used, the mean maximum net closures since seating [mm] with and without the remarked joints, and
    the change [%] with its standard error.
    """
    good = succeeded(study).transpose("case", "realization").values
    statuses = study.status.transpose("case", "realization").values
    closures = 1e3 * study[CLOSURE].transpose("cycle", "case", "realization").values
    rows = []
    for (mask, remark), place in itertools.product(REMARKS.items(), range(len(good))):
        used = good[place]
        marked = (statuses[place][used] & mask) > 0
        if not marked.any():
            continue
        case = study.isel(case=place)
        about: dict[str, object] = {"remark": remark, "case": str(case.case.item())}
        about |= {name: case[name].item() for name in ("rock", "parameter", "level")}
        about |= {"joints": int(marked.sum()), "samples": marked.size}
        for cycle, values in zip(study.cycle.values.tolist(), closures[:, place], strict=True):
            mean = values[used].mean()
            change = change_without(values[used], marked)
            row = about | {"cycle": cycle, "net_closure_mean_mm": mean}
            row |= {"mean_without_mm": mean * (1.0 + change.value)}
            rows.append(row | estimate_columns("change_percent", change, 100.0))
    columns = ["remark", "case", "rock", "parameter", "level", "joints", "samples", "cycle"]
    columns += ["net_closure_mean_mm", "mean_without_mm"]
    columns += ["change_percent", "change_percent_standard_error"]
    return pd.DataFrame(rows, columns=columns)


def change_without(values: np.ndarray, marked: np.ndarray) -> Estimate:
    """Return the relative change of the mean of values (n,) when the ``marked`` (n,) are left out.

    Its standard error is that of a jackknife over all joints, because the share of marked joints
    varies between samples too. The error is NaN if only one joint is unmarked; error and change are
    NaN if all joints are marked.
    """
    change = _relative_change(values, marked)
    left_out = [
        _relative_change(np.delete(values, place), np.delete(marked, place))
        for place in range(values.size)
    ]
    return Estimate(change, float(jackknife_error(left_out)))


def _relative_change(values: np.ndarray, marked: np.ndarray) -> float:
    """Return the relative change of a mean when marked values are left out; NaN if all are."""
    return float(values[~marked].mean() / values.mean() - 1.0) if not marked.all() else np.nan


def remarks_in_words(remarked: pd.DataFrame, remark: str, total: int) -> list[tuple[str, str]]:
    """Return the names and texts of checks of the joints with a remark, for `check_results`.

    ``remarked`` is the table of `remarked_joints`. The first check has the number of these joints
    among ``total``. The second has the largest change of a mean closure without them, if known. One
    more for each case has the number and the changes in this case.
    """
    rows = remarked[remarked.remark == remark]
    cases = list(rows.groupby("case", sort=False))
    name = f"{REMARKED} {remark}"
    if not cases:
        return [(name, f"0 of {total}")]
    joints = sum(int(part.joints.iloc[0]) for _, part in cases)
    lines = [(name, f"{joints} of {total}, in {len(cases)} cases")]
    if (most := most_changed(rows)) is not None:
        where = f"{most.case}, cycle {most.cycle}"
        without = f"largest change of a mean net closure since seating without {name}"
        lines.append((without, f"{change_in_words(most)} ({where})"))
    for case, part in cases:
        first = part.iloc[0]
        changes = [f"cycle {row.cycle}: {change_in_words(row)}" for row in part.itertuples()]
        without = f"change of the mean net closure since seating without them: {', '.join(changes)}"
        lines.append((f"{name} of {case}", f"{first.joints} of {first.samples}; {without}"))
    return lines


def most_changed(remarked: pd.DataFrame) -> pd.Series | None:
    """Return the row of `remarked_joints` with the largest change; None if no change is known."""
    sizes = remarked.change_percent.abs().dropna()
    return remarked.loc[sizes.idxmax()] if len(sizes) else None


def change_in_words(row: Any) -> str:
    """Return as text the change of a mean without remarked joints, with its standard error.

    ``row`` is one of `remarked_joints`.
    """
    if np.isnan(row.change_percent):
        return "no joint is left"
    if np.isnan(row.change_percent_standard_error):
        return f"{row.change_percent:+.2g} % (too few joints for an error)"
    return f"{rounded(row.change_percent, row.change_percent_standard_error)} %"


def check_results(
    study: xr.Dataset, numerics: Numerics, realizations: int, ensemble: str = "cases"
) -> pd.DataFrame:
    """Tabulate checks of the simulations of an ensemble: required, found, and whether passed.

    ``numerics`` are those of the ensemble, ``realizations`` is the number of realisations of each
    case. Checks without a limit (`REPORTED`) are passed, unless a number is not finite.
    """
    good = succeeded(study)
    rows = []

    def add(check: str, required: str, value, passed: object = True) -> None:
        row = {"check": check, "required": required, "found": value, "passed": bool(passed)}
        rows.append({"ensemble": ensemble} | row)

    def bounded(check: str, value: float, limit: float, shown: str = "g") -> None:
        add(check, f"at most {limit:{shown}}", f"{value:.3g}", value <= limit)

    total = good.size
    successes = int(good.sum())
    add("simulations in a status of success", f"{total}", f"{successes}", successes == total)
    least = int(good.sum("realization").min())
    used = "realisations that statistics use, of the case with the fewest"
    add(
        used,
        f"at least {FEWEST_USED} of {realizations}",
        f"{least}",
        least >= FEWEST_USED,
    )
    force = float(study.least_force.where(good).min())
    add("least force on a cell [N]", "not negative", f"{force:.3g}", force >= 0.0)
    scenes = [scene_of(name) for name in study.scene.values.tolist()]
    keeps = np.array([not scene.breakage or scene.gouge for scene in scenes])
    if keeps.any():
        volume = float(study.volume_error.where(good)[keeps].max())
        bounded("largest change of a wall's volume, relative", volume, VOLUME_TOLERANCE)
    residual = float(study.largest_residual.where(good).max())
    check = "largest residual of equilibrium, relative"
    fast = numerics.solver == "fast"
    if fast:
        bounded(check, residual, 1.01 * numerics.force_tolerance, ".3g")
    else:
        stops = f"reported only: the reference stops at a change of {numerics.sweep_tolerance:g}"
        add(check, stops, f"{residual:.3g}", np.isfinite(residual))
    if "largest_flow_imbalance" in study:
        from jointclosure.joint.flow import LARGEST_IMBALANCE

        imbalance = float(study.largest_flow_imbalance.where(good).max())
        balance = "largest sum of the cells' mass balances in a flow, relative"
        bounded(balance, imbalance, LARGEST_IMBALANCE)
    excess = float(
        (study.unloading_excess.max("cycle").where(good) / study.max_normal_stress).max()
    )
    exact = fast and not any(scene.breakage for scene in scenes)
    add(
        "largest excess of unloading over loading stress at equal closure, over the maximum",
        "0" if exact else REPORTED,
        f"{excess:.3g}",
        excess == 0.0 if exact else np.isfinite(excess),
    )
    closures = study.max_closure.where(good)
    read = int(np.isfinite(closures.values[good.values]).all(axis=-1).sum())
    whole = "successful simulations with all closures read"
    add(whole, f"{successes}", f"{read}", read == successes)
    smallest = float(closures.min())
    add("maximum closures", "positive", f"{smallest:.3g} m at least", smallest > 0.0)
    for rock, walls in json.loads(study.attrs.get("walls", "{}")).items():
        apart = min(walls["windows_side_by_side"], realizations)
        sharing = f"at most {apart} of {realizations}"
        add(f"realisations of {rock} that share no part of a scan", REPORTED, sharing)
    remarked = remarked_joints(study)
    for mask, name in FLAGS.items():
        lines = remarks_in_words(remarked, name, successes)
        if mask >= FAILURE:
            count = int(((study.status.values & mask) > 0).sum())
            lines = [(f"{REMARKED} {name}", f"{count} of {total}")]
        for line in lines:
            add(line[0], REPORTED, line[1])
    return pd.DataFrame(rows)

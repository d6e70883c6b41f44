"""Mean closures, indifference intervals and verdicts of two studies. Surfaces with the same seeds
are compared in pairs.
"""

import argparse
import itertools
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.parameters import PROPERTIES
from jointclosure.storage.files import read_csv
from jointclosure.storage.netcdf import read_netcdf
from studies.commands import existing, study_of
from studies.frame.tables import succeeded


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("first", type=Path, help="results folder, such as results/paper")
    command.add_argument("second", type=Path, help="results folder of the other study")
    what = "list all differences except in provenance and timing; fails if there is one"
    command.add_argument("--exact", action="store_true", help=what)


def run(arguments: argparse.Namespace) -> int:
    """Print the differences between two studies."""
    folders = arguments.first, arguments.second
    first, second = (read_netcdf(study_of(folder)) for folder in folders)
    if arguments.exact:
        messages = differences(first, second)
        print("\n".join(messages) or "identical except for provenance and timing")
        return 1 if messages else 0
    changes = closure_changes(first, second)
    print(surfaces_sentence(changes))
    print("\nMean closures, over the cases of each rock")
    print(by_rock(changes).round(4).to_string(index=False))
    tables = (read_csv(existing(folder / "tables/table_3_indifference.csv")) for folder in folders)
    intervals = interval_changes(*tables)
    if len(intervals):
        print("\nLength of the indifference intervals, with bootstrap confidence intervals")
        print(intervals.round(3).to_string(index=False, na_rep="–"))
    else:
        print("\nNo indifference interval in common")
    claims = (read_csv(existing(folder / "tables/claims.csv")) for folder in folders)
    both = (table.set_index("number").verdict for table in claims)
    verdicts = pd.DataFrame(dict(zip(("first", "second"), both, strict=True))).fillna("not judged")
    moved = verdicts[verdicts["first"] != verdicts["second"]]
    print(f"\nVerdicts that differ\n{moved.to_string()}" if len(moved) else "\nNo verdict differs")
    return 0


TARGETS = ("max_closure", "max_closure_net", "residual_closure")
MAY_DIFFER = ("provenance_", "timing_")
"""Prefixes of names whose values may differ between two runs of one study."""


def closure_changes(first: xr.Dataset, second: xr.Dataset) -> pd.DataFrame:
    """Tabulate the change of mean closures of every case that both studies have.

    For each case, cycle and target: the means [mm], the change in percent of the first mean, its
    standard error, the number of realisations, and whether the surfaces are the same (compared by
    seeds). The differences of equal surfaces are paired.
    """
    shared = [name for name in first.case.values if name in set(second.case.values)]
    if not shared:
        raise ValueError("the studies have no case in common")
    cycles = sorted(set(first.cycle.values.tolist()) & set(second.cycle.values.tolist()))
    rows = []
    for name, cycle, target in itertools.product(shared, cycles, TARGETS):
        one, two = first.sel(case=name), second.sel(case=name)
        about = {"case": name} | {key: one[key].item() for key in ("rock", "parameter", "level")}
        about |= {"cycle": cycle, "target": target}
        rows.append(about | _change(one, two, target, cycle))
    return pd.DataFrame(rows)


def _change(one: xr.Dataset, two: xr.Dataset, target: str, cycle: int) -> dict:
    a, b = (part[target].sel(cycle=cycle).values for part in (one, two))
    good_a, good_b = succeeded(one).values, succeeded(two).values
    paired = one.sizes == two.sizes and np.array_equal(one.seed.values, two.seed.values)
    if paired:
        good_a = good_b = good_a & good_b
    a, b = 1e3 * a[good_a], 1e3 * b[good_b]
    alone = np.hypot(_standard_error(a), _standard_error(b))
    error = _standard_error(b - a) if paired else alone
    base = a.mean() if a.size else np.nan
    return {
        "mean_first_mm": base,
        "mean_second_mm": b.mean() if b.size else np.nan,
        "change_percent": 100.0 * (b.mean() - base) / base if a.size and b.size else np.nan,
        "standard_error_percent": 100.0 * error / base,
        "samples": min(a.size, b.size),
        "same_surfaces": paired,
    }


def _standard_error(values: np.ndarray) -> float:
    return float(values.std(ddof=1) / np.sqrt(values.size)) if values.size > 1 else np.nan


def surfaces_sentence(changes: pd.DataFrame) -> str:
    """State in words whether `closure_changes` compares the same surfaces or different ones."""
    if changes.same_surfaces.all():
        return "Both studies close the same surfaces, which are compared one by one."
    cases = changes.loc[~changes.same_surfaces, "case"].unique()
    return (
        f"The surfaces differ in {len(cases)} of {changes.case.nunique()} cases (seeds or numbers "
        "of surfaces): changes there contain the scatter of surfaces. Surfaces are drawn by the "
        "name of the study; study.surfaces_of draws those of another one."
    )


def by_rock(changes: pd.DataFrame) -> pd.DataFrame:
    """Average `closure_changes` by rock, cycle and target, with the spread over the cases."""
    groups = changes.groupby(["rock", "cycle", "target"], sort=False)
    return groups.agg(
        cases=("case", "size"),
        mean_first_mm=("mean_first_mm", "mean"),
        mean_second_mm=("mean_second_mm", "mean"),
        change_least_percent=("change_percent", "min"),
        change_mean_percent=("change_percent", "mean"),
        change_most_percent=("change_percent", "max"),
        largest_standard_error=("standard_error_percent", "max"),
    ).reset_index()


def interval_changes(first: pd.DataFrame, second: pd.DataFrame) -> pd.DataFrame:
    """Tabulate lengths of the intervals of both tables of Table 3 with bounds, and their ratio."""

    def shown(row) -> str:
        values = row.length, row.length_low, row.length_high
        return "–" if np.isnan(row.length) else "{:.3g} ({:.3g} to {:.3g})".format(*values)

    keys = ["rock", "parameter", "cycle"]
    both = first.merge(second, on=keys, suffixes=("_first", "_second"))
    table = both[keys].assign(unit=[PROPERTIES[name].unit for name in both.parameter])
    for which, intervals in (("first", first), ("second", second)):
        of_keys = both[keys].merge(intervals, on=keys)
        table[which] = [shown(row) for row in of_keys.itertuples()]
        table[f"t test, {which}"] = of_keys.test
    return table.assign(ratio=both.length_second / both.length_first)


def differences(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """List all differences between two datasets except in provenance and timing."""
    messages = []
    for kind, one, two in (
        ("attribute", first.attrs, second.attrs),
        ("variable", first.variables, second.variables),
    ):
        names = {str(name) for name in [*one, *two]}
        for name in sorted(name for name in names if not name.startswith(MAY_DIFFER)):
            if name not in one or name not in two:
                where = "first" if name in one else "second"
                messages.append(f"{kind} {name}: only in the {where}")
            elif kind == "attribute" and not np.array_equal(one[name], two[name]):
                messages.append(f"attribute {name} differs")
            elif kind == "variable" and not _same_bits(one[name], two[name]):
                messages.append(f"variable {name} differs{_where(one[name], two[name])}")
    return messages


def _same_bits(one: xr.Variable, two: xr.Variable) -> bool:
    numbers = one.dtype.kind in "iuf"
    return one.identical(two) and not (numbers and one.values.tobytes() != two.values.tobytes())


def _where(one: xr.Variable, two: xr.Variable) -> str:
    if one.shape != two.shape or one.dtype.kind not in "iuf":
        return f": {one.dtype} {dict(one.sizes)} and {two.dtype} {dict(two.sizes)}"
    unequal = ~((one.values == two.values) | (np.isnan(one.values) & np.isnan(two.values)))
    if not unequal.any():
        return " in its attributes, or in signs of zeros"
    with np.errstate(invalid="ignore"):
        largest = np.nanmax(np.abs(one.values - two.values), initial=0.0)
    return f" in {int(unequal.sum())} of {unequal.size} values, by at most {largest:.3g}"

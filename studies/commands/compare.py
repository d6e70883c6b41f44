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
    """Print the differences between two studies; return 1 if ``--exact`` finds one, else 0."""
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
    one, two = (table[[*INTERVAL, "length", "length_low", "length_high"]] for table in tables)
    intervals = one.merge(two, on=INTERVAL, suffixes=("_first", "_second"))
    intervals["ratio"] = intervals.length_second / intervals.length_first
    intervals["unit"] = [PROPERTIES[name].unit for name in intervals.parameter]
    print(
        "\nLengths of indifference intervals, with bootstrap confidence intervals, and their ratio"
    )
    print(intervals.to_string(index=False, na_rep="–", float_format="{:.3g}".format))
    claims = (read_csv(existing(folder / "tables/claims.csv")) for folder in folders)
    both = (table.set_index("number").verdict for table in claims)
    verdicts = pd.DataFrame(dict(zip(("first", "second"), both, strict=True))).fillna("not judged")
    moved = verdicts[verdicts["first"] != verdicts["second"]]
    print(f"\nVerdicts that differ\n{moved.to_string()}" if len(moved) else "\nNo verdict differs")
    return 0


TARGETS = ("max_closure", "max_closure_net", "residual_closure")
INTERVAL = ["rock", "parameter", "cycle"]
MAY_DIFFER = ("provenance_", "timing_")
"""Prefixes of names whose values may differ between two runs of one study."""


def closure_changes(first: xr.Dataset, second: xr.Dataset) -> pd.DataFrame:
    """Tabulate the change of mean closures of every case that both studies have.

    Columns are, by case, cycle and target (`TARGETS`): the two means [mm], the change and its
    standard error [% of the first mean], the smaller number of realisations that succeeded, and
    whether both studies have the same surfaces. Surfaces are compared by their seeds. If they are
    the same, the differences are paired.

    Raises
    ------
    ValueError
        If the studies have no case in common.
    """
    shared = [name for name in first.case.values if name in set(second.case.values)]
    if not shared:
        raise ValueError("the studies have no case in common")
    cycles = sorted(set(first.cycle.values.tolist()) & set(second.cycle.values.tolist()))
    rows = []
    for name, cycle, target in itertools.product(shared, cycles, TARGETS):
        one = first.sel(case=name)
        two = second.sel(case=name)
        a, b = (1e3 * part[target].sel(cycle=cycle).values for part in (one, two))
        good = [succeeded(part).values for part in (one, two)]
        paired = one.sizes == two.sizes and np.array_equal(one.seed.values, two.seed.values)
        if paired:
            good = [good[0] & good[1]] * 2
        a = a[good[0]]
        b = b[good[1]]
        alone = np.hypot(_standard_error(a), _standard_error(b))
        error = _standard_error(b - a) if paired else alone
        base, other = (values.mean() if values.size else np.nan for values in (a, b))
        about = {"case": name} | {key: one[key].item() for key in ("rock", "parameter", "level")}
        rows.append(
            about
            | {
                "cycle": cycle,
                "target": target,
                "mean_first_mm": base,
                "mean_second_mm": other,
                "change_percent": 100.0 * (other - base) / base,
                "standard_error_percent": 100.0 * error / base,
                "samples": min(a.size, b.size),
                "same_surfaces": paired,
            }
        )
    return pd.DataFrame(rows)


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
    """Average `closure_changes` by rock, cycle and target, with the extremes over the cases."""
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


def differences(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """List all differences between two datasets except in provenance and timing, one line each."""
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
            elif kind == "variable" and (where := _difference(one[name], two[name])):
                messages.append(f"variable {name} differs{where}")
    return messages


def _difference(one: xr.Variable, two: xr.Variable) -> str:
    """Describe how two variables differ; "" if they have the same bits and attributes."""
    numbers = one.dtype.kind in "iuf"
    if one.identical(two) and not (numbers and one.values.tobytes() != two.values.tobytes()):
        return ""
    if one.shape != two.shape or not numbers:
        return f": {one.dtype} {dict(one.sizes)} and {two.dtype} {dict(two.sizes)}"
    unequal = ~((one.values == two.values) | (np.isnan(one.values) & np.isnan(two.values)))
    if not unequal.any():
        return " in its attributes, or in signs of zeros"
    with np.errstate(invalid="ignore"):
        largest = np.nanmax(np.abs(one.values - two.values), initial=0.0)
    return f" in {int(unequal.sum())} of {unequal.size} values, by at most {largest:.3g}"

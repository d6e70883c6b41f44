"""Mean closures, elasticities, indifference intervals and verdicts of two studies. Surfaces with
the same seeds are compared in pairs.
"""

import argparse
import itertools
import json
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.number_texts import rounded
from jointclosure.statistics.quadratics import elasticity_by_form, elasticity_contributions
from jointclosure.statistics.standard_errors import Estimate
from jointclosure.storage.files import read_csv, read_text
from jointclosure.storage.netcdf import read_netcdf
from studies.commands import existing, study_of
from studies.commands.differences import differences
from studies.frame.cases import ensembles_of
from studies.frame.configuration import read_stored
from studies.frame.joint_tables import succeeded
from studies.paper.closure_tables import ELASTIC, elastic_responses, elasticity_of_response
from studies.paper.responses import Response, rocks_of


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
    elasticities = elasticity_changes(*(_pool_of(folder) for folder in folders))
    if len(elasticities):
        print(f"\n{ABOUT_ELASTICITIES}")
        print(elasticities[SHOWN_OF_ELASTICITIES].to_string(index=False))
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


ABOUT_ELASTICITIES = (
    "Elasticities at the value of each rock, and their differences, ± standard error. Where both "
    "studies have the same surfaces, the error is that of differences on these, of the joints that "
    "succeeded in both; elsewhere it takes both studies as independent. It contains the form of "
    "the fitted curve (docs/model.md), but not the error of the numerics."
)
ELASTIC_TITLES = {
    "": "gross closure",
    "_net": "closure net of bulk",
    "_seated_net": "net closure since seating",
    "_stiffness": "net chord stiffness",
}
"""Titles of the results whose elasticities are compared, by the suffixes of their columns."""
SHOWN_OF_ELASTICITIES = [*INTERVAL, "of", "first", "second", "difference", "same_surfaces"]


def elasticity_changes(first: xr.Dataset, second: xr.Dataset) -> pd.DataFrame:
    """Tabulate the elasticities of two studies, or of their pools, and the differences.

    A row for each rock, property, cycle and result (``of``) of `ELASTIC` that both have. Columns
    ``first``, ``second`` and ``difference`` are texts with standard errors; ``difference_value``
    and ``difference_standard_error`` are numbers. With ``same_surfaces`` joints that failed in one
    study are left out of both.
    """
    rows = []
    for rock in [name for name in rocks_of(first) if name in rocks_of(second)]:
        one, two = (part.isel(case=(part.rock == rock).values) for part in (first, second))
        same = one.seed.shape == two.seed.shape and bool((one.seed.values == two.seed.values).all())
        same = same and np.array_equal(one.case.values, two.case.values)
        if same:
            one, two = _of_both(one, two)
        of_second = dict(_responses_of(two))
        for about, response in _responses_of(one):
            if about not in of_second:
                continue
            other = of_second[about]
            *names, suffix = about
            paired = same and np.array_equal(response.levels, other.levels)
            estimates = [elasticity_of_response(x, suffix) for x in (response, other)]
            change = _difference_of_elasticities(response, other, estimates, paired)
            row: dict[str, object] = dict(zip(INTERVAL, names, strict=True))
            row["of"] = ELASTIC_TITLES[suffix]
            shown = zip(("first", "second", "difference"), (*estimates, change), strict=True)
            row |= {name: rounded(*estimate) for name, estimate in shown}
            row |= {"difference_value": change.value, "same_surfaces": paired}
            rows.append(row | {"difference_standard_error": change.standard_error})
    return pd.DataFrame(rows)


def _of_both(one: xr.Dataset, two: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset]:
    """Return two datasets of the same joints without the results that only one of them has."""
    status = np.maximum(one.status.values, two.status.values)
    known = {
        name: np.isfinite(one[name].values) & np.isfinite(two[name].values)
        for name in ELASTIC.values()
        if name in one and name in two
    }
    parts = []
    for part in (one, two):
        both = {
            name: part[name].where(part[name].copy(data=where)) for name, where in known.items()
        }
        parts.append(part.assign(both | {"status": part.status.copy(data=status)}))
    return parts[0], parts[1]


def _responses_of(study: xr.Dataset) -> Iterator[tuple[tuple[str, str, int, str], Response]]:
    """Generate the responses of `elastic_responses` after rock, property, cycle and suffix."""
    for of_each in elastic_responses(study):
        for suffix, one in of_each.items():
            yield (one.rock, one.parameter, one.cycle, suffix), one


def _difference_of_elasticities(
    one: Response, two: Response, estimates: list[Estimate], paired: bool
) -> Estimate:
    """Return the difference of the elasticities of two responses with its standard error.

    If they are ``paired``, they have the same surfaces. What both have in common then cancels, in
    the scatter of the sample and in the difference between the forms of the fitted curve.
    """
    apart = estimates[1].value - estimates[0].value
    if not paired or not np.isfinite(apart) or (one.levels <= 0.0).any():
        errors = [estimate.standard_error for estimate in estimates]
        return Estimate(apart, math.hypot(*errors))
    of_one, of_two = (
        elasticity_contributions(part.levels, part.samples, part.base) for part in (one, two)
    )
    rows = of_two - of_one  # (level, joint)
    if one.paired:
        rows = rows.sum(axis=0, keepdims=True)
    of_sample = np.sqrt(rows.var(axis=1, ddof=1).sum() / rows.shape[1])
    (log_one, plain_one), (log_two, plain_two) = (
        elasticity_by_form(part.levels, part.means, part.base) for part in (one, two)
    )
    form = (log_two - plain_two) - (log_one - plain_one)
    return Estimate(apart, float(np.hypot(of_sample, form)))


def _pool_of(folder: Path) -> xr.Dataset:
    """Read the dataset by which elasticities of a study are known: its pool, or itself."""
    stated = json.loads(read_text(existing(folder / "tables/configuration.json")))
    has_pool = "pool" in ensembles_of(read_stored(stated))
    return read_netcdf(existing(folder / "pool.nc") if has_pool else study_of(folder))


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

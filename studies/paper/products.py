"""Products of a study, and what each is made of; functions import what draws, which is slow."""

from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.quantities import QUANTITIES
from jointclosure.parameters import Numerics
from jointclosure.statistics.repetitions import Design
from jointclosure.storage.files import read_csv
from jointclosure.storage.netcdf import read_netcdf, reading_netcdf
from studies.frame.keys import Accuracy, Grid, Statistics, Surface
from studies.frame.products import figure_files, product, products_of
from studies.frame.rocks import StudyRock
from studies.frame.yaml_files import configuration_text
from studies.paper import checks as checking
from studies.paper import closures as closure_tables
from studies.paper import judged_claims as published
from studies.paper import layout
from studies.paper.accuracy import describe_reached, reached_table
from studies.paper.conclusions import conclusion_table
from studies.paper.measured import CurveSettings, measured_curves
from studies.paper.predictive import joint_table, lengths_dataset, predictive, predictive_table
from studies.paper.responses import Covariates, as_dataset, from_dataset, known_covariates
from studies.paper.responses import measure_covariates as measure


def _known(path: str) -> Covariates:
    return from_dataset(read_netcdf(path))


CURVES = tuple(name for name, about in QUANTITIES.items() if "stress" in about.dims)
"""Curves over stress: nine tenths of the numbers of a study."""
Closures = Annotated[xr.Dataset, partial(read_netcdf, without=CURVES)]
"""Dataset of an ensemble without its curves."""
Curves = Annotated[xr.Dataset, reading_netcdf]
"""Dataset of an ensemble whose values are read only when they are used."""
Known = Annotated[Covariates, _known]
"""Covariates of a file."""
Log = Callable[[str], object]


def pooled(study: Any) -> bool:
    """Whether a study has a pool, by which the model is judged."""
    return study.study.pool is not None


def varied(study: Any) -> bool:
    """Whether a property is varied."""
    return any(rock.levels for rock in study.rocks.values())


def variates(study: Any) -> bool:
    """Whether means are adjusted by covariates; those of scanned walls are not known."""
    synthetic = any(rock.walls is None for rock in study.rocks.values())
    return study.statistics.control_variates is not None and synthetic


def has_curves(study: Any) -> bool:
    """Whether a rock has a measured curve."""
    return any(rock.measured for rock in study.rocks.values())


@product("covariates.nc", when=variates, early=True)
def measure_covariates(
    study: Closures, grid: Grid, surface: Surface, control_variates: int, root_seed: int
):
    """Measure the covariates of closed joints, and their means on further surfaces."""
    means = known_covariates(control_variates, root_seed, grid, surface)
    return as_dataset(Covariates(measure(study, grid, surface), means), study)


@product("pool_covariates.nc", when=lambda study: variates(study) and pooled(study))
def measure_pool_covariates(pool: Closures, covariates: Known, grid: Grid, surface: Surface):
    """Measure the covariates of the pool's joints; their means are those of the study."""
    return as_dataset(Covariates(measure(pool, grid, surface), covariates.known), pool)


@product("tables/correlations.csv", "tables/max_closure.csv", early=True)
def fit_correlations(study: Closures, covariates: Known | None):
    """Correlations of mean and standard deviation, Eqs. (24) to (27)."""
    return closure_tables.correlation_table(study), closure_tables.max_closure_table(
        study, covariates
    )


@product("tables/elasticities.csv")
def fit_elasticities(pool: Closures, pool_covariates: Known | None):
    """Elasticities of the closure, of all surfaces of a study."""
    return closure_tables.elasticity_table(pool, pool_covariates)


@product("tables/table_3_indifference.csv", early=True)
def find_indifference_intervals(
    study: Closures,
    paper: pd.DataFrame,
    covariates: Known | None,
    statistics: Statistics,
    root_seed: int,
):
    """Find the indifference intervals, Eqs. (28) and (29), beside the paper's."""
    return layout.with_paper(
        closure_tables.indifference_table(study, statistics, root_seed, covariates), paper
    )


@product("tables/measured_fit.csv", when=has_curves, early=True)
def fit_measured(
    study: Curves,
    curve_files: list[str],
    curves: dict[str, CurveSettings],
    seating_stress: float,
):
    """Find the realisations that fit the measured curves best."""
    return closure_tables.fit_table(study, measured_curves(curves), seating_stress)


@product("tables/hydraulic_aperture.csv", when=lambda study: study.flow, early=True)
def tabulate_flow(study: Annotated[xr.Dataset, read_netcdf]):
    """Hydraulic apertures of a study's cases as a table."""
    return checking.flow_table(study)


@product("tables/accuracy_reached.csv", when=lambda study: study.study.accuracy, early=True)
def reach_accuracy(
    study: Closures, finest: Closures, accuracy: Accuracy, significance: float, log: Log
):
    """Results by two levels, the study's numerics and the finest, and their errors."""
    table = reached_table(study, finest, accuracy, significance)
    log(describe_reached(table, accuracy))
    return table


@product("tables/table_3_predictive.csv", "tables/table_3_joint_tests.csv", "predictive.nc")
def predict_table_3(
    pool: Closures, paper: pd.DataFrame, design: Design, repetitions: int, root_seed: int
):
    """Predict Table 3 in repetitions of the study, and test whether the paper's is one of them."""
    lengths = predictive(pool, design, repetitions, root_seed)
    return predictive_table(lengths, paper), joint_table(lengths, paper), lengths_dataset(lengths)


@product("tables/claims.csv", "tables/claim_margins.csv")
def judge_claims(
    study: Curves,
    pool: Curves,
    paper: pd.DataFrame,
    design: Design,
    repetitions: int,
    root_seed: int,
):
    """Judge the paper's claims by the model and by the study."""
    evidence = published.Evidence(study, pool, design, repetitions, root_seed)
    return published.judge_claims(evidence, paper)


@product("tables/checks.csv")
def check_results(ensembles: list[Closures], closed_by: dict[str, tuple[int, Numerics]], log: Log):
    """Check the results; `require_checks` makes an error of a failed check."""
    checks = pd.concat(
        checking.check_results(ensemble, numerics, realizations, name)
        for ensemble, (name, (realizations, numerics)) in zip(
            ensembles, closed_by.items(), strict=True
        )
    )
    for row in checks.itertuples():
        verdict = "passed" if row.passed else "FAILED"
        log(f"{verdict}: {row.ensemble}: {row.check}: {row.found} ({row.required})")
    return checks


# after the table is there to be read, also where a check fails
@product("logs/checks_passed.txt")
def require_checks(checks: str) -> str:
    """Fail if a check of the results has failed."""
    table = read_csv(checks)
    failed = [
        f"{row.check} ({row.ensemble}): {row.found}, required {row.required}"
        for row in table[~table.passed].itertuples()
    ]
    if failed:
        raise SystemExit(f"{checks}: results fail their checks: {'; '.join(failed)}")
    return f"{len(table)} checks passed\n"


@product(
    "tables/table_1_rocks.csv",
    "tables/table_2_cases.csv",
    "tables/table_3_indifference.md",
    early=True,
)
def write_tables(
    table_3_indifference: pd.DataFrame,
    max_closure: pd.DataFrame,
    elasticities: pd.DataFrame | None,
    rocks: dict[str, StudyRock],
    titles: dict[str, str],
):
    """Write Tables 1 to 3 in the paper's layout."""
    tables = layout.rock_table(rocks, max_closure), layout.case_table(rocks, max_closure)
    markdown = layout.table_3_markdown(table_3_indifference, titles, elasticities)
    return *tables, markdown


@product("tables/configuration.json")
def state_configuration(stated: dict) -> str:
    """State all keys of the study, of which study.nc has those that may change closures."""
    return configuration_text(stated)


@product("tables/conclusions.csv", apart=True)
def conclude(
    claims: pd.DataFrame,
    jrc_range: pd.DataFrame | None,
    readings: pd.DataFrame | None,
    choices: pd.DataFrame | None,
    margins: pd.DataFrame | None,
    log: Log,
):
    """Tabulate the evidence for each conclusion of the paper."""
    tables = {"jrc_range": jrc_range, "readings": readings, "choices": choices, "margins": margins}
    for name in (name for name, table in tables.items() if table is None):
        log(f"{name}: of the default study only; the columns are empty")
    return conclusion_table(claims, **tables)


def _of_study(study: Any) -> list[str]:
    names = ["fig_3_equivalent_stress", "fig_5_closure", "closure_since_seating", "wall_pair"]
    names += ["hydraulic_aperture"] if study.flow else []
    return figure_files(
        names + (["table_3_intervals", "trends_max_closure"] if varied(study) else [])
    )


@product(listed=_of_study, early=True)
def draw_figures(
    study: Annotated[xr.Dataset, reading_netcdf],
    table_3_indifference: pd.DataFrame,
    max_closure: pd.DataFrame,
    first_walls: Annotated[xr.Dataset, read_netcdf],
    curve_files: list[str],
    measured_fit: pd.DataFrame | None,
    hydraulic_aperture: pd.DataFrame | None,
    rocks: dict[str, StudyRock],
    curves: dict[str, CurveSettings],
    seating_stress: float,
    wall_strength_ratio: float,
    log: Callable[[str], object],
):
    """Draw the figures of the study itself, as PNG and PDF."""
    from studies.paper import figures as plotting

    measured = plotting.Measurements()
    if measured_fit is not None:
        measured = measured._replace(curves=measured_curves(curves), fits=measured_fit)
    drawn = np.union1d(study.realization.values[: plotting.MOST_DRAWN], measured.best)
    shown = study.sel(realization=drawn.astype(int)).load()
    log(f"curves of {shown.sizes['realization']} of {study.sizes['realization']} surfaces")
    first = next(iter(rocks.values()))

    title = f"{first.title}, {layout.roughness_title(first)}, realisation 0"
    walls = first_walls.upper.values, first_walls.lower.values, first_walls.attrs["spacing_m"]
    figures = {
        "fig_3_equivalent_stress": plotting.equivalent_stress(),
        "fig_5_closure": plotting.closure_figure(shown, rocks, None, wall_strength_ratio),
        "closure_since_seating": plotting.closure_figure(
            shown, rocks, seating_stress, wall_strength_ratio, measured
        ),
        "wall_pair": plotting.wall_pair_figure(*walls, title),
    }
    if hydraulic_aperture is not None:
        flow = plotting.flow_figure(hydraulic_aperture, rocks, seating_stress)
        figures["hydraulic_aperture"] = flow
    if any(rock.levels for rock in rocks.values()):
        figures["table_3_intervals"] = plotting.interval_figure(table_3_indifference, rocks)
        figures["trends_max_closure"] = plotting.trend_figure(max_closure, shown, rocks)
    return figures


@product(figures=["table_3_predictive"], when=varied)
def draw_pool_figures(
    lengths: Annotated[xr.Dataset, read_netcdf],
    paper: pd.DataFrame,
    rocks: dict[str, StudyRock],
    realizations: int,
):
    """Draw the figures of the study's pool, as PNG and PDF."""
    from studies.paper.figures import predictive_figure

    return predictive_figure(lengths, paper, rocks, realizations)


PRODUCTS = products_of("paper")

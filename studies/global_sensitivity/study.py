"""Experiment on global sensitivity: variance indices of properties and of open choices."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from jointclosure.engine.points import JobsOnDemand, Point, Sample
from studies.frame.config.configuration import Configured
from studies.frame.experiments import Design, Experiment, Tables
from studies.global_sensitivity.conclusions import conclusion_tables
from studies.global_sensitivity.design import (
    SURFACES,
    check_sampling,
    sampling_of,
    settings_of_choices,
    settings_of_rock,
)
from studies.global_sensitivity.figures import conclusions, convergence, indices
from studies.global_sensitivity.table import QUANTITIES, by_rock, elasticity_table, index_table

PREFIX = "global_sensitivity_"
TRIED = 8
"""Number of rows whose first point is closed to estimate the time of a rock."""


def global_sensitivity_design(configured: Configured) -> Design:
    """Make a job for each rock and block of rows; added rows change no earlier block."""
    keys, sampling = configured.keys, sampling_of(configured.typed)
    makers = {rock: settings_of_rock(sampling, configured, rock) for rock in sampling.rocks}

    def points_of(rock: str, rows: range) -> list[Point]:
        return [
            Point({"rock": rock, "row": row, "point": place}, makers[rock](row, point))
            for row in rows
            for place, point in enumerate(sampling.points()[row])
        ]

    def samples() -> dict[str, list[Sample]]:
        joints = sampling.rows * (len(sampling.inputs) + 2) * SURFACES
        rows = range(min(TRIED, sampling.rows))
        return {
            rock: [Sample([points_of(rock, range(row, row + 1))[0] for row in rows], joints)]
            for rock in sampling.rocks
        }

    return Design(
        JobsOnDemand(
            {
                f"{rock}.{rows.start}": (rock, rows)
                for rock in sampling.rocks
                for rows in sampling.blocks()
            },
            points_of,
        ),
        tuple(PREFIX + name for name in ("indices", "elasticities", "conclusions", "margins")),
        tuple(PREFIX + name for name in ("indices", "convergence", "conclusions")),
        {
            "sampling": sampling,
            "rocks": {rock: keys["rocks"][rock] for rock in sampling.rocks},
        },
        compiled=lambda: settings_of_choices(sampling, makers[sampling.rocks[0]]),
        samples=samples,
    )


def global_sensitivity_tables(joints: pd.DataFrame, parameters: Mapping[str, Any]) -> Tables:
    """Return indices, elasticities, shares of choices for which conclusions hold, and margins."""
    sampling, closed = parameters["sampling"], by_rock(joints)
    held, margins = conclusion_tables(sampling, parameters, closed)
    tables = {
        "indices": index_table(sampling, closed),
        "elasticities": elasticity_table(sampling, parameters, closed),
        "conclusions": held,
        "margins": margins,
    }
    return {PREFIX + name: table for name, table in tables.items()}


def global_sensitivity_figure(name: str, tables: Tables, parameters: Mapping[str, Any]) -> Figure:
    """Draw indices, their convergence with the rows, or the shares for which conclusions hold."""
    titles = {rock: keys["title"] for rock, keys in parameters["rocks"].items()}
    figure = name.removeprefix(PREFIX)
    if figure == "conclusions":
        return conclusions(tables[f"{PREFIX}conclusions"], titles)
    drawn = {"indices": indices, "convergence": convergence}[figure]
    return drawn(tables[f"{PREFIX}indices"], titles)


EXPERIMENT = Experiment(
    title="global sensitivity to properties and open choices that vary together",
    quantities=QUANTITIES,
    design=global_sensitivity_design,
    tabulate=global_sensitivity_tables,
    draw=global_sensitivity_figure,
    check=check_sampling,
)

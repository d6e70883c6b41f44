"""Experiment on readings of the paper: which of them gives its Table 3."""

import os
from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from jointclosure.claims.findings import LOOP
from jointclosure.config.configuration import Configured
from jointclosure.config.files import PAPER_TABLE_3
from jointclosure.config.plain import from_plain, to_plain
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.points import JobsOnDemand
from jointclosure.experiments import Design, Experiment, Rounds, Tables
from jointclosure.experiments.readings.average import (
    AVERAGE_TABLES,
    average_tables,
    comparable,
)
from jointclosure.experiments.readings.design import (
    CLOSURES,
    Readings,
    check_readings,
    entering,
    readings_of,
)
from jointclosure.experiments.readings.likelihood import Question, question_of
from jointclosure.experiments.readings.points import (
    jobs_of_round,
    points_of_jobs,
    samples,
    settings_of_kernels,
)
from jointclosure.experiments.readings.table import (
    implied_table,
    readings_markdown,
    readings_table,
    round_table,
)
from jointclosure.plotting.readings import likelihoods, sensitivities


def readings_design(configured: Configured) -> Design:
    """Make a job for each reading, rock and block of surfaces; rounds close those they need."""
    readings = readings_of(configured.keys)
    jobs = JobsOnDemand(*points_of_jobs(readings, configured))
    return Design(
        jobs,
        ("readings", "readings_implied", "readings.md", *AVERAGE_TABLES),
        ("readings_likelihood", "readings_sensitivity"),
        {"readings": to_plain(readings), "question": _question(configured)},
        files={"paper": os.path.relpath(PAPER_TABLE_3)},  # valid where the whole folder is moved
        compiled=lambda: settings_of_kernels(readings, configured),
        samples=lambda: samples(readings, jobs),
        rounds=Rounds(
            tuple(one.name for one in readings.rounds),
            lambda number, before: entering(readings, configured.keys, number, before),
            lambda number, entrants: jobs_of_round(readings, number, entrants),
        ),
    )


def _question(configured: Configured) -> dict:
    """Return the plain data that `question_of` needs besides the paper's table."""
    section, typed = configured.keys["readings"], configured.typed
    return {
        "parameters": {
            name: {
                parameter: [list(levels), base_case(name, rock).property(parameter)]
                for parameter, levels in rock.levels.items()
            }
            for name, rock in typed.rocks.items()
        },
        "significance": typed.statistics.significance,
        "root_seed": typed.study.root_seed,
        **{name: section[name] for name in ("draws", "repetitions", "groups")},
    }


def _restored(parameters: Mapping[str, Any]) -> tuple[Readings, Question]:
    """Restore the readings and the question from the parameters of a design."""
    question = question_of(parameters["question"], parameters["paper"])
    return from_plain(Readings, parameters["readings"]), question


def readings_ranking(
    joints: pd.DataFrame, parameters: Mapping[str, Any], number: int, entrants: list[str]
) -> pd.DataFrame:
    """Rank a round by the likelihood of Table 3; the ranking is empty if no reading entered."""
    readings, question = _restored(parameters)
    return round_table(readings, number, entrants, joints, question)


def readings_tables(joints: pd.DataFrame, parameters: Mapping[str, Any]) -> Tables:
    """Return a row for each reading, as CSV and Markdown, and the scatter implied by Table 3."""
    readings, question = _restored(parameters)
    ranked = parameters["rounds"]
    table = readings_table(readings, ranked, joints, question)
    implied = implied_table(readings, ranked, joints, question)
    averaged = average_tables(*comparable(readings, ranked, joints), question)
    return {
        "readings": table,
        "readings_implied": implied,
        "readings.md": readings_markdown(table, implied),
        **averaged,
    }


def readings_figure(name: str, tables: Tables, parameters: Mapping[str, Any]) -> Figure:
    """Draw the likelihood of Table 3 in each reading, or the sensitivities of readings."""
    if name == "readings_likelihood":
        return likelihoods(tables["readings"], tables["readings_implied"])
    return sensitivities(tables["readings"], parameters["paper"], parameters["question"]["draws"])


EXPERIMENT = Experiment(
    title="likelihood of the paper's Table 3 in readings of the paper",
    quantities=(*CLOSURES.values(), LOOP),
    design=readings_design,
    tabulate=readings_tables,
    draw=readings_figure,
    check=check_readings,
    rank=readings_ranking,
)

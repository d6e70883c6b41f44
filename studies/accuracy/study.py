"""Experiment on the cost of accuracy: the same surfaces closed at many settings of numerics."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from jointclosure.engine.points import Point
from jointclosure.statistics.randomness import generator, seed_of
from studies.accuracy.cost import (
    Resampling,
    cost_table,
    order_table,
    runs_of,
    source_table,
)
from studies.accuracy.design import design_of
from studies.accuracy.figures import SCENE_TITLES, error_sources, work_precision
from studies.frame.config.configuration import Configured
from studies.frame.experiments import Design, Experiment, Tables

PREFIX = "accuracy_"


def accuracy_design(configured: Configured) -> Design:
    """Make a job for each run: its surfaces at all levels of the varied property."""
    settings, runs = design_of(configured.keys)
    keys, configuration = configured.keys["accuracy"], configured.typed
    jobs = {
        name: [
            Point({"run": name, "level": value}, level)
            for value, level in zip(run.values, run.levels, strict=True)
        ]
        for name, run in runs.items()
    }
    parameters = {
        "settings": settings,
        "bases": {name: run.base for name, run in runs.items()},
        "keys": keys,
        "root_seed": configuration.study.root_seed,
        "realizations": configuration.study.realizations,
        "significance": configuration.statistics.significance,
    }
    variants = sorted({setting.scene for setting in settings})
    return Design(
        jobs,
        tuple(PREFIX + name for name in ("cost", "orders", "sources")),
        tuple(PREFIX + name for name in (*variants, "sources")),
        parameters,
    )


def accuracy_tables(joints: pd.DataFrame, parameters: Mapping[str, Any]) -> Tables:
    """Return costs, orders of convergence, and sources of error."""
    keys, settings = parameters["keys"], parameters["settings"]
    runs, seed = runs_of(joints, parameters["bases"]), parameters["root_seed"]
    drawn, drawn_for_sources = (
        Resampling(generator(seed_of(seed, *name)), keys["resamples"], keys["confidence"])
        for name in (("accuracy",), ("accuracy", "sources"))
    )
    finest = {name: scene["finest"] for name, scene in keys["scenes"].items()}
    costs = cost_table(settings, runs, finest, drawn, parameters["significance"])
    sources = [
        source_table(costs, runs, scene, parameters["realizations"], drawn_for_sources)
        for scene in keys["scenes"]
    ]
    tables = {
        "cost": costs,
        "orders": order_table(costs),
        "sources": pd.concat(sources),
    }
    return {PREFIX + name: table for name, table in tables.items()}


def accuracy_figure(name: str, tables: Tables, parameters: Mapping[str, Any]) -> Figure:
    """Draw the error over time for one variant of the model, or the sources of the error."""
    costs, sources = tables[f"{PREFIX}cost"], tables[f"{PREFIX}sources"]
    variant = name.removeprefix(PREFIX)
    if variant == "sources":
        with_rules = sources.groupby("scene").source.transform(
            lambda of_scene: of_scene.str.startswith("surface rule").any()
        )
        shown = sources[with_rules] if with_rules.any() else sources
        return error_sources(shown, "Sources of the error of the configured setting")
    title = f"Cost of accuracy: {SCENE_TITLES.get(variant, variant.replace('_', ' '))}"
    return work_precision(costs[costs.scene == variant], title, "as configured (the paper's)")


EXPERIMENT = Experiment(
    title="cost of accuracy",
    quantities=("max_closure", "max_closure_net", "fft_pair"),
    design=accuracy_design,
    tabulate=accuracy_tables,
    draw=accuracy_figure,
)

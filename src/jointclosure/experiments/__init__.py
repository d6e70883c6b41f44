"""Experiments: which joints are closed, and the tables and figures that follow from them.

An experiment is a module here with a constant ``EXPERIMENT``. It closes nothing itself: the engine
(`jointclosure.ensemble.points`) closes its points. A new one is named in `SECTIONS`.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

import pandas as pd

from jointclosure.config.configuration import Configured
from jointclosure.ensemble.points import Jobs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SECTIONS = {"misalignment": "misalignment"}
"""The section of the configuration that each experiment needs, by the experiment's name."""


class Experiment(NamedTuple):
    """An experiment.

    Attributes
    ----------
    title : str
        What is examined, in a few words.
    jobs : callable
        From a checked configuration: the points of each job.
    quantities : tuple of str
        Read of each joint.
    tables : dict of callable
        By name: a table from the table of all points, and `parameters`.
    figures : dict of callable
        By name: a figure from the tables.
    parameters : callable
        From a checked configuration: what tables need besides the points, as plain data.
    """

    title: str
    jobs: Callable[[Configured], Jobs]
    quantities: tuple[str, ...]
    tables: Mapping[str, Callable[[pd.DataFrame, Mapping[str, Any]], pd.DataFrame]]
    figures: Mapping[str, Callable[[Mapping[str, pd.DataFrame]], "Figure"]]
    parameters: Callable[[Configured], dict] = lambda configured: {}


def experiment_named(name: str) -> Experiment:
    """The experiment of a name of `SECTIONS`."""
    return import_module(f"{__name__}.{name}").EXPERIMENT


def experiments_in(keys: Mapping[str, Any]) -> dict[str, Experiment]:
    """The experiments whose section a configuration has, by name."""
    return {name: experiment_named(name) for name, key in SECTIONS.items() if keys.get(key)}

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

SECTIONS = {
    "accuracy": "accuracy",
    "effects": "ablation",
    "misalignment": "misalignment",
    "mismatch": "mismatch",
    "size": "size",
}
"""The section of the configuration that each experiment needs, by the experiment's name."""


class Design(NamedTuple):
    """What a configuration asks of an experiment.

    Attributes
    ----------
    jobs : mapping
        The points of each job.
    tables, figures : tuple of str
        Names of the files that are written.
    parameters : dict
        What tables need besides the joints, as plain data.
    """

    jobs: Jobs
    tables: tuple[str, ...]
    figures: tuple[str, ...]
    parameters: dict[str, Any]


Tables = Mapping[str, pd.DataFrame]


class Experiment(NamedTuple):
    """An experiment.

    Attributes
    ----------
    title : str
        What is examined, in a few words.
    quantities : tuple of str
        Read of each joint, of `jointclosure.ensemble.quantities.QUANTITIES`.
    design : callable
        From a checked configuration. It raises `ConfigurationError` where that contradicts itself.
    tabulate : callable
        Tables by name, from the table of all joints and the parameters of the design.
    draw : callable
        Figure of a name, from the tables by name.
    """

    title: str
    quantities: tuple[str, ...]
    design: Callable[[Configured], Design]
    tabulate: Callable[[pd.DataFrame, Mapping[str, Any]], Tables]
    draw: Callable[[str, Tables], "Figure"]


def experiment_named(name: str) -> Experiment:
    """The experiment of a name of `SECTIONS`."""
    return import_module(f"{__name__}.{name}").EXPERIMENT


def experiments_in(keys: Mapping[str, Any]) -> dict[str, Experiment]:
    """The experiments whose section a configuration has, by name."""
    return {name: experiment_named(name) for name, key in SECTIONS.items() if keys.get(key)}

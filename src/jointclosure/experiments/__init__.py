"""Experiments: which joints are closed, and the tables and figures that follow from them.

An experiment is a module here with a constant ``EXPERIMENT``. It closes nothing itself: the engine
(`jointclosure.ensemble.points`) closes its points. A new one is named in `SECTIONS`.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import pandas as pd

from jointclosure.config.configuration import Configured
from jointclosure.config.keys.configuration import SECTIONS
from jointclosure.ensemble.points import Jobs, Samples, samples_of
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.joint.warmup import kernels_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Tables = Mapping[str, Any]
"""A DataFrame by the name of its table; a text by that of a file that ends in .md."""


class Rounds(NamedTuple):
    """Rounds of an experiment: what one closes is known when the round before is ranked.

    Attributes
    ----------
    names : tuple of str
    entrants : callable
        Names of those that enter a round, from its number and the ranking of the round before,
        None for the first round.
    jobs : callable
        Names of the jobs that a round needs, from its number and its entrants.
    """

    names: tuple[str, ...]
    entrants: Callable[[int, pd.DataFrame | None], list[str]]
    jobs: Callable[[int, Sequence[str]], list[str]]


class Design(NamedTuple):
    """What a configuration asks of an experiment.

    It is made anew by every process of the workflow: what takes long is made when it is asked for.

    Attributes
    ----------
    jobs : mapping
        The points of each job, of all that any round may close.
    tables, figures : tuple of str
        Names of the files that are written.
    parameters : dict
        What tables and figures need besides the joints, as plain data.
    files : mapping
        Further tables (CSV) that are read into the parameters, by the parameter's name.
    compiled : callable, optional
        Settings of all kernels that are needed; without it those of all points.
    samples : callable, optional
        Points by which the time is estimated; without it `samples_of` all jobs.
    rounds : Rounds, optional
        Without it all jobs are closed.
    """

    jobs: Jobs
    tables: tuple[str, ...]
    figures: tuple[str, ...]
    parameters: dict[str, Any]
    files: Mapping[str, str] = MappingProxyType({})
    compiled: Callable[[], Iterable[ClosureSettings]] | None = None
    samples: Callable[[], Samples] | None = None
    rounds: Rounds | None = None

    def kernels(self) -> list[list[str]]:
        """Kernels that are compiled before the jobs start."""
        points = (point.settings for job in self.jobs for point in self.jobs[job])
        settings = points if self.compiled is None else self.compiled()
        return kernels_of((each.case.effects, each.choices, each.numerics) for each in settings)

    def timed(self) -> Samples:
        """Points by which the time is estimated."""
        return samples_of(self.jobs) if self.samples is None else self.samples()


def _nothing_to_check(configured: Configured) -> None:
    """Accept every configuration: `design` raises what is wrong."""


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
        Tables by name, from the table of all joints and the parameters of the design, to which
        ``rounds`` adds the ranking of each round.
    draw : callable
        Figure of a name, from the tables by name and the parameters of the design.
    check : callable
        Raises `ConfigurationError` where the settings of points cannot be closed, if finding that
        takes more than ``design`` may: it is called once, before any job.
    rank : callable, optional
        Ranking of a round, from the joints that it needs, the parameters of the design, the
        round's number and its entrants.
    """

    title: str
    quantities: tuple[str, ...]
    design: Callable[[Configured], Design]
    tabulate: Callable[[pd.DataFrame, Mapping[str, Any]], Tables]
    draw: Callable[[str, Tables, Mapping[str, Any]], "Figure"]
    check: Callable[[Configured], None] = _nothing_to_check
    rank: Callable[[pd.DataFrame, Mapping[str, Any], int, list[str]], pd.DataFrame] | None = None


def experiment_named(name: str) -> Experiment:
    """The experiment of a name of `SECTIONS`."""
    return import_module(f"{__name__}.{name}").EXPERIMENT


def experiments_in(keys: Mapping[str, Any]) -> dict[str, Experiment]:
    """The experiments whose section a configuration has, by name."""
    return {name: experiment_named(name) for name, key in SECTIONS.items() if keys.get(key)}


def checked_design(name: str, configured: Configured) -> Design:
    """The design of an experiment, of which all is checked that can be before a job starts."""
    experiment = experiment_named(name)
    experiment.check(configured)
    return experiment.design(configured)

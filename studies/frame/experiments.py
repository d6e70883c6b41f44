"""Experiments: points at which joints are closed, and the tables and figures made of them.

An experiment is a folder of `studies` with its section of the configuration (``section.py``) and a
constant ``EXPERIMENT`` (``study.py``). Its points are closed by
`jointclosure.engine.ensembles`.
"""

from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import pandas as pd

from jointclosure.engine.cache import Entry
from jointclosure.engine.ensembles import Jobs, Samples, entries_of, samples_of
from jointclosure.engine.settings import Case, ClosureSettings
from jointclosure.joint.warmup import kernels_of
from studies.frame.cases import block_settings
from studies.frame.closing import Ensemble
from studies.frame.configuration import Configuration, Configured, resolved, sections

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Tables = Mapping[str, Any]
"""DataFrames by name of the table; texts by name of a file that ends in .md."""


class Design(NamedTuple):
    """Points of each job, and names of the tables and figures, for one configuration.

    ``parameters`` are what tables and figures need besides the joints, and ``files`` further tables
    (CSV) that are read into them. Jobs make the design anew, so slow parts are callables:
    ``compiled`` gives the settings of all necessary kernels (by default of all points), and
    ``samples`` the points whose closure estimates the time (by default `samples_of` all jobs).
    """

    jobs: Jobs
    tables: tuple[str, ...]
    figures: tuple[str, ...]
    parameters: dict[str, Any]
    files: Mapping[str, str] = MappingProxyType({})
    compiled: Callable[[], Iterable[ClosureSettings]] | None = None
    samples: Callable[[], Samples] | None = None

    def kernels(self) -> list[list[str]]:
        """Return the kernels that are compiled before the jobs start."""
        points = (point.settings for job in self.jobs for point in self.jobs[job])
        return kernels_of(
            (settings.case.effects, settings.choices, settings.numerics)
            for settings in (points if self.compiled is None else self.compiled())
        )

    def timed(self) -> Samples:
        """Return the points whose closure estimates the time."""
        return samples_of(self.jobs) if self.samples is None else self.samples()


class Experiment(NamedTuple):
    """Description of an experiment, the same for all configurations.

    ``quantities`` are read of each joint (`jointclosure.engine.quantities.QUANTITIES`). ``design``
    refuses a checked configuration by `ConfigurationError`; ``check`` too, once before any job,
    where that is slow. ``tabulate`` makes tables by name from the table of all joints and the
    parameters of the design, and ``draw`` the figure of a name from the tables and the parameters.
    """

    title: str
    quantities: tuple[str, ...]
    design: Callable[[Configured], Design]
    tabulate: Callable[[pd.DataFrame, Mapping[str, Any]], Tables]
    draw: Callable[[str, Tables, Mapping[str, Any]], "Figure"]
    check: Callable[[Configured], None] = lambda configured: None


def experiment_named(name: str) -> Experiment:
    """Return the experiment of a folder."""
    return import_module(f"studies.{name}.study").EXPERIMENT


def experiments_in(keys: Mapping[str, Any]) -> dict[str, Experiment]:
    """Return the experiments whose section a configuration has, by name."""
    given = (name for name, section in sections().items() if keys.get(section.name))
    return {name: experiment_named(name) for name in given}


def checked_design(name: str, configured: Configured) -> Design:
    """Make the design of an experiment after all checks that precede its jobs."""
    experiment = experiment_named(name)
    experiment.check(configured)
    return experiment.design(configured)


def settings_of(configuration: Configuration, case: Case, **surface: Any) -> ClosureSettings:
    """Return the settings that close a case on all realisations, with changed keys of surfaces."""
    changed = configuration._replace(surface=configuration.surface._replace(**surface))
    block = range(configuration.study.realizations)
    return block_settings(changed, {case.label: case}, case.label, block)


def labelled_wavelengths(wavelengths: Iterable[float]) -> dict[str, float | None]:
    """Return mismatch wavelengths [m] by label, in micrometres; independent walls (None) last."""
    return {f"{1e6 * value:.15g}um": value for value in wavelengths} | {"independent": None}


def checked(keys: dict) -> Configured:
    """Return the configuration of keys that were checked before a job started."""
    return Configured(keys, resolved(keys))


def cached(configured: Configured, kind: str, folder: Path | None = None) -> dict[str, Entry]:
    """Return the files of an ensemble, of pilots (effects_of) or of an experiment by name."""
    if kind in sections():
        experiment = experiment_named(kind)
        entries = entries_of(kind, experiment.design(configured).jobs, experiment.quantities)
    elif kind == "effects_of":
        entries = list(Ensemble(configured.typed).pilots(folder or Path()).values())
    else:
        entries = Ensemble(configured.typed, kind).entries(folder)
    return {entry.name: entry for entry in entries}

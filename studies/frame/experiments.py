"""Experiments: points at which joints are closed, and the tables and figures made of them.

An experiment is a folder of `studies` with its section of the configuration (``section.py``) and a
constant ``EXPERIMENT`` (``study.py``).
"""

import math
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import pandas as pd

from jointclosure.engine.cache import Entry, digest, make_missing
from jointclosure.joint.warmup import kernels_of
from jointclosure.storage.files import read_csv
from jointclosure.storage.logs import Logbook
from jointclosure.storage.netcdf import read_netcdf
from studies.frame.cases import block_settings
from studies.frame.closing import Ensemble
from studies.frame.configuration import Configuration, Configured, resolved, sections
from studies.frame.files import provenance
from studies.frame.jobs import compile_all
from studies.frame.points import (
    Jobs,
    Point,
    as_dataset,
    as_table,
    entries_of,
    estimated_time,
    tried_points,
)
from studies.frame.products import Step, figure_files
from studies.frame.settings import Case, ClosureSettings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Tables = Mapping[str, Any]
"""DataFrames by name of the table; texts by name of a file that ends in .md."""


class Design(NamedTuple):
    """Points of each job, and names of the tables and figures, for one configuration.

    ``jobs`` makes the points when they are needed. ``parameters`` are what tables and figures need
    besides the joints.
    """

    jobs: Callable[[], Jobs]
    tables: tuple[str, ...]
    figures: tuple[str, ...]
    parameters: dict[str, Any]

    def points(self) -> list[Point]:
        """Return the points of all jobs."""
        return [point for job in self.jobs().values() for point in job]

    def kernels(self) -> list[list[str]]:
        """Return the kernels that are compiled before the jobs start."""
        conditions = [point.settings.conditions for point in self.points()]
        return kernels_of((one.effects, one.choices, one.numerics) for one in conditions)


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


def cached(configured: Configured, kind: str, folder: Path | None = None) -> dict[str, Entry]:
    """Return the files of an ensemble, of pilots (effects_of) or of an experiment by name."""
    if kind in sections():
        experiment = experiment_named(kind)
        entries = entries_of(kind, experiment.design(configured).jobs(), experiment.quantities)
    elif kind == "effects_of":
        entries = list(Ensemble(configured.typed, folder=folder).pilots().values())
    else:
        entries = Ensemble(configured.typed, kind, folder).entries()
    return {entry.name: entry for entry in entries}


def close_apart(config: dict, kind: str, block: str, folder: Path, log: Logbook) -> None:
    """Close the joints of one file of the cache, on a node of a cluster."""
    entry = cached(Configured(config, resolved(config)), kind, folder)[f"{kind}/{block}"]
    make_missing([entry], folder, 1, log)


def design_in(config: dict, name: str) -> tuple[Experiment, Design]:
    """Return an experiment, and its design by keys that were checked before a job started."""
    experiment = experiment_named(name)
    return experiment, experiment.design(Configured(config, resolved(config)))


def estimate_time(config: dict, name: str, log: Logbook) -> pd.DataFrame:
    """Estimate the time of an experiment from a few of its joints."""
    _, design = design_in(config, name)
    compile_all(design.kernels(), log)
    table = estimated_time(design.points(), log)
    minutes, error = table.seconds.sum() / 60, math.hypot(*table.error) / 60
    known = f" ± {error:.0f}" if math.isfinite(error) else ""
    joints = f"{table.joints.sum()} joints will take"
    log.show(f"{joints} about {minutes:.2g}{known} minutes on one core")
    return table


def close_experiment(
    config: dict, name: str, folder: Path, workers: int, log: Logbook
) -> dict[str, Any]:
    """Close the joints of an experiment that are missing, and make its tables."""
    experiment, design = design_in(config, name)
    entries = entries_of(name, design.jobs(), experiment.quantities)
    prepare = partial(compile_all, design.kernels(), log)
    make_missing(entries, folder, workers, log.show, "joints closed", prepare)
    joints = as_table(*(read_netcdf(entry.file(folder)) for entry in entries))
    dataset = as_dataset(joints).assign_attrs(provenance(config))
    return {f"{name}.nc": dataset, **experiment.tabulate(joints, design.parameters)}


def draw_experiment(config: dict, name: str, tables: list[str]) -> dict[str, Any]:
    """Draw the figures of an experiment from its tables."""
    experiment, design = design_in(config, name)
    read = {Path(path).stem: read_csv(path) for path in tables if path.endswith(".csv")}
    return {figure: experiment.draw(figure, read, design.parameters) for figure in design.figures}


def steps_of(
    name: str, design: Design, folder: str, closed: Any, key: Callable[[], str]
) -> dict[str, Step]:
    """Return the steps of an experiment, whose joints have a ``key`` and files ``closed`` apart."""
    named = [table if "." in table else f"{table}.csv" for table in design.tables]
    tables = [f"{folder}/tables/{table}" for table in named]
    figures = figure_files(design.figures, f"{folder}/figures")
    given: dict[str, Any] = {"settings": {"name": name}, "uses": f"studies.{name}"}
    return {
        f"estimate_{name}": Step(
            estimate_time,
            [f"{folder}/tables/{name}_estimate.csv"],
            settings={"name": name},
            depends=lambda: digest(tried_points(design.points())),
            priority=100,
        ),
        f"close_{name}": Step(
            close_experiment,
            [f"{folder}/{name}.nc", *tables],
            {"closed": closed},
            depends=lambda: digest(key(), design.parameters),
            all_cores=True,
            **given,
        ),
        f"draw_{name}": Step(
            draw_experiment,
            figures,
            {"tables": tables},
            depends=lambda: digest(design.parameters),
            **given,
        ),
    }

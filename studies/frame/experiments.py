"""Experiments: points at which joints are closed, and products of the table of all joints.

An experiment is a folder of `studies`: ``section.py``, its section of the configuration; and
``study.py``, a constant ``EXPERIMENT`` and products.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import xarray as xr

from jointclosure.engine.cache import Entry, digest, make_missing
from jointclosure.joint.warmup import compile_all, kernels_of
from jointclosure.storage.logs import Logbook
from jointclosure.storage.netcdf import read_netcdf
from studies.frame.cases import base_case, block_settings
from studies.frame.closing import Ensemble
from studies.frame.configuration import Configuration, resolved, sections
from studies.frame.plan import steps_of_products
from studies.frame.points import (
    Jobs,
    Point,
    as_dataset,
    as_table,
    close_points,
    closed_table,
    joints_of,
)
from studies.frame.products import Step
from studies.frame.settings import Case, ClosureSettings
from studies.frame.yaml_files import folder_of, provenance

TRIED = 3
"""Alike points of which one joint is closed to estimate the time of all."""


class Design(NamedTuple):
    """Joints of an experiment in a study; points are made when they are needed."""

    name: str
    quantities: tuple[str, ...]
    jobs: Callable[[], Jobs]

    def points(self) -> list[Point]:
        """Return the points of all jobs."""
        return [point for job in self.jobs().values() for point in job]

    def tried(self) -> list[tuple[list[Point], int]]:
        """Return a few of the points of each rock, grid and model, and the joints of all these."""
        alike: dict[tuple, list[Point]] = {}
        for point in self.points():
            settings, model = point.settings, point.settings.conditions
            kind = settings.case.rock, model.effects, model.numerics, settings.grid, *point.options
            alike.setdefault(kind, []).append(point)
        return [(group[:: -(-len(group) // TRIED)], joints_of(group)) for group in alike.values()]

    def kernels(self) -> list[list[str]]:
        """Return the kernels that are compiled before the jobs start."""
        conditions = [point.settings.conditions for point in self.points()]
        return kernels_of(one.model for one in conditions)

    def entries(self) -> list[Entry]:
        """Return the files of the jobs."""
        return [
            Entry(
                f"{self.name}/{job}",
                closed_table,
                (list(points), self.quantities),
                joints=joints_of(points),
                uses=tuple(sorted({point.maker for point in points if point.maker})),
            )
            for job, points in self.jobs().items()
        ]


class Experiment(NamedTuple):
    """Description of an experiment: ``quantities`` (`QUANTITIES`) are read at points of ``jobs``.

    ``check`` refuses a study before any job, where that is slow.
    """

    title: str
    quantities: tuple[str, ...]
    jobs: Callable[[Configuration], Jobs]
    check: Callable[[Configuration], None] = lambda study: None

    def design(self, study: Configuration) -> Design:
        """Return the joints for a checked study."""
        return Design(folder_of(self.jobs), self.quantities, cache(partial(self.jobs, study)))


def experiment_named(name: str) -> Experiment:
    """Return the experiment of a folder."""
    return import_module(f"studies.{name}.study").EXPERIMENT


def settings_of(study: Configuration, case: Case, **surface: Any) -> ClosureSettings:
    """Return the settings that close a case on all realisations, with changed keys of surfaces."""
    settings = block_settings(study, case, range(study.study.realizations))
    return settings._replace(surface=settings.surface._replace(**surface))


def at_wavelengths(
    study: Configuration, wavelengths: Iterable[float]
) -> Iterator[tuple[str, str, float, ClosureSettings]]:
    """Generate rock, name, wavelength and settings of base cases at mismatch wavelengths [m].

    The last of each rock are independent walls, whose wavelength is infinite.
    """
    for rock in study.rocks:
        case = base_case(study, rock)
        for length in (*wavelengths, None):
            name = "independent" if length is None else f"{1e6 * length:.15g}um"
            settings = settings_of(study, case, mismatch_wavelength=length)
            yield rock, name, math.inf if length is None else length, settings


def cached(study: Configuration, kind: str, folder: Path | None = None) -> dict[str, Entry]:
    """Return the files of an ensemble, of pilots (effects_of) or of an experiment by name."""
    if kind in sections():
        entries = experiment_named(kind).design(study).entries()
    elif kind == "effects_of":
        entries = list(Ensemble(study, folder=folder).pilots().values())
    else:
        entries = Ensemble(study, kind, folder).entries()
    return {entry.name: entry for entry in entries}


def close_apart(config: dict, kind: str, block: str, folder: Path, log: Logbook) -> None:
    """Close the joints of one file of the cache, on a node of a cluster."""
    entry = cached(resolved(config), kind, folder)[f"{kind}/{block}"]
    make_missing([entry], folder, 1, log)


def estimate_time(config: dict, name: str, log: Logbook) -> pd.DataFrame:
    """Estimate the time of an experiment from a few of its joints, with standard errors."""
    design, rows = experiment_named(name).design(resolved(config)), []
    compile_all(design.kernels(), log)
    for points, joints in design.tried():
        first = [one._replace(settings=one.settings._replace(realizations=1)) for one in points]
        times = close_points(first, ()).query("cycle == 1").seconds
        rock, grid = points[0].settings.case.rock, points[0].settings.grid
        row = {"rock": rock, "cells": grid.cells_x * grid.cells_y, "joints": joints}
        row |= {"seconds": joints * times.mean(), "error": joints * times.sem()}
        log(f"{rock}, {row['cells']} cells: about {row['seconds']:.0f} s")
        rows.append(row)
    table = pd.DataFrame(rows)
    minutes, error = table.seconds.sum() / 60, math.hypot(*table.error) / 60
    known = f" ± {error:.0f}" if math.isfinite(error) else ""
    minutes_on = f"about {minutes:.2g}{known} minutes on one core"
    log.show(f"{table.joints.sum()} joints will take {minutes_on}")
    return table


def close_experiment(
    config: dict, name: str, folder: Path, workers: int, log: Logbook
) -> xr.Dataset:
    """Close the joints of an experiment that are missing, and join them in a table."""
    design = experiment_named(name).design(resolved(config))
    entries, prepare = design.entries(), partial(compile_all, design.kernels(), log)
    make_missing(entries, folder, workers, log.show, "joints closed", prepare)
    joints = as_table(*(read_netcdf(entry.file(folder)) for entry in entries))
    return as_dataset(joints).assign_attrs(provenance(config))


def steps_of(
    study: Configuration, design: Design, closed: Any, key: Callable[[], str]
) -> dict[str, Step]:
    """Return the steps of an experiment, whose joints have a ``key`` and files ``closed`` apart."""
    name, settings = design.name, {"name": design.name}
    return {
        f"estimate_{name}": Step(
            estimate_time,
            [study.file(f"tables/{name}_estimate.csv")],
            settings=settings,
            depends=lambda: digest(design.tried()),
            priority=100,
        ),
        f"close_{name}": Step(
            close_experiment,
            [study.file(f"{name}.nc")],
            {"closed": closed},
            settings,
            key,
            all_cores=True,
            group=name,
        ),
    } | steps_of_products(name, study)

"""Joints of the experiment of a folder, made tiny, and simulated once for all its tests."""

from itertools import chain

import pandas as pd
import pytest

from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from studies.frame.configuration import Configuration
from studies.frame.experiments import Experiment, Jobs, experiment_named
from studies.frame.joint_tables import as_table
from studies.frame.simulation import close_points
from tests.studied import study_of, tiny


@pytest.fixture(scope="module")
def experiment(request) -> Experiment:
    """The experiment of the folder of a test."""
    return experiment_named(folder_of(request))


@pytest.fixture(scope="module")
def study(request) -> Configuration:
    """The configuration of the experiment, made tiny."""
    return study_of(tiny(folder_of(request)))


@pytest.fixture(scope="module")
def jobs(experiment, study) -> Jobs:
    return experiment.jobs(study)


@pytest.fixture(scope="module")
def joints(experiment, jobs, tmp_path_factory) -> pd.DataFrame:
    """Table of the joints of all jobs, written to files and read again as by the rules."""
    files = {name: tmp_path_factory.mktemp("joints") / "job.nc" for name in jobs}
    for name, file in files.items():
        write_netcdf(close_points(jobs[name], experiment.quantities), file)
    return as_table(read_netcdf(file) for file in files.values())


@pytest.fixture(scope="module")
def tables(experiment, study, joints) -> dict:
    """Tables by name; all figures have been drawn from them."""
    return tables_of(experiment, study, joints)


def folder_of(request) -> str:
    """Return the name of a test's folder, which its experiment and section have too."""
    return request.module.__name__.split(".")[1]


def tables_of(experiment: Experiment, study: Configuration, joints: pd.DataFrame) -> dict:
    """Make all tables of an experiment, draw its figures, and return the tables by name."""
    settings = experiment.settings(study)
    made = {name: make(joints, settings) for name, make in experiment.tables.items()}
    named = {name.removesuffix(".csv"): table for name, table in made.items()}
    shown = {name: table for name, table in named.items() if f"{name}.csv" in made}
    for draw in experiment.figures.values():
        assert draw(shown, settings).axes
    return named


def points_of(experiment: Experiment, study: Configuration) -> list:
    """Return the points of all jobs of an experiment."""
    return list(chain.from_iterable(experiment.jobs(study).values()))

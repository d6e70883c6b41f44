"""Joints of the experiment of a folder, made tiny, closed once for its tests."""

from pathlib import Path

import pandas as pd
import pytest

from studies.frame.configuration import Configuration
from studies.frame.experiments import experiment_named
from studies.frame.plan import inputs_of, settings_of
from studies.frame.points import close_points
from studies.frame.products import products_of
from tests.studied import study_of, tiny


@pytest.fixture(scope="module")
def section(request):
    """Name of the experiment, of its folder and of its section of a configuration."""
    return request.module.__name__.split(".")[1]


@pytest.fixture(scope="module")
def design(section):
    return experiment_named(section).design(study_of(tiny(section)))


@pytest.fixture(scope="module")
def joints(section, design):
    return close_points(design.points(), experiment_named(section).quantities)


@pytest.fixture(scope="module")
def tables(section, joints):
    """Tables by name, of which all figures were drawn."""
    return tables_of(section, study_of(tiny(section)), joints)


def tables_of(folder: str, study: Configuration, joints: pd.DataFrame) -> dict:
    """Make all products of an experiment; its tables by name."""
    known = {f"{folder}.nc": joints}
    products = sorted(products_of(folder).values(), key=lambda one: "joints" not in one.reads)
    for product in products:
        read = {n: known[Path(file).name] for n, file in inputs_of(product, study).items()}
        made = product.make(**read, **settings_of(product, study))
        parts = made if isinstance(made, tuple) else (made,)
        files = [Path(file) for file in product.files(study)]
        if files[0].suffix == ".png":
            assert all(figure.axes for figure in parts)
        else:
            known |= {file.name: part for file, part in zip(files, parts, strict=True)}
    return {name.removesuffix(".csv"): table for name, table in known.items()}

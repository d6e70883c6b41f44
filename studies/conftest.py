"""Joints of an experiment, closed once for its tests: its ``EXPERIMENT`` with the keys ``TINY``."""

from pathlib import Path

import pandas as pd
import pytest

from studies.frame.configuration import Configured
from studies.frame.plan import inputs_of, settings_of
from studies.frame.points import close_points
from studies.frame.products import products_of
from tests.studied import checked_study


@pytest.fixture(scope="module")
def design(request):
    return request.module.EXPERIMENT.design(checked_study(request.module.TINY))


@pytest.fixture(scope="module")
def joints(request, design):
    points = design.points()
    return close_points(points, request.module.EXPERIMENT.quantities)


@pytest.fixture(scope="module")
def tables(request, joints):
    """Tables by name, of which all figures were drawn."""
    folder = request.module.__name__.split(".")[1]
    return tables_of(folder, checked_study(request.module.TINY), joints)


def tables_of(folder: str, configured: Configured, joints: pd.DataFrame) -> dict:
    """Make all products of an experiment; its tables by name."""
    study, known = configured.typed, {f"{folder}.nc": joints}
    products = sorted(products_of(folder).values(), key=lambda one: "joints" not in one.reads)
    for product in products:
        read = {n: known[Path(file).name] for n, file in inputs_of(product, study).items()}
        made = product.make(**read, **settings_of(product, configured))
        parts = made if isinstance(made, tuple) else (made,)
        files = [Path(file) for file in product.files(study)]
        if files[0].suffix == ".png":
            assert all(figure.axes for figure in parts)
        else:
            known |= {file.name: part for file, part in zip(files, parts, strict=True)}
    return {name.removesuffix(".csv"): table for name, table in known.items()}

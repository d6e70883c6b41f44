"""Joints of an experiment, closed once for its tests: its ``EXPERIMENT`` with the keys ``TINY``."""

import pytest

from studies.frame.points import close_points
from tests.studied import checked_study


@pytest.fixture(scope="module")
def design(request):
    return request.module.EXPERIMENT.design(checked_study(request.module.TINY))


@pytest.fixture(scope="module")
def joints(request, design):
    points = design.points()
    return close_points(points, request.module.EXPERIMENT.quantities)


@pytest.fixture(scope="module")
def tables(request, design, joints):
    """Tables by name, of which all figures were drawn."""
    experiment = request.module.EXPERIMENT
    made = experiment.tabulate(joints, design.parameters)
    for name in design.figures:
        assert experiment.draw(name, made, design.parameters).axes
    return made

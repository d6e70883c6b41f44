"""Elastic joints against exact solutions of continuum contact."""

import numpy as np
import pytest
import scipy

from studies.verification.analytic import RADIUS, SOLUTIONS, analytic_table


@pytest.mark.parametrize("name", SOLUTIONS)
def test_the_exact_pressure_carries_the_exact_force(name):
    solution = SOLUTIONS[name]
    carried, _ = scipy.integrate.quad(
        lambda r: 2.0 * np.pi * r * float(solution.pressure(np.array(r))), 0.0, RADIUS, limit=200
    )
    assert carried == pytest.approx(solution.force, rel=2e-3)


def test_elastic_joints_converge_to_the_continuum_with_the_first_power_of_the_spacing():
    table = analytic_table((8, 16, 32))
    assert table.order.dropna().between(0.9, 1.3).all()
    for _, indenter in table.groupby("indenter"):
        assert (np.diff(indenter.pressure_error) < 0.0).all()
        assert abs(indenter.force_error.iloc[-1]) < 0.03

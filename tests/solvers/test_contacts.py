"""Roots of the forces of many contacts at once, from guesses and without."""

import numpy as np
import pytest

from jointclosure.mechanics.contact import asperity_compliance, force_of_overlap
from jointclosure.solvers.contacts import contact_roots, unlimited

SUBSTRATE = 1e-7  # [m/N]


def contacts(curvature=1e4, count=400):
    """Contacts with overlaps over twelve decades, half of which are apart."""
    random = np.random.default_rng(7)
    overlap = 10.0 ** random.uniform(-15.0, -3.0, count) * random.choice([-1.0, 1.0], count)
    compliance = np.full(count, asperity_compliance(curvature, 40e9))
    return unlimited(np.arange(count), overlap, compliance, SUBSTRATE)


def roots_one_by_one(given):
    forces = [
        force_of_overlap(overlap, given.substrate, compliance)[0]
        for overlap, compliance in zip(given.overlap, given.compliance, strict=True)
    ]
    return np.cbrt(forces)


@pytest.mark.parametrize("factor", [0.0, 1e-3, 0.5, 0.9, 1.0, 1.1, 1.9, 10.0, 1e3])
@pytest.mark.parametrize("curvature", [0.0, 1.0, 1e4])
def test_roots_do_not_depend_on_the_guess(factor, curvature):
    given = contacts(curvature)
    expected = roots_one_by_one(given)
    found = contact_roots(given, given.overlap, factor * expected)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_contacts_that_are_apart_have_no_force_whatever_the_guess():
    given = contacts()
    found = contact_roots(given, given.overlap, np.ones(given.overlap.size))
    np.testing.assert_array_equal(found > 0.0, given.overlap > 0.0)

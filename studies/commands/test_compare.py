"""Elasticities of two studies, and errors of their differences, in a world whose truth is known."""

import numpy as np
import pytest
import xarray as xr

from studies.commands.compare import elasticity_changes
from tests.studied import study_of
from tests.world import ELASTICITIES, world

COMMON = {
    "study": {"rocks": ["dolerite"], "draws": "common", "pool": None, "realizations": 12},
    "statistics": {"control_variates": None},
}
INDEPENDENT = {"study": COMMON["study"] | {"draws": "independent"}}
OTHER = {cycle: powers | {"jrc": powers["jrc"] + 0.3} for cycle, powers in ELASTICITIES.items()}
"""Elasticities of another world: that with respect to JRC is larger by 0.3."""


def changes(first: xr.Dataset, second: xr.Dataset):
    table = elasticity_changes(first, second)
    return table[table.of == "gross closure"].set_index(["parameter", "cycle"])


@pytest.mark.parametrize("draws", [COMMON, INDEPENDENT])
def test_scatter_that_both_studies_have_is_not_in_the_error_of_the_difference(draws):
    configuration = study_of(COMMON, draws)
    first, second = world(configuration), world(configuration, OTHER)
    table = changes(first, second)
    assert table.same_surfaces.all()
    assert table.difference_value["jrc", 1] == pytest.approx(0.3, abs=1e-6)
    assert table.difference_value["youngs_modulus", 1] == pytest.approx(0.0, abs=1e-6)
    apart = second.assign_coords(seed=second.seed.copy(data=second.seed.values[:, ::-1]))
    alone = changes(first, apart)
    assert not alone.same_surfaces.any()
    errors = [one.difference_standard_error["youngs_modulus", 1] for one in (table, alone)]
    assert errors[0] < 1e-6 < 1e-3 < errors[1]


def test_the_error_of_a_difference_is_its_scatter_on_the_same_surfaces():
    """Two worlds on the same surfaces, whose irregular parts differ from case to case."""
    found = []
    for seed in range(60):
        configuration = study_of(COMMON, {"study": {"root_seed": seed}})
        first = world(configuration, irregular=0.0)
        noise = np.random.default_rng(seed).normal(size=first.max_closure.shape)
        second = first.assign(max_closure=first.max_closure * np.exp(0.02 * noise))
        found.append(changes(first, second))
    at = ("compressive_strength", 2)
    values = [one.difference_value[at] for one in found]
    errors = [one.difference_standard_error[at] for one in found]
    assert np.std(values) == pytest.approx(np.sqrt(np.mean(np.square(errors))), rel=0.3)


def test_a_joint_that_failed_in_one_study_is_left_out_of_both():
    configuration = study_of(COMMON)
    first, second = world(configuration), world(configuration)
    second.status[:, 3] = 16
    second["max_closure"][:, 3] = np.nan
    table = changes(first, second)
    assert (table.difference_value == 0.0).all()
    assert (table.difference_standard_error == 0.0).all()


def test_equal_studies_have_elasticities_without_a_difference():
    study = world(study_of(COMMON))
    table = elasticity_changes(study, study)
    assert set(table.difference) == {"0"}
    assert (table["first"] == table["second"]).all()
    assert table["first"].str.contains(" ± ").all()

"""Comparison of two studies: closures, elasticities and errors of their differences."""

import numpy as np
import pytest
import xarray as xr

from jointclosure.storage.netcdf import write_netcdf
from studies import __main__ as cli
from studies.commands import compare
from studies.commands.compare import elasticity_changes
from studies.commands.differences import differences
from tests.studied import study_of
from tests.world import ELASTICITIES, world

TINY = {
    "study": {"rocks": ["slate"], "realizations": 3},
    "rocks": {"slate": {"max_normal_stress_MPa": 2, "levels": {"jrc": None}}},
    "grid": {"cells_x": 14, "cells_y": 12},
    "output": {"stress_points": 5},
}


def study(factor=1.0, **changes):
    """Return a study of one rock with made-up joints, whose closures are multiplied by a factor."""
    made = world(study_of(TINY, {"study": {"realizations": 6} | changes}))
    made = made.assign({name: factor * made[name] for name in compare.TARGETS})
    return made.assign_attrs(source_digest="abc", provenance_commit=str(changes))


def test_surfaces_with_the_same_seeds_are_compared_one_by_one():
    changes = compare.closure_changes(study(), study(1.1))
    assert changes.same_surfaces.all()
    np.testing.assert_allclose(changes.change_percent, 10.0)
    # a constant factor: the differences scatter a tenth of what the closures do
    assert changes.standard_error_percent.max() < 1.0
    assert "the same surfaces" in compare.surfaces_sentence(changes)
    for other in ({"root_seed": 2}, {"realizations": 5}):
        others = compare.closure_changes(study(), study(1.1, **other))
        assert not others.same_surfaces.any()
        assert others.standard_error_percent.min() > 1.0
        assert "The surfaces differ in 7 of 7 cases" in compare.surfaces_sentence(others)
    assert len(compare.by_rock(changes)) == 2 * len(compare.TARGETS)


def test_all_that_differs_is_named():
    assert differences(study(), study()) == []
    timed = study()
    timed["timing_simulation"] = 2.0 * timed.timing_simulation
    timed.attrs["provenance_commit"] = "other"
    assert differences(study(), timed) == []
    moved = study()
    moved["max_closure"] = moved.max_closure.copy()
    moved.max_closure[0, 1, 0] += 1e-15
    moved.attrs["source_digest"] = "xyz"
    found = differences(study(), moved.drop_vars("residual_closure"))
    assert found[0] == "attribute source_digest differs"
    assert found[1].startswith("variable max_closure differs in 1 of 84 values, by at most")
    assert found[2] == "variable residual_closure: only in the first"


def test_compare_exact_fails_where_anything_differs(tmp_path, capsys):
    for name, factor in (("one", 1.0), ("two", 1.1)):
        (tmp_path / name).mkdir()
        write_netcdf(study(factor), tmp_path / name / "study.nc")
    command = ["compare", "--exact", str(tmp_path / "one")]
    assert cli.main([*command, str(tmp_path / "two")]) == 1
    assert "variable max_closure differs in 84 of 84" in capsys.readouterr().out
    assert cli.main([*command, command[-1]]) == 0
    assert capsys.readouterr().out == "identical except for provenance and timing\n"


def test_failures_are_left_out_on_both_sides():
    broken = study(1.1)
    broken["status"][0, 2] = 16
    changes = compare.closure_changes(study(), broken)
    assert changes[changes.case == "slate-base"].samples.unique() == 5
    np.testing.assert_allclose(changes.change_percent, 10.0)


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

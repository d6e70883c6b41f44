"""A JRC that is known to a range only, in a world whose closures are powers of the JRC."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.config.files import PAPER_TABLE_3
from jointclosure.ensemble.cases import pool_of
from jointclosure.inputs import InputError
from jointclosure.sensitivity.claims import Evidence
from jointclosure.sensitivity.jrc_range import (
    check_jrc_varies,
    jrc_range_tables,
    with_jrc_range,
)
from jointclosure.statistics.drawn_studies import Design
from jointclosure.statistics.randomness import generator
from jointclosure.storage.netcdf import reading_netcdf, write_netcdf
from jointclosure.storage.text import read_csv
from tests.sensitivity.world import ELASTICITIES, world
from tests.studied import study_of

MANY = {"study": {"rocks": ["dolerite"], "pool": 2000}}


@pytest.fixture(scope="module")
def pool():
    return world(pool_of(study_of(MANY)), irregular=0.0)


@pytest.mark.parametrize("half_width", [1.0, 2.0])
def test_the_scatter_grows_by_that_of_the_drawn_jrc_in_every_case(pool, half_width):
    """Closures go as JRC to a power: the log's gains a variance of (power w/J)^2/3, w small."""
    drawn = with_jrc_range(pool, half_width, generator(1))
    assert {"base", "jrc", "youngs_modulus"} <= set(pool.parameter.values)
    for case, jrc in enumerate(pool.jrc.values):
        for cycle in (1, 2):
            before, after = (
                each.max_closure.isel(case=case).sel(cycle=cycle).values for each in (pool, drawn)
            )
            added = (ELASTICITIES[cycle]["jrc"] * half_width / jrc) ** 2 / 3.0
            assert np.log(after / before).var() == pytest.approx(added, rel=0.2)
            assert after.mean() == pytest.approx(before.mean(), rel=0.03)


def test_a_pool_in_a_file_is_changed_too(pool, tmp_path):
    write_netcdf(pool.isel(realization=slice(20)), tmp_path / "pool.nc")
    with reading_netcdf(tmp_path / "pool.nc") as few:
        drawn = with_jrc_range(few, 2.0, generator(1))
        assert (drawn.max_closure != few.max_closure).all()
        assert (drawn.max_closure_net != few.max_closure_net).all()


def test_joints_of_a_known_jrc_and_of_failed_simulations_stay_as_they_are(pool):
    few = pool.isel(realization=slice(5)).copy(deep=True)
    few.max_closure[:, 3] = np.nan
    drawn = with_jrc_range(few, 1e-12, generator(1))
    np.testing.assert_allclose(drawn.max_closure, few.max_closure, rtol=1e-10)
    assert np.isnan(drawn.max_closure[:, 3]).all()


def test_without_common_surfaces_it_is_refused():
    with pytest.raises(jc.InputError, match="its JRC must be varied on common surfaces"):
        with_jrc_range(world(study_of({"study": {"rocks": ["slate"]}})), 1.0, generator(1))


def test_a_wide_range_widens_the_interval_of_jrc_on_the_first_cycle(pool):
    few = pool.isel(realization=slice(40))
    evidence = Evidence(few, few, Design(), 200, 1, resampled_pools=3)
    entries, found = jrc_range_tables(evidence, [2.0], read_csv(PAPER_TABLE_3))
    rows = entries.set_index(["parameter", "cycle", "half_width"]).value
    assert rows["base", 1, 2.0] > rows["base", 1, 0.0]
    assert rows["jrc", 1, 2.0] > rows["jrc", 1, 0.0]
    assert entries[entries.parameter == "base"].standard_error.notna().all()
    assert set(found.half_width) == {0.0, 2.0}
    known = found.dropna()
    assert (known.found_low <= known.found_share).all()
    assert (known.found_share <= known.found_high).all()
    assert (known.found_high > known.found_low).all()


@pytest.mark.parametrize(
    ("changes", "printed"),
    [
        ({"rocks": {"slate": {"levels": {"jrc": None}}}}, "rocks.slate.levels.jrc"),
        ({"study": {"pool": None}}, "study.pool"),
    ],
)
def test_a_study_that_does_not_tell_of_a_range_of_jrc_is_refused_before_it_is_closed(
    changes, printed
):
    check_jrc_varies(study_of({"study": {"pool": 12}}))
    check_jrc_varies(study_of({"study": {"pool": None, "draws": "common"}}))
    with pytest.raises(InputError, match=printed):
        check_jrc_varies(study_of({"study": {"pool": 12}}, changes))

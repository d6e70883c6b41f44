"""A JRC that is known to a range only, in a world whose closures are powers of the JRC."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.config.files import PAPER_CLAIMS, PAPER_TABLE_3
from jointclosure.ensemble.cases import pool_of
from jointclosure.randomness import generator
from jointclosure.statistics.drawn_studies import Design
from jointclosure.storage.text import read_csv
from jointclosure.studies.sensitivity.claims import Evidence
from jointclosure.studies.sensitivity.jrc_range import jrc_range_tables, with_jrc_range
from tests.studied import study_of
from tests.studies.sensitivity_world import ELASTICITIES, world

MANY = {"study": {"rocks": ["dolerite"], "pool": 2000}}


@pytest.fixture(scope="module")
def pool():
    return world(pool_of(study_of(MANY)), irregular=0.0)


@pytest.mark.parametrize("half_width", [1.0, 2.0])
def test_the_scatter_grows_by_that_of_the_drawn_jrc(pool, half_width):
    """Closures go as JRC to a power: the log's gains a variance of (power w/J)^2/3, w small."""
    drawn = with_jrc_range(pool, half_width, generator(1))
    base = (pool.parameter == "base").values
    for cycle in (1, 2):
        before, after = (
            np.log(each.max_closure[base].sel(cycle=cycle).values[0]) for each in (pool, drawn)
        )
        added = (ELASTICITIES[cycle]["jrc"] * half_width / 8.0) ** 2 / 3.0
        assert (after - before).var() == pytest.approx(added, rel=0.1)
        means = [float(each.max_closure[base].sel(cycle=cycle).mean()) for each in (pool, drawn)]
        assert means[1] == pytest.approx(means[0], rel=0.02)


def test_joints_of_a_known_jrc_and_of_failed_simulations_stay_as_they_are(pool):
    few = pool.isel(realization=slice(5)).copy(deep=True)
    few.max_closure[:, 3] = np.nan
    drawn = with_jrc_range(few, 1e-12, generator(1))
    np.testing.assert_allclose(drawn.max_closure, few.max_closure, rtol=1e-10)
    assert np.isnan(drawn.max_closure[:, 3]).all()


def test_without_common_surfaces_it_is_refused():
    with pytest.raises(jc.InputError, match="its JRC is not varied on common surfaces"):
        with_jrc_range(world(study_of({"study": {"rocks": ["slate"]}})), 1.0, generator(1))


def test_a_wide_range_widens_the_interval_of_jrc_on_the_first_cycle(pool):
    few = pool.isel(realization=slice(40))
    evidence = Evidence(few, few, Design(), 200, 1)
    entries, found = jrc_range_tables(
        evidence, [2.0], read_csv(PAPER_CLAIMS), read_csv(PAPER_TABLE_3)
    )
    rows = entries.set_index(["parameter", "cycle", "half_width"]).value
    assert rows["base", 1, 2.0] > rows["base", 1, 0.0]
    assert rows["jrc", 1, 2.0] > rows["jrc", 1, 0.0]
    assert entries[entries.parameter == "base"].standard_error.notna().all()
    assert set(found.half_width) == {0.0, 2.0}
    assert found.found_share.dropna().between(0.0, 1.0).all()

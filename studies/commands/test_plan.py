"""`python -m studies plan`: from the surfaces that belong to the study."""

import json

import pytest

from jointclosure.storage.netcdf import write_netcdf
from studies.__main__ import main
from studies.frame.cases import pool_of
from tests.studied import study_of
from tests.world import world

SMALL = {"study": {"name": "small", "rocks": ["slate"], "realizations": 4, "pool": 6}}


@pytest.fixture
def results(tmp_path):
    """A folder of results: with its own pool, or with that of a configuration before."""

    def made(pool: int | None):
        configuration = study_of(SMALL)
        for name, ensemble in (("study", configuration), ("pool", pool_of(configuration))):
            dataset = world(ensemble)
            dataset["bulk_indentation"] = 0.1 * dataset.closure
            dataset.attrs["configuration"] = json.dumps({"study": {"pool": pool}})
            write_netcdf(dataset, tmp_path / f"{name}.nc")
        return tmp_path

    return made


def test_a_study_with_a_pool_is_planned_from_it(results, capsys):
    folder = results(6)
    assert main(["plan", str(folder), "--standard-error", "0.01"]) == 0
    assert f"from {folder / 'pool.nc'}\n" in capsys.readouterr().out


def test_a_pool_that_an_earlier_configuration_left_is_not_planned_from(results, capsys):
    folder = results(None)
    assert main(["plan", str(folder), "--standard-error", "0.01"]) == 0
    assert f"from {folder / 'study.nc'}\n" in capsys.readouterr().out

"""`python -m studies plan`: from the surfaces that belong to the study."""

import json

import pytest

from jointclosure.storage.netcdf import write_netcdf
from studies.__main__ import main
from studies.frame.cases import pool_of
from tests.studied import study_of
from tests.world import world

SMALL = {"study": {"name": "small", "rocks": ["slate"], "realizations": 4, "pool": 6}}


@pytest.mark.parametrize(("pool", "planned"), [(6, "pool.nc"), (None, "study.nc")])
def test_a_study_is_planned_from_its_pool_and_not_from_one_left_by_another_configuration(
    pool, planned, tmp_path, capsys
):
    configuration = study_of(SMALL)
    for name, ensemble in (("study", configuration), ("pool", pool_of(configuration))):
        dataset = world(ensemble)
        dataset["bulk_indentation"] = 0.1 * dataset.closure
        dataset.attrs["configuration"] = json.dumps({"study": {"pool": pool}})
        write_netcdf(dataset, tmp_path / f"{name}.nc")
    assert main(["plan", str(tmp_path), "--standard-error", "0.01"]) == 0
    assert f"from {tmp_path / planned}\n" in capsys.readouterr().out

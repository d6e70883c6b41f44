"""The memory that puts a study together does not grow with its realisations."""

import resource
from pathlib import Path

import numpy as np
import pytest

from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from studies.frame.closing import Ensemble, close_block
from studies.frame.configuration import Configuration, resolved
from tests.processes import python
from tests.studied import DEFAULT, study_of
from tests.workflow.test_settings import SMALL

PER_JOB = 2500

pytestmark = pytest.mark.slow


def keys_of_study(realizations: int) -> dict:
    """One case of joints that do not break, with 50 points of stress."""
    study = {"realizations": realizations, "realizations_per_job": PER_JOB, "draws": "common"}
    changes = {
        "output": {"stress_points": 50},
        "statistics": {"control_variates": None},
        "rocks": {"slate": {"levels": dict.fromkeys(DEFAULT["rocks"]["slate"]["levels"])}},
        "study": study | {"pool": None},
    }
    return study_of(SMALL, changes).stated


def write_blocks(configuration: Configuration, folder: Path) -> None:
    """Files of every block: one joint's numbers, and in two variables the realisation's own."""
    ensemble = Ensemble(configuration, folder=folder)
    one = close_block(ensemble.settings(*ensemble.cases, range(1)))
    (folder / "cases").mkdir(parents=True)
    for block, entry in zip(ensemble.blocks, ensemble.entries(), strict=True):
        many = one.isel(realization=np.zeros(len(block), dtype=int))
        many = many.assign_coords(realization=np.array(block))
        random = np.random.default_rng(block.start).random(many.closure.shape)
        many = many.assign(closure=(many.closure.dims, random, many.closure.attrs))
        many["breakage_steps"] = ("realization", np.array(block), one.breakage_steps.attrs)
        write_netcdf(many.assign_attrs(scene="elastic"), entry.file(folder))


def joined(realizations: int, folder: Path) -> int:
    """Put the study together as its job does; the peak memory [kB] of this process."""
    ensemble = Ensemble(resolved(keys_of_study(realizations)), folder=folder)
    ensemble.join({}, lambda line: None, folder / "study.nc")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def memory(realizations: int, folder: Path) -> int:
    write_blocks(resolved(keys_of_study(realizations)), folder)
    command = (
        "import sys, pathlib; from tests.workflow.test_many_realizations import joined; "
        "print(joined(int(sys.argv[1]), pathlib.Path(sys.argv[2])))"
    )
    return int(python("-c", command, realizations, folder).stdout.splitlines()[-1])


def test_ten_times_the_realisations_take_no_more_memory(tmp_path):
    few, many = memory(2_500, tmp_path / "few"), memory(25_000, tmp_path / "many")
    study = read_netcdf(tmp_path / "many/study.nc")
    # but for what netCDF keeps of each variable, which is bounded
    assert 1024 * (many - few) < 0.2 * study.nbytes, f"{few} and {many} kB"
    steps = study.breakage_steps.values
    np.testing.assert_array_equal(steps, np.arange(25_000)[np.newaxis])
    last = read_netcdf(tmp_path / "many/cases/slate-base.22500.nc")
    there = study.closure.isel(case=0, realization=slice(22_500, None))
    np.testing.assert_array_equal(there.values, last.closure.values)

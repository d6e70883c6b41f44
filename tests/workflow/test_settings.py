"""A change of what a result depends on is noticed; a split of the work changes nothing."""

import itertools
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from jointclosure.engine.cache import digest
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from studies.commands.compare import differences
from studies.frame import closing
from studies.frame.cases import blocks_of
from studies.frame.closing import Ensemble, close_block
from studies.frame.configuration import Configuration
from studies.frame.settings import walls_of
from studies.frame.tables import join_cases
from studies.paper.closures import max_closure_table
from tests.studied import study_of

ELASTIC = {"substrate": True, "interaction": True, "breakage": False, "gouge": False}


SMALL = {
    "grid": {"cells_x": 12, "cells_y": 12},
    "effects": ELASTIC,
    "numerics": {"curve_points": 5},
    "output": {"stress_points": 4},
    "study": {"rocks": ["slate"], "realizations": 7},
    "rocks": {"slate": {"levels": dict.fromkeys(("youngs_modulus_GPa", "poisson_ratio"))}},
}
"""The paper's study of joints of 12 x 12 cells that do not break."""


@pytest.fixture
def configuration():
    return study_of(SMALL)


@given(st.integers(2, 500), st.integers(1, 600) | st.none())
def test_blocks_have_every_realisation_once(realizations, per_job):
    study = study_of().study._replace(realizations=realizations, realizations_per_job=per_job)
    blocks = blocks_of(study)
    assert list(itertools.chain(*blocks)) == list(range(realizations))
    assert all(len(block) <= (per_job or realizations) for block in blocks)


CHANGES = [
    {"study": {"root_seed": 1}}, {"surface": {"hurst": 0.7}}, {"grid": {"spacing_mm": 0.5}},
    {"effects": {"soft_peaks": False}}, {"numerics": {"force_tolerance": 1e-9}},
    {"output": {"stress_points": 5}}, {"rocks": {"slate": {"youngs_modulus_GPa": 66.5}}},
]  # fmt: skip


def test_all_that_a_result_depends_on_is_in_its_settings(configuration):
    low = "slate-jrc-low", range(4)
    others = [("slate-jrc-high", range(4)), ("slate-jrc-low", range(4, 7))]
    settings = [Ensemble(configuration).settings(*block) for block in (low, *others)]
    settings += [Ensemble(study_of(SMALL, edit)).settings(*low) for edit in CHANGES]
    assert len({digest(each) for each in settings}) == len(settings)
    other = {"rocks": {"slate": {"levels": {"jrc": [5, 9.5]}, "title": "Another"}}}
    for edit in ({}, other):
        assert digest(settings[0]) == digest(Ensemble(study_of(SMALL, edit)).settings(*low))


def whole_study(configuration: Configuration, folder: Path) -> xr.Dataset:
    """Study of all cases, block by block through files, joined as by its job."""
    ensemble = Ensemble(configuration, folder=folder)
    for entry in ensemble.entries():
        entry.file(folder).parent.mkdir(parents=True, exist_ok=True)
        write_netcdf(entry.make(*entry.settings), entry.file(folder))
    ensemble.join({}, lambda line: None, folder / "study.nc")
    return read_netcdf(folder / "study.nc")


def test_a_split_over_jobs_changes_no_bit_and_few_rows_are_in_memory(
    configuration, tmp_path, monkeypatch
):
    sizes = []

    def watched(frame, path, regions, *how):
        parts = list(regions)
        sizes.extend(part.sizes["realization"] for _, part in parts)
        write_netcdf(frame, path, parts, *how)

    monkeypatch.setattr(closing, "write_netcdf", watched)
    monkeypatch.setattr(closing, "ROWS", 4)
    whole = whole_study(configuration, tmp_path / "whole")
    assert set(sizes) == {4, 3}
    assert whole.realization.values.tolist() == list(range(7))
    assert np.isfinite(whole.max_closure.values).all()
    parts = study_of(SMALL, {"study": {"realizations_per_job": 3}})
    assert differences(whole, whole_study(parts, tmp_path / "split")) == []
    ensemble = Ensemble(configuration, folder=tmp_path / "whole")
    files = [read_netcdf(entry.file(ensemble.folder)) for entry in ensemble.entries()]
    joined = join_cases(list(ensemble.cases.values()), files).drop_attrs(deep=False)
    assert differences(whole.drop_vars("scene"), joined) == []


def test_a_realisation_that_fails_is_told_of_and_left_out():
    """Flat walls without substrate: a contact that nothing can carry."""
    configuration = study_of(SMALL, {"effects": {"substrate": False, "interaction": False}})
    ensemble = Ensemble(configuration)
    settings = ensemble.settings("slate-base", range(4))
    pairs = list(walls_of(settings))
    for wall in pairs[2]:
        wall[:] = 0.0
    lines = []
    again = "python -m studies repeat r slate-base"
    closed = close_block(settings, pairs, report=lines.append, again=again)
    assert closed.status.values.tolist() == [0, 0, 64, 0]
    for name, values in closed.isel(realization=2).data_vars.items():
        counted = name == "timing_simulation" or values.dtype.kind == "i"
        assert np.isfinite(values).all() if counted else np.isnan(values).all()
    assert "failed; to repeat it: python -m studies repeat r slate-base 2" in lines[2]
    assert not any("failed" in line for line in lines[:2] + lines[3:])
    study = join_cases([ensemble.cases["slate-base"]], [closed])
    table = max_closure_table(study)
    good = closed.max_closure.values[[0, 1, 3]]
    assert table.samples.tolist() == [3, 3]
    np.testing.assert_allclose(table.max_closure_mean_mm, 1e3 * good.mean(axis=0), rtol=1e-14)

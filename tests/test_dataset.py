import os

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.dataset import atomically, read_csv, read_netcdf, write_csv, write_netcdf


def test_a_write_that_fails_leaves_what_was_there_and_no_litter(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("old")

    def fail(temporary):
        temporary.write_text("half")
        raise RuntimeError("disk full")

    with pytest.raises(RuntimeError, match="disk full"):
        atomically(path, fail)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["table.csv"]


def test_datasets_and_tables_come_back_as_they_were(tmp_path):
    dataset = xr.Dataset(
        {"a": (("case", "x"), np.random.default_rng(1).random((2, 3)))},
        coords={"case": np.array(["one", "two"], dtype=object)},
        attrs={"source_digest": "abc"},
    )
    write_netcdf(dataset, tmp_path / "a.nc")
    xr.testing.assert_identical(read_netcdf(tmp_path / "a.nc"), dataset)
    frame = pd.DataFrame({"x": [0.1 + 0.2, np.nan], "name": ["a", "b"]})
    write_csv(frame, tmp_path / "a.csv")
    pd.testing.assert_frame_equal(read_csv(tmp_path / "a.csv"), frame)

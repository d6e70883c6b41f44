import os

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.cli.options import check_folder
from jointclosure.inputs import InputError
from jointclosure.storage import folders
from jointclosure.storage.files import atomically
from jointclosure.storage.folders import RECORD, add_file, replace_files, written_files
from jointclosure.storage.netcdf import (
    read_netcdf,
    reading_netcdf,
    write_netcdf,
    write_netcdf_blocks,
)
from jointclosure.storage.text import read_benchmarks, read_csv, write_csv


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


def test_blocks_in_a_file_are_one_dataset(tmp_path):
    rng = np.random.default_rng(2)
    whole = xr.Dataset(
        {
            "a": (("n", "x"), rng.random((5, 3)), {"units": "m"}),
            "status": ("n", np.arange(5, dtype=np.int16)),
            "same": ("x", np.array([1.0, np.nan, 3.0])),
        },
        coords={"n": np.arange(5), "seed": ("n", np.array(list("abcde"), dtype=object))},
        attrs={"spacing_m": 0.25},
    )
    whole["a"][3] = np.nan
    blocks = (whole.isel(n=slice(i, i + 2)) for i in range(0, 5, 2))
    write_netcdf_blocks(blocks, "n", tmp_path / "a.nc")
    found = read_netcdf(tmp_path / "a.nc")
    xr.testing.assert_identical(found, whole)
    with reading_netcdf(tmp_path / "a.nc") as lazy:
        assert lazy.isel(n=3).status.item() == 3
    write_netcdf(found, tmp_path / "b.nc")
    xr.testing.assert_identical(read_netcdf(tmp_path / "b.nc"), whole)


def test_benchmarks_are_named_by_their_rule(tmp_path):
    (tmp_path / "close_surfaces").mkdir()
    head = "s\th:m:s\tmax_rss\tcpu_time\n"
    (tmp_path / "close_surfaces/slate-base.tsv").write_text(f"{head}2.5\t0:00:02\t245.5\t2.0\n")
    (tmp_path / "aggregate.tsv").write_text(f"{head}0.01\t0:00:00\t-\t-\n")
    found = read_benchmarks(tmp_path)
    assert found[["rule", "job", "s"]].to_numpy().tolist() == [
        ["aggregate", "aggregate", 0.01],
        ["close_surfaces", "slate-base", 2.5],
    ]
    assert np.isnan(found.max_rss.iloc[0])
    assert found.max_rss.iloc[1] == 245.5
    assert list(read_benchmarks(tmp_path / "absent").columns) == list(found.columns)


def some_files(*names):
    """What writes files that hold their names and how many they are."""

    def write(folder):
        for name in names:
            (folder / name).write_text(f"{name} of {len(names)}")

    return write


def test_files_of_an_earlier_run_go_and_all_others_stay(tmp_path):
    folder = tmp_path / "joint"
    assert replace_files(folder, "close", some_files("b", "a", "export")) == ["a", "b", "export"]
    replace_files(folder, "fit", some_files("fit"))
    add_file(folder, "close", "page")
    (folder / "page").touch()
    (folder / "notes").write_text("mine")
    assert replace_files(folder, "close", some_files("a", "b")) == ["a", "b"]
    assert sorted(os.listdir(folder)) == ["a", "b", "fit", "notes", RECORD]
    assert (folder / "a").read_text() == "a of 2"
    assert written_files(folder, "close") == ["a", "b"]


def test_a_run_that_fails_while_writing_leaves_the_files_of_the_earlier_one(tmp_path):
    replace_files(tmp_path, "close", some_files("a", "export"))

    def fail(folder):
        (folder / "a").write_text("half")
        raise RuntimeError("disk full")

    with pytest.raises(RuntimeError, match="disk full"):
        replace_files(tmp_path, "close", fail)
    assert sorted(os.listdir(tmp_path)) == ["a", "export", RECORD]
    assert (tmp_path / "a").read_text() == "a of 2"


def test_a_run_that_is_killed_while_replacing_leaves_nothing_that_the_next_one_keeps(
    tmp_path, monkeypatch
):
    replace_files(tmp_path, "close", some_files("a", "old"))

    def killed(folder, command, names):
        if "old" not in names:  # after all files are in place
            raise KeyboardInterrupt
        record(folder, command, names)

    record = folders._record
    with monkeypatch.context() as patched:
        patched.setattr(folders, "_record", killed)
        with pytest.raises(KeyboardInterrupt):
            replace_files(tmp_path, "close", some_files("a", "new"))
    assert (tmp_path / "new").exists()
    replace_files(tmp_path, "close", some_files("a"))
    assert sorted(os.listdir(tmp_path)) == ["a", RECORD]


@pytest.mark.parametrize("text", ['{"close": ["../outside"]}', "[1]", '{"close": [3]}', "no"])
def test_a_record_that_is_none_is_refused_and_nothing_outside_is_removed(tmp_path, text):
    (tmp_path / "outside").write_text("mine")
    folder = tmp_path / "joint"
    folder.mkdir()
    (folder / RECORD).write_text(text)
    with pytest.raises(InputError, match=f"{RECORD}: must be a JSON object"):
        replace_files(folder, "close", some_files("a"))
    assert (tmp_path / "outside").exists()
    with pytest.raises(InputError, match=f"{RECORD}: must be a JSON object"):
        check_folder(folder)  # before a joint is closed

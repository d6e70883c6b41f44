"""What is written to files is there as a whole, or is said to be missing or damaged."""

import gc
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.cli.options import writable
from jointclosure.inputs import InputError
from jointclosure.plotting.style import subplots
from jointclosure.storage import files, folders
from jointclosure.storage.logs import logging_to, reason_of_failure
from jointclosure.storage.netcdf import read_netcdf, reading_netcdf, write_netcdf
from tests.processes import python


def some_dataset(rows: int = 20) -> xr.Dataset:
    random = np.random.default_rng(3)
    return xr.Dataset(
        {
            "closure": (("realization", "x"), random.random((rows, 40)), {"units": "m"}),
            "status": ("realization", np.arange(rows, dtype=np.int16)),
            "same": ("x", np.where(np.arange(40) == 2, np.nan, 1.0)),
        },
        coords={"seed": ("realization", np.array([f"{i:032x}" for i in range(rows)], object))},
        attrs={"settings": "{}"},
    )


def write_regions(whole: xr.Dataset, path: Path, rows: int = 20) -> None:
    """Write a dataset in regions of some rows."""
    size = whole.sizes["realization"]
    ends = [(start, min(start + rows, size)) for start in range(0, size, rows)]
    places = [{"realization": slice(*end)} for end in ends]
    regions = ((place, whole.isel(place)) for place in places)
    first = whole.isel(realization=slice(0, 1))
    write_netcdf(first, path, regions, "realization", {"realization": rows})


def test_files_are_usable_where_a_file_system_refuses_locks(tmp_path):
    """A file that is locked refuses another lock, as such a file system refuses every one."""
    pytest.importorskip("fcntl")
    code = f"""
import fcntl, sys
from pathlib import Path
import numpy as np, xarray as xr
from jointclosure.storage import files, netcdf
from jointclosure.walls.scans import grids
path = Path({str(tmp_path)!r}) / "a.nc"

def locked(write):
    def touch_lock_and_write(temporary):
        with open(temporary, "r+b") as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            write(temporary)
    return touch_lock_and_write

atomically = files.atomically
netcdf.atomically = lambda path, write: atomically(path, locked(write))
netcdf.write_netcdf(xr.Dataset({{"a": ("x", np.arange(3.0))}}), path)
with open(path, "rb") as held:
    fcntl.flock(held, fcntl.LOCK_EX)
    assert netcdf.read_netcdf(path).a.sum() == 3.0
"""
    python("-c", code)


@pytest.fixture
def stored(tmp_path):
    path = tmp_path / "case.nc"
    write_netcdf(some_dataset(), path)
    return path


@pytest.fixture
def by_regions(tmp_path):
    path = tmp_path / "regions.nc"
    write_regions(some_dataset(), path, 7)
    return path


@pytest.mark.parametrize("written", ["stored", "by_regions"])
def test_datasets_come_back_as_they_were(written, request):
    path, whole = request.getfixturevalue(written), some_dataset()
    xr.testing.assert_identical(read_netcdf(path), whole)
    with xr.open_dataset(path, engine="netcdf4") as dataset:  # as other programs read it
        assert dataset.load().identical(whole)


def test_a_dataset_is_read_in_part(stored):
    with reading_netcdf(stored) as lazy:
        assert lazy.isel(realization=3).status.item() == 3


def test_tables_come_back_as_they_were(tmp_path):
    frame = pd.DataFrame({"x": [0.1 + 0.2, np.nan], "name": ["a", "b"]})
    files.write_csv(frame, tmp_path / "a.csv")
    pd.testing.assert_frame_equal(files.read_csv(tmp_path / "a.csv"), frame)


def assert_noticed(stored, damaged):
    """Each of the damaged contents of a file is noticed, and the whole one is read after them."""
    whole = stored.read_bytes()
    for content in damaged:
        stored.write_bytes(content)
        with pytest.raises(files.DamagedFileError, match=r"case.nc: .* delete it and start again"):
            read_netcdf(stored)
    stored.write_bytes(whole)
    assert read_netcdf(stored).identical(some_dataset())


def test_every_flipped_bit_is_noticed(stored):
    whole = stored.read_bytes()
    size = len(whole)
    places = np.append(np.random.default_rng(5).integers(0, size, 300), np.arange(size - 110, size))
    assert_noticed(
        stored,
        [
            whole[:place] + bytes([whole[place] ^ 1 << place % 8]) + whole[place + 1 :]
            for place in places.tolist()
        ],
    )


def test_every_changed_length_is_noticed(stored):
    whole = stored.read_bytes()
    size = len(whole)
    lengths = (0, 1, 7, 96, size // 2, size - 96, size - 1)
    assert_noticed(stored, [*(whole[:length] for length in lengths), whole + b"\0"])


@pytest.fixture(scope="module")
def full_disk(tmp_path_factory):
    """A folder of files that were written up to limits, the whole size, and what was printed."""
    folder = tmp_path_factory.mktemp("small")
    whole = tmp_path_factory.mktemp("whole") / "whole.nc"
    write_regions(some_dataset(200), whole)
    size = os.path.getsize(whole)
    script = (
        "import sys, pathlib, resource\n"
        "from tests.storage.test_storage import some_dataset, write_regions\n"
        "for limit in map(int, sys.argv[2:]):\n"
        "    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))\n"
        "    try:\n"
        "        write_regions(some_dataset(200), pathlib.Path(sys.argv[1]) / f'{limit}.nc')\n"
        "        print(limit, 'written')\n"
        "    except OSError as error:\n"
        "        print(limit, error)\n"
    )
    limits = [size * i // 40 for i in range(42)] + [size - 1, size]
    lines = python("-c", script, folder, *limits).stdout.splitlines()
    printed = dict(line.split(" ", 1) for line in lines if line[0].isdigit())
    assert len(printed) > 40
    return folder, size, printed


def test_a_disk_that_fills_up_leaves_a_whole_file_or_none(full_disk):
    folder, size, printed = full_disk
    whole = {f"{limit}.nc" for limit in printed if int(limit) >= size}
    assert {*os.listdir(folder)} == whole != set()
    for name in whole:
        assert read_netcdf(folder / name).identical(some_dataset(200))


def test_a_disk_that_fills_up_is_reported(full_disk):
    _, size, printed = full_disk
    for limit, words in printed.items():
        if int(limit) < size:
            assert re.search("could not be written .* MB are free there", words)
        else:
            assert words == "written"


FAILURES = pytest.mark.parametrize(
    ("error", "raised"),
    [
        (RuntimeError("broken"), "^broken$"),
        (files.DamagedFileError("another file is damaged"), "^another file is damaged$"),
        (FileNotFoundError(2, "No such file"), r"a.txt: could not be written \(.*\)$"),
        (OSError(28, "No space"), r"a.txt: could not be written \(.*\); .* MB are free there"),
    ],
)


def write_in_vain(path, error):
    """Write half of a file over an old one until an error occurs."""
    path.write_text("old")

    def fail(temporary):
        temporary.write_text("half")
        raise error

    files.atomically(path, fail)


@FAILURES
def test_a_write_that_fails_gives_its_reason(error, raised, tmp_path):
    with pytest.raises(type(error) if "^" in raised else OSError, match=raised):
        write_in_vain(tmp_path / "a.txt", error)


@FAILURES
def test_a_write_that_fails_leaves_what_was_there(error, raised, tmp_path):
    with pytest.raises((type(error), OSError), match=raised):
        write_in_vain(tmp_path / "a.txt", error)
    assert (tmp_path / "a.txt").read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def writer(end: str, path: Path) -> list[str]:
    """Command of a process that writes half of a file, and then does something."""
    script = (
        "import os, sys, pathlib\nfrom jointclosure.storage.files import atomically\n"
        "def write(path):\n    path.write_text('slow')\n    print('writing', flush=True)\n"
        f"    {end}\n"
        "atomically(pathlib.Path(sys.argv[1]), write)\n"
    )
    return [sys.executable, "-c", script, str(path)]


def test_files_of_killed_writers_are_cleared_away(tmp_path):
    for name in ("study.nc", "study.tables.nc"):
        subprocess.run(writer("os.kill(os.getpid(), 9)", tmp_path / name), check=False)
    assert len(os.listdir(tmp_path)) == 2
    files.atomically(tmp_path / "study.nc", lambda temporary: temporary.write_text("whole"))
    assert (tmp_path / "study.nc").read_text() == "whole"
    (left,) = (name for name in os.listdir(tmp_path) if name != "study.nc")
    assert left.startswith(".study.tables.")


def test_the_file_of_a_running_writer_is_left_alone_by_another(tmp_path):
    path = tmp_path / "study.nc"
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    orphan = subprocess.Popen(writer("sys.stdin.readline()", path), text=True, **pipes)
    assert orphan.stdout.readline() == "writing\n"
    files.atomically(path, lambda temporary: temporary.write_text("quick"))
    assert path.read_text() == "quick"
    _, printed = orphan.communicate("go on\n", timeout=60)
    assert (orphan.returncode, printed) == (0, "")
    assert path.read_text() == "slow"
    assert os.listdir(tmp_path) == ["study.nc"]


def some_files(*names):
    """Texts of files with their names and number."""
    return {name: f"{name} of {len(names)}" for name in names}


@pytest.fixture
def folder(tmp_path):
    """A folder of files of two commands, of a page that was added, and of what a user put there."""
    folder = tmp_path / "joint"
    folders.replace_files(folder, "close", some_files("b", "a", "export"))
    assert folders.check_record(folder) == {"close": ["a", "b", "export"]}
    folders.replace_files(folder, "fit", some_files("fit"))
    folders.add_file(folder, "close", "page")
    (folder / "page").touch()
    (folder / "notes").write_text("mine")
    return folder


def test_files_stay_where_those_in_their_place_cannot_be_written(folder):
    with pytest.raises(TypeError, match="not JSON serializable"):
        folders.replace_files(folder, "close", {"a": "half", "b": object()})
    assert (folder / "a").read_text() == "a of 3"


def test_only_files_of_an_earlier_run_of_a_command_go(folder):
    folders.replace_files(folder, "close", some_files("a", "b"))
    assert sorted(os.listdir(folder)) == ["a", "b", "fit", "notes", folders.RECORD]
    assert (folder / "a").read_text() == "a of 2"
    assert folders.check_record(folder)["close"] == ["a", "b"]


@pytest.mark.parametrize("text", ['{"close": ["../outside"]}', "[1]", '{"close": [3]}', "no"])
def test_a_record_that_is_none_is_refused_before_anything_is_removed(tmp_path, text):
    (tmp_path / "outside").write_text("mine")
    folder = tmp_path / "joint"
    folder.mkdir()
    (folder / folders.RECORD).write_text(text)
    for refused in (lambda: folders.replace_files(folder, "close", some_files("a")),
                    lambda: writable((), folder)):  # fmt: skip
        with pytest.raises(InputError, match=f"{folders.RECORD}: must be a JSON object"):
            refused()
    assert (tmp_path / "outside").exists()


def test_all_formats_of_a_figure_have_one_layout(tmp_path):
    figure, axes = subplots(1, 1, figsize=(3.0, 2.0))
    axes.set_ylabel("closure (mm)")
    folders.write(figure, tmp_path / "figure.png")
    places = axes.get_position().bounds
    folders.write(figure, tmp_path / "figure.pdf")
    assert axes.get_position().bounds == places
    assert places[0] > 0.1  # the label has room


def test_what_a_script_imported_is_looked_through_by_no_collection(tmp_path):
    gc.unfreeze()
    try:
        with logging_to(tmp_path / "part_of_a_long_process.log", raised=True):
            assert gc.get_freeze_count() == 0
        with logging_to(tmp_path / "script.log"):
            assert gc.get_freeze_count() > 10_000
    finally:
        gc.unfreeze()


def test_a_script_that_fails_logs_its_traceback(tmp_path):
    log = tmp_path / "logs/script.log"
    with pytest.raises(SystemExit) as ended, logging_to(log):
        raise InputError("heights.txt: is empty")
    assert ended.value.code == 1
    text = log.read_text()
    assert "Traceback" in text
    assert text.endswith("failed: InputError: heights.txt: is empty\n")


def test_the_reason_of_a_failure_is_the_error_and_never_an_ordinary_line(tmp_path):
    log = tmp_path / "script.log"
    assert reason_of_failure(log) == "it ended before its log began"
    with pytest.raises(SystemExit), logging_to(log):
        raise InputError("two lines:\n  of an error")
    assert reason_of_failure(log) == "InputError: two lines: of an error"
    with logging_to(log) as book:  # as left by a process that is killed
        book("realisation 1: status 0, 0.02 s")
    assert reason_of_failure(log) == "it was ended from outside, by a signal or for lack of memory"


def test_an_error_that_is_logged_is_raised_where_that_is_asked_for(tmp_path):
    log = tmp_path / "logs/script.log"
    with pytest.raises(InputError, match="is empty"), logging_to(log, raised=True):
        raise InputError("heights.txt: is empty")

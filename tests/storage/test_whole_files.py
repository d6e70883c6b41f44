"""Files are whole or absent, and one changed bit is an error."""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

from jointclosure.storage.files import DamagedFileError, atomically
from jointclosure.storage.netcdf import read_netcdf, write_netcdf, write_netcdf_blocks


def some_dataset(rows: int = 20) -> xr.Dataset:
    random = np.random.default_rng(3)
    return xr.Dataset(
        {
            "closure": (("realization", "x"), random.random((rows, 40)), {"units": "m"}),
            "status": ("realization", np.arange(rows, dtype=np.int16)),
        },
        coords={"seed": ("realization", np.array([f"{i:032x}" for i in range(rows)], object))},
        attrs={"settings": "{}"},
    )


@pytest.fixture
def stored(tmp_path):
    path = tmp_path / "case.nc"
    write_netcdf(some_dataset(), path)
    return path


def places(size: int) -> np.ndarray:
    """Bytes at random places, and all of the last ones, which hold the digest."""
    return np.append(np.random.default_rng(5).integers(0, size, 300), np.arange(size - 110, size))


def test_every_flipped_bit_is_noticed(stored):
    whole = stored.read_bytes()
    for place in places(len(whole)):
        flipped = bytearray(whole)
        flipped[place] ^= 1 << int(place % 8)
        stored.write_bytes(flipped)
        with pytest.raises(DamagedFileError, match=r"case.nc: the file is not as jointclosure"):
            read_netcdf(stored)
    stored.write_bytes(whole)
    assert read_netcdf(stored).identical(some_dataset())


def test_every_truncated_or_lengthened_file_is_noticed(stored):
    whole = stored.read_bytes()
    for length in (0, 1, 7, 96, len(whole) // 2, len(whole) - 96, len(whole) - 1):
        stored.write_bytes(whole[:length])
        with pytest.raises(DamagedFileError, match="delete it and start again"):
            read_netcdf(stored)
    stored.write_bytes(whole + b"\0")
    with pytest.raises(DamagedFileError):
        read_netcdf(stored)


def test_other_programs_read_a_sealed_file(stored):
    with xr.open_dataset(stored, engine="netcdf4") as dataset:
        assert dataset.load().identical(some_dataset())


def written_under_a_limit(path, size: int) -> subprocess.CompletedProcess:
    """Write the dataset in blocks in a process whose files may have so many bytes."""
    script = (
        "import sys, xarray as xr\n"
        "from tests.storage.test_whole_files import some_dataset, write_netcdf_blocks\n"
        "import resource\n"
        "whole = some_dataset(200)\n"
        "blocks = [whole.isel(realization=slice(i, i + 20)) for i in range(0, 200, 20)]\n"
        "for limit in map(int, sys.argv[2:]):\n"
        "    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))\n"
        "    try:\n"
        "        write_netcdf_blocks(blocks, 'realization', f'{sys.argv[1]}/{limit}.nc')\n"
        "        print(limit, 'written')\n"
        "    except OSError as error:\n"
        "        print(limit, error)\n"
    )
    limits = [str(size * i // 40) for i in range(42)] + [str(size - 1), str(size)]
    command = [sys.executable, "-c", script, str(path), *limits]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_a_disk_that_fills_up_leaves_a_whole_file_or_none_and_says_so(tmp_path):
    whole = some_dataset(200)
    blocks = [whole.isel(realization=slice(i, i + 20)) for i in range(0, 200, 20)]
    write_netcdf_blocks(blocks, "realization", tmp_path / "whole.nc")
    size = os.path.getsize(tmp_path / "whole.nc")
    (tmp_path / "small").mkdir()
    answer = written_under_a_limit(tmp_path / "small", size)
    assert answer.returncode == 0, answer.stderr
    printed = dict(line.split(" ", 1) for line in answer.stdout.splitlines() if line[0].isdigit())
    assert len(printed) > 40
    for limit, words in printed.items():
        file = tmp_path / f"small/{limit}.nc"
        if words == "written":
            assert int(limit) >= size
            assert read_netcdf(file).identical(whole)
        else:
            assert "could not be written" in words
            assert "MB are free there" in words
            assert int(limit) < size
            assert not file.exists()
    assert sorted(p.name for p in (tmp_path / "small").iterdir()) == sorted(
        f"{limit}.nc" for limit, words in printed.items() if words == "written"
    )
    assert {"written"} < set(printed.values())


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 64 kB, where this user may mount one."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(folder)]
    if not shutil.which("mount") or subprocess.run(command, capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    yield folder
    subprocess.run(["umount", "--lazy", str(folder)], check=True)


def test_a_full_disk_leaves_the_old_file_and_says_so(small_disk):
    path = small_disk / "study.nc"
    write_netcdf(some_dataset(20), path)
    with pytest.raises(OSError, match=r"study.nc: could not be written .*; 0\.0 MB are free there"):
        write_netcdf(some_dataset(500), path)
    assert read_netcdf(path).identical(some_dataset(20))
    assert os.listdir(small_disk) == ["study.nc"]


def test_a_read_only_folder_is_said(small_disk):
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    with pytest.raises(OSError, match=r"study.nc: could not be written .*Read-only file system"):
        write_netcdf(some_dataset(), small_disk / "study.nc")


def test_what_a_killed_writer_left_is_cleared_away(tmp_path):
    script = (
        "import os, sys, pathlib\nfrom jointclosure.storage.files import atomically\n"
        "def write(path):\n    path.write_text('half')\n    os.kill(os.getpid(), 9)\n"
        "atomically(pathlib.Path(sys.argv[1]), write)\n"
    )
    for name in ("study.nc", "study.tables.nc"):
        subprocess.run([sys.executable, "-c", script, str(tmp_path / name)], check=False)
    assert len(os.listdir(tmp_path)) == 2
    atomically(tmp_path / "study.nc", lambda temporary: temporary.write_text("whole"))
    left = [name for name in os.listdir(tmp_path) if name != "study.nc"]
    assert (tmp_path / "study.nc").read_text() == "whole"
    assert len(left) == 1
    assert left[0].startswith(".study.tables.")


def test_what_a_running_writer_writes_is_left_alone_by_another_of_the_same_file(tmp_path):
    script = (
        "import sys, pathlib\nfrom jointclosure.storage.files import atomically\n"
        "def write(path):\n    path.write_text('slow')\n    print('writing', flush=True)\n"
        "    sys.stdin.readline()\n"
        "atomically(pathlib.Path(sys.argv[1]), write)\n"
    )
    path = tmp_path / "study.nc"
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    orphan = subprocess.Popen([sys.executable, "-c", script, str(path)], text=True, **pipes)
    assert orphan.stdout.readline() == "writing\n"
    atomically(path, lambda temporary: temporary.write_text("quick"))
    assert path.read_text() == "quick"
    _, printed = orphan.communicate("go on\n", timeout=60)
    assert (orphan.returncode, printed) == (0, "")
    assert path.read_text() == "slow"
    assert os.listdir(tmp_path) == ["study.nc"]


def test_the_room_on_the_disk_is_said_only_where_it_may_be_the_reason(tmp_path):
    def lose(temporary):
        temporary.unlink()

    with pytest.raises(OSError, match=r"a\.txt: could not be written .*No such file") as error:
        atomically(tmp_path / "a.txt", lose)
    assert "free" not in str(error.value)


def test_an_error_of_what_is_written_is_passed_on(tmp_path):
    def blocks():
        yield some_dataset()
        raise DamagedFileError("another file is damaged")

    with pytest.raises(DamagedFileError, match=r"^another file is damaged$"):
        write_netcdf_blocks(blocks(), "realization", tmp_path / "a.nc")
    assert os.listdir(tmp_path) == []

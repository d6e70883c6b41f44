"""Cache: only what is missing, damaged or of other settings is made."""

import os

import pytest
import xarray as xr

from jointclosure.execution import cache
from jointclosure.execution.cache import Entry, is_kept, make_missing


@pytest.fixture(autouse=True, scope="module")
def code():
    """Makers of tests are in no package whose code is digested."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cache, "_code", lambda *functions: functions)
        yield


def doubled(number: float, report, why: str = "") -> xr.Dataset:
    """Twice a number; 13 is refused, and 9 kills its process."""
    report(f"doubles {number} {why}")
    if number == 13:
        raise ValueError("unlucky")
    if number == 9:
        os.kill(os.getpid(), 9)
    return xr.Dataset({"x": 2.0 * number})


def entries(*numbers: float) -> list[Entry]:
    return [Entry(f"numbers/{i}", doubled, (number,)) for i, number in enumerate(numbers)]


def made(folder, *numbers: float) -> list[str]:
    """Make what is missing; the names of the logs that were written."""
    for log in folder.glob("logs/numbers/*"):
        log.unlink()
    make_missing(entries(*numbers), folder, 1, lambda line: None)
    return sorted(log.stem for log in folder.glob("logs/numbers/*.log"))


def flip_a_bit(file):
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 4
    file.write_bytes(data)


def test_only_what_is_missing_foreign_or_damaged_is_made(tmp_path):
    assert made(tmp_path, 1, 2, 3) == ["0", "1", "2"]
    assert made(tmp_path, 1, 2, 3) == []
    assert made(tmp_path, 1, 5, 3) == ["1"]
    files = [entry.file(tmp_path) for entry in entries(1, 5, 3)]
    files[0].unlink()
    files[1].write_bytes(files[2].read_bytes())
    flip_a_bit(files[2])
    assert made(tmp_path, 1, 5, 3) == ["0", "1", "2"]
    assert len(list(tmp_path.glob("benchmarks/numbers/*.tsv"))) == 3


def test_options_change_no_key(tmp_path):
    (entry,) = entries(1)
    assert entry.key == entry._replace(options={"why": "in haste"}, joints=7).key
    assert entry.key != entry._replace(settings=(1.5,)).key
    assert entry.key != entry._replace(uses=("studies.size.study:nested",)).key


@pytest.fixture(scope="module")
def failed(tmp_path_factory):
    """The folder of entries of which two failed, and what was reported."""
    folder, lines = tmp_path_factory.mktemp("failed"), []
    with pytest.raises(RuntimeError, match="2 of 4 could not be made"):
        make_missing(entries(1, 13, 9, 4), folder, 2, lines.append)
    return folder, lines


def test_a_failure_is_named(failed):
    folder, lines = failed
    assert any(line == "numbers/1: ValueError: unlucky" for line in lines)
    assert any("numbers/2: ProcessLostError" in line and "CORES=1" in line for line in lines)
    assert "failed: ValueError: unlucky" in (folder / "logs/numbers/1.log").read_text()


def test_what_does_not_fail_is_made(failed):
    assert [is_kept(entry, failed[0]) for entry in entries(1, 13, 9, 4)] == [1, 0, 0, 1]

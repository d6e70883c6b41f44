"""Cache of simulated joints: files that processes make, and that are kept while their key agrees.

The key is a digest of the settings of a file and of the code of its maker. A run that was killed
continues with the joints that are kept. Files are made again if code on which they depend was
edited, if they are of other settings, or if they are damaged.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import xarray as xr

from jointclosure.compilation.code_digests import code_digest
from jointclosure.execution.progress import Countdown
from jointclosure.execution.workers import Failed, ProcessLostError, in_processes
from jointclosure.inputs import InputError
from jointclosure.storage.files import digest
from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import reading_netcdf, write_netcdf


class Entry(NamedTuple):
    """Entry of a cache: a file with a dataset, which ``make`` computes if the file is absent.

    The function ``make`` is called with the ``settings`` and, as keywords, the ``options`` and a
    function ``report``, which takes a line of text. The key of the file depends on the settings,
    and on the code of ``make`` and of the functions ("module:function") in ``uses``. Options must
    not change the result. The time of an entry is expected to be proportional to its number of
    ``joints``.
    """

    name: str
    make: Callable[..., xr.Dataset]
    settings: tuple
    options: Mapping[str, Any] = {}
    joints: int = 1
    uses: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """Digest of the settings of the entry, and of the code on which its result depends."""
        made_by = f"{self.make.__module__}:{self.make.__name__}"
        return digest(_code(made_by, *self.uses), self.settings)

    def file(self, folder: Path) -> Path:
        """Return the path of the entry's file in the folder of a cache."""
        return folder / f"{self.name}.nc"


@lru_cache(maxsize=None)
def _code(*functions: str) -> str:
    return code_digest(*functions, titles=False)


def is_kept(entry: Entry, folder: Path) -> bool:
    """Return whether the file of an entry is in the folder, is whole, and has the entry's key."""
    try:
        with reading_netcdf(entry.file(folder)) as stored:
            return stored.attrs.get("key") == entry.key
    except OSError:
        return False


def make_missing(
    entries: Iterable[Entry],
    folder: Path,
    workers: int,
    report: Callable[[str], None],
    title: str = "closed",
    prepare: Callable[[], object] = lambda: None,
    apart: bool = True,
) -> None:
    """Make the files of the cache entries that are not kept in a folder, in parallel.

    Each file gets a log and a benchmark of its time. ``report`` is called with lines of progress
    that begin with ``title``. ``prepare`` is called before the processes start, if anything is
    missing. ``workers`` and ``apart`` are as for `in_processes`. If some files could not be made,
    an error is raised after all others were made: `InputError` if the first failure was one, or
    else `RuntimeError`.
    """
    entries = list(entries)
    missing = [entry for entry in entries if not is_kept(entry, folder)]
    again = sum(entry.file(folder).exists() for entry in missing)
    if again:
        report(f"{again} files are of other settings or code, or damaged, and are made again")
    if not missing:
        return
    prepare()
    for entry in missing:
        entry.file(folder).parent.mkdir(parents=True, exist_ok=True)
    done = Countdown(title, sum(entry.joints for entry in missing), report)
    failed: list[tuple[Exception, str]] = []
    tasks = [(entry, entry.key, folder) for entry in missing]
    for place, answer in in_processes(_make, tasks, workers, apart):
        if isinstance(answer, Failed):
            reason = _described(missing[place], answer.error)
            failed.append((answer.error, reason))
            report(reason)
        else:
            done(missing[place].joints)
    if failed:
        error, reason = failed[0]
        kind = InputError if isinstance(error, InputError) else RuntimeError
        raise kind(f"{len(failed)} of {len(entries)} could not be made: {reason}")


def _make(entry: Entry, key: str, folder: Path) -> None:
    """Make the file of an entry with its key in a folder, in a worker; errors go to its log too."""
    log = folder / f"logs/{entry.name}.log"
    benchmark = folder / f"benchmarks/{entry.name}.tsv"
    with logging_to(log, benchmark, raised=True) as logbook:
        made = entry.make(*entry.settings, **entry.options, report=logbook)
        write_netcdf(made.assign_attrs(key=key), entry.file(folder))


def _described(entry: Entry, error: Exception) -> str:
    """Describe why an entry failed: its error, the error's notes, and advice for lost processes."""
    notes = list(getattr(error, "__notes__", []))
    if isinstance(error, ProcessLostError):
        notes.append("systems that run out of memory kill processes: start again with CORES=1")
    return "; ".join([f"{entry.name}: {type(error).__name__}: {error}", *notes])

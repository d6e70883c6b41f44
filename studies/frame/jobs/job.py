"""Job of the workflow: its log, time and memory, check of its inputs, seal of its outputs."""

import os
import resource
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from jointclosure.engine.forks import end_with_parent
from studies.frame.jobs.logbook import Logbook, logging_to
from studies.frame.jobs.seals import check_inputs, write_seal


@contextmanager
def job(snakemake) -> Iterator[Logbook]:
    """Open the log of a job, check its inputs, and seal its outputs; end with who started it.

    Before the work, all results that the job reads must be those listed by their seals (inputs
    named ``seals``). After it, the outputs are sealed if the rule has an output ``seal``, and the
    time and memory that the job took are written to the log ``benchmark``, if the rule has one.

    Parameters
    ----------
    snakemake : object
        The object of this name in a script of Snakemake.

    Yields
    ------
    Logbook
    """
    start = time.monotonic()
    end_with_parent(os.getppid())
    with logging_to(snakemake.log[0]) as logbook:
        seals = listed(snakemake.input.get("seals", []))
        results = _results(Path(snakemake.log[0]))
        inputs = [path for path in snakemake.input if path not in seals]
        inputs = [path for path in inputs if Path(path).is_relative_to(results)]
        check_inputs(inputs, seals)
        yield logbook
        if seal := snakemake.output.get("seal"):
            outputs = [path for path in snakemake.output if path != seal]
            write_seal(seal, outputs, dict(snakemake.params), inputs, seals)
    if benchmark := snakemake.log.get("benchmark"):
        _write_benchmark(benchmark, time.monotonic() - start)


def _write_benchmark(path: str, seconds: float) -> None:
    """Write elapsed time [s], largest memory [MB] and processor time [s] of this process."""
    used = [resource.getrusage(of) for of in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    memory = max(use.ru_maxrss for use in used) / (1e6 if sys.platform == "darwin" else 1e3)
    processor = sum(use.ru_utime + use.ru_stime for use in used)
    row = f"{seconds:.2f}\t{memory:.2f}\t{processor:.2f}"
    Path(path).write_text(f"s\tmax_rss\tcpu_time\n{row}\n", encoding="utf-8")


def listed(paths) -> list[str]:
    """Return a list of paths, also for a single path."""
    return [paths] if isinstance(paths, str) else list(paths)


def _results(log: Path) -> Path:
    """Return the folder of all studies' results, from the log of a job."""
    return next(folder.parent.parent for folder in log.parents if folder.name == "logs")

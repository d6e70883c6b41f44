"""Job of the workflow: its log, the check of its inputs, and the seal of its outputs."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from jointclosure.jobs.logbook import Logbook, logging_to
from jointclosure.storage.seals import check_inputs, write_seal


@contextmanager
def job(snakemake) -> Iterator[Logbook]:
    """Open the log of a job, check its inputs, and seal its outputs.

    Before the work, all results that the job reads must be those listed by their seals (inputs
    named ``seals``). After it, the outputs are sealed if the rule has an output ``seal``.

    Parameters
    ----------
    snakemake : object
        The object of this name in a script of Snakemake.

    Yields
    ------
    Logbook
    """
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


def listed(paths) -> list[str]:
    """Return a list of paths, also for a single path."""
    return [paths] if isinstance(paths, str) else list(paths)


def _results(log: Path) -> Path:
    """Return the folder of all studies' results, from the log of a job."""
    return next(folder.parent.parent for folder in log.parents if folder.name == "logs")

"""A job of the workflow: its log, what it may read, and the seal on what it wrote."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from jointclosure.jobs.logbook import Logbook, logging_to
from jointclosure.storage.seals import check_inputs, write_seal


@contextmanager
def job(snakemake) -> Iterator[Logbook]:
    """What a script of the workflow does around its work.

    Before it: each result that the job reads must be the one that its seal lists (inputs
    named ``seals``). After it: what was written is sealed, where the rule has an output ``seal``.

    Parameters
    ----------
    snakemake : object
        As Snakemake gives to a script.

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
    """List paths, of which Snakemake gives a single one as itself."""
    return [paths] if isinstance(paths, str) else list(paths)


def _results(log: Path) -> Path:
    """The folder of all studies' results, from the log of a job of one."""
    return next(folder.parent.parent for folder in log.parents if folder.name == "logs")

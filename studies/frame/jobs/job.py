"""Job of the workflow: its log, time and memory, check of its inputs, seal of its outputs."""

import logging
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from jointclosure.engine.workers import end_with_parent
from jointclosure.storage.logs import SHOWN, Logbook, logging_to, measured
from studies.frame.jobs.seals import check_inputs, write_seal

ENGINE = "JOINTCLOSURE_ENGINE"
"""Variable of the environment with the process of Snakemake, if that starts its jobs itself."""


@contextmanager
def job(snakemake) -> Iterator[Logbook]:
    """Open the log of a job, check its inputs, and seal its outputs; end with who started it.

    ``snakemake`` is the object of this name in a script. Before the work, all results that the job
    reads must be those listed by their seals (inputs named ``seals``). After it, the outputs are
    sealed if the rule has an output ``seal``.
    """
    if engine := os.environ.get(ENGINE):
        end_with_parent(int(engine))
    path = snakemake.log[0]
    try:
        with logging_to(path) as logbook, measured(snakemake.log.benchmark):
            seals = listed(snakemake.input.get("seals", []))
            results = _results(Path(path))
            inputs = [path for path in snakemake.input if path not in seals]
            inputs = [path for path in inputs if Path(path).is_relative_to(results)]
            check_inputs(inputs, seals)
            yield logbook
            if seal := snakemake.output.get("seal"):
                outputs = [path for path in snakemake.output if path != seal]
                write_seal(seal, outputs, dict(snakemake.params), inputs, seals)
    except BaseException as error:
        reason = f"{type(error).__name__}: {error}; its log is {path}"
        print(f"{SHOWN}{snakemake.rule} failed: {reason}", file=sys.__stderr__, flush=True)
        raise


def compile_all(kernels: list[list[str]], report: Callable[[str], None]) -> None:
    """Compile kernels (`jointclosure.joint.warmup.kernels_of`), or load them."""
    from jointclosure.compilation.kernels import cache_folder
    from jointclosure.joint.warmup import compile_kernels
    from jointclosure.parameters import Choices, scene_of

    report(f"kernels are kept in {cache_folder()}")
    # the announcement of a compilation is for the user
    logging.getLogger("jointclosure").addHandler(logging.StreamHandler(sys.__stderr__))
    names: Any
    for names in kernels:
        scene, peaks, solver, breakage = names
        compile_kernels(scene_of(scene), Choices(peaks=peaks), solver, breakage)


def listed(paths) -> list[str]:
    """Return a list of paths, also for a single path."""
    return [paths] if isinstance(paths, str) else list(paths)


def _results(log: Path) -> Path:
    """Return the folder of all studies' results, from the log of a job."""
    return next(folder.parent.parent for folder in log.parents if folder.name == "logs")

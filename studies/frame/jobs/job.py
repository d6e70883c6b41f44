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
    reads must be those listed by their seals.
    """
    if engine := os.environ.get(ENGINE):
        end_with_parent(int(engine))
    log = Path(snakemake.log[0])
    try:
        with logging_to(log) as logbook, measured(snakemake.log.benchmark):
            study = next(folder.parent for folder in log.parents if folder.name == "logs")
            results = study.parent
            inputs = [path for path in snakemake.input if Path(path).is_relative_to(results)]
            check_inputs(inputs, results)
            yield logbook
            if is_sealed(snakemake.output, snakemake.params):
                seal = study / "seals" / log.relative_to(study / "logs").with_suffix(".json")
                seal.parent.mkdir(parents=True, exist_ok=True)
                write_seal(seal, snakemake.output, dict(snakemake.params), inputs)
    except BaseException as error:
        reason = f"{type(error).__name__}: {error}; its log is {log}"
        print(f"{SHOWN}{snakemake.rule} failed: {reason}", file=sys.__stderr__, flush=True)
        raise


def is_sealed(output, params) -> bool:
    """Return whether a job seals its outputs: notes are no input, a file of a cache has a key."""
    return Path(str(output[0])).suffix != ".txt" and not params.get("key")


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
        scene, peaks, bound, solver, breakage = names
        choices = Choices(peaks=peaks, strength_bound=bound)
        compile_kernels(scene_of(scene), choices, solver, breakage)


def listed(paths) -> list[str]:
    """Return a list of paths, also for a single path."""
    return [paths] if isinstance(paths, str) else list(paths)

"""Compile all necessary kernels before the jobs start."""

import json
import logging
import sys
from pathlib import Path

from jointclosure.compilation.kernels import cache_folder
from jointclosure.joint.warmup import compile_kernels
from jointclosure.parameters import Choices, scene_of
from jointclosure.storage.text import read_text, write_text
from studies.frame.jobs.job import job
from studies.frame.jobs.logbook import Logbook


def main(kernels: list[list[str]], output: str, log: Logbook) -> None:
    """Compile, and write a note with the kernels and the name of the folder of the machine code."""
    log(f"kernels are kept in {cache_folder()}")
    # the log of Snakemake, which shows the announcement of a compilation to the user
    logging.getLogger("jointclosure").addHandler(logging.StreamHandler(sys.__stderr__))
    for kernel in kernels:
        compiled(*kernel)
        log(", ".join(kernel))
    write_text(json.dumps({"folder": cache_folder().name, "kernels": kernels}) + "\n", output)


def compiled(scene: str, peaks: str, solver: str, breakage: str) -> None:
    """Compile the kernels of a scene, or load them."""
    compile_kernels(scene_of(scene), Choices(peaks=peaks), solver, breakage)


def load(note: Path) -> None:
    """Load the kernels of a note, unless it is of other code."""
    text = read_text(note)
    content = json.loads(text) if text.startswith("{") else {}  # notes of earlier versions
    if content.get("folder") == cache_folder().name:
        for kernel in content["kernels"]:
            compiled(*kernel)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.params.kernels, snakemake.output[0], logbook)

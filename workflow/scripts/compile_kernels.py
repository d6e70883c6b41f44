"""Compile all necessary kernels before the jobs start."""

from jointclosure.compilation.kernels import cache_folder
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.joint.warmup import compile_kernels
from jointclosure.parameters import Choices, scene_of
from jointclosure.storage.text import write_text


def main(kernels: list[list[str]], output: str, log: Logbook) -> None:
    """Compile, and write the name of the folder of the machine code."""
    log(f"kernels are kept in {cache_folder()}")
    for scene, peaks, solver, breakage in kernels:
        compile_kernels(scene_of(scene), Choices(peaks=peaks), solver, breakage)
        log(f"{scene}, {peaks} peaks, {solver}, {breakage}")
    write_text(f"kernels compiled for {cache_folder().name}\n", output)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.params.kernels, snakemake.output[0], logbook)

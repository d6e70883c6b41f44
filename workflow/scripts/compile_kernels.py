"""Compile every kernel that the study needs, before the cases fan out."""

from jointclosure import Choices
from jointclosure.compilation import cache_folder
from jointclosure.dataset import write_text
from jointclosure.logbook import Logbook, logging_to
from jointclosure.parameters import scene_of, to_si
from jointclosure.warmup import compile_kernels


def main(
    scenes: list[str], choices: dict, solver: str, breakage: str, output: str, log: Logbook
) -> None:
    """Compile, and leave a note of where the machine code is."""
    log(f"kernels are kept in {cache_folder()}")
    for scene in scenes:
        log(f"compiling {scene}")
        compile_kernels(scene_of(scene), Choices(**to_si(choices)), solver, breakage)
    log("compiled")
    write_text(f"kernels compiled for {cache_folder().name}\n", output)


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(
            snakemake.params.scenes,
            snakemake.params.choices,
            snakemake.params.solver,
            snakemake.params.breakage,
            snakemake.output[0],
            logbook,
        )

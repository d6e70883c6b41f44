"""Compile every kernel that a list of scenes needs."""

import json

from jointclosure.compilation import cache_folder
from jointclosure.dataset import write_text
from jointclosure.logbook import Logbook, logging_to
from jointclosure.study.configuration import choices_of, effects_of, numerics_of
from jointclosure.warmup import compile_kernels


def main(scenes: list[dict], output: str, log: Logbook) -> None:
    """Compile, each combination that differs in its kernels once."""
    compiled = set()
    for scene in scenes:
        effects, choices, numerics = effects_of(scene), choices_of(scene), numerics_of(scene)
        key = json.dumps([effects, choices.peaks, numerics.solver, numerics.breakage])
        if key not in compiled:
            compile_kernels(effects, choices, numerics.solver, numerics.breakage)
            compiled.add(key)
            log(f"compiled {key}")
    write_text(f"kernels compiled for {cache_folder().name}\n", output)


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(snakemake.params.scenes, snakemake.output[0], logbook)

"""Compile every kernel that the hard cases need, before their groups fan out."""

from jointclosure.compilation import cache_folder
from jointclosure.dataset import write_text
from jointclosure.logbook import Logbook, logging_to
from jointclosure.verification.hard_cases import compile_for


def main(cases: list[dict], output: str, log: Logbook) -> None:
    """Compile, and leave a note of where the machine code is."""
    for case in cases:
        compile_for(case)
    log(f"compiled, kept in {cache_folder()}")
    write_text(f"kernels compiled for {cache_folder().name}\n", output)


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(snakemake.params.cases, snakemake.output[0], logbook)

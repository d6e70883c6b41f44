"""Compile all necessary kernels before parallel jobs start."""

from jointclosure.storage.files import write_text
from studies.frame.jobs import compile_all, job

if __name__ == "__main__":
    with job(snakemake) as logbook:
        compile_all(snakemake.params.kernels, logbook)
        lines = [", ".join(kernel) for kernel in snakemake.params.kernels]
        write_text("\n".join(lines) + "\n", snakemake.output[0])

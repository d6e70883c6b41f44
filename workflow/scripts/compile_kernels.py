"""Compile the kernels of the solver, before parallel jobs load them."""

from jointclosure.joint.warmup import compile_all
from jointclosure.storage.files import write_text
from jointclosure.storage.logs import logging_to

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        wildcards = snakemake.wildcards
        kernel = [wildcards.scene, wildcards.peaks, wildcards.bound]
        kernel += [wildcards.solver, wildcards.breakage]
        write_text(compile_all([kernel], log), snakemake.output[0])

"""Make the files of a step by its function (`studies.frame.products`), as a job of Snakemake."""

from importlib import import_module

from studies.frame.products import make_files
from studies.frame.seals import job, study_of

if __name__ == "__main__":
    with job(snakemake) as logbook:
        module, _, function = snakemake.params.make.partition(":")
        make_files(
            getattr(import_module(module), function),
            dict(snakemake.input),
            snakemake.params.settings,
            snakemake.output,
            config=snakemake.config,
            folder=study_of(snakemake.output[0]),
            workers=snakemake.threads,
            log=logbook,
        )

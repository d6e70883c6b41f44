"""Make the files of a product of the study."""

from studies.frame.jobs import job, listed
from studies.paper.products import PRODUCTS

if __name__ == "__main__":
    with job(snakemake) as logbook:
        PRODUCTS[snakemake.rule].write(
            dict(snakemake.input),
            snakemake.params.settings,
            listed(snakemake.output.files),
            logbook,
        )

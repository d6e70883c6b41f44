"""Close the joints of one file of the cache, on a node of a cluster."""

from pathlib import Path

from jointclosure.engine.cache import make_missing
from studies.frame.experiments import cached, checked
from studies.frame.jobs import job

if __name__ == "__main__":
    with job(snakemake) as logbook:
        kind, folder = snakemake.wildcards.kind, Path(snakemake.output[0]).parent
        folder = folder if folder.name != kind else folder.parent
        entry = cached(checked(snakemake.config), kind, folder)[
            f"{kind}/{snakemake.wildcards.block}"
        ]
        make_missing([entry], folder, 1, logbook)

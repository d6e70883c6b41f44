"""Judge the paper's claims by the model and by the study."""

from jointclosure.statistics.repetitions import Design
from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import reading_checked
from studies.paper.judged_claims import Evidence, judge_claims

if __name__ == "__main__":
    read, params = snakemake.input, snakemake.params
    with (
        logging_to(snakemake.log[0]),
        reading_checked(read.study, params.key_of["study"]) as study,
        reading_checked(read.pool, params.key_of["pool"]) as pool,
    ):
        design = Design(study.sizes["realization"], params.significance)
        evidence = Evidence(study, pool, design, params.repetitions, params.root_seed)
        claims, margins = judge_claims(evidence, read_csv(read.paper))
        write_csv(claims, snakemake.output.claims)
        write_csv(margins, snakemake.output.margins)

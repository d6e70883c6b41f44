"""Find the realisations that fit the measured curves best."""

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import reading_checked
from studies.paper.closure_tables import fit_table
from studies.paper.measured_curves import measured_curves

if __name__ == "__main__":
    params = snakemake.params
    with (
        logging_to(snakemake.log[0]),
        reading_checked(snakemake.input.study, params.key) as study,
    ):
        table = fit_table(study, measured_curves(params.curves), params.seating_stress)
        write_csv(table, snakemake.output[0])

"""Find the realisations that fit the measured curves best."""

from jointclosure.measured.likelihood import curve_sentences
from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import reading_checked
from studies.paper.closure_tables import fit_lines, fit_table
from studies.paper.measured_curves import measured_curves

if __name__ == "__main__":
    params = snakemake.params
    with (
        logging_to(snakemake.log[0]) as log,
        reading_checked(snakemake.input.study, params.key) as study,
    ):
        curves = measured_curves(params.curves)
        for rock, curve in curves.items():
            for sentence in curve_sentences(curve):
                log(f"{rock}: {sentence}")
        table = fit_table(study, curves, params.seating_stress)
        for line in fit_lines(table):
            log(line)
        write_csv(table, snakemake.output[0])

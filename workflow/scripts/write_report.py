"""Write the study as one page."""

from jointclosure.storage.files import write_text
from jointclosure.storage.logs import logging_to
from studies.commands.report import report_page
from studies.frame.checked_files import reading_checked

if __name__ == "__main__":
    read = snakemake.input
    with (
        logging_to(snakemake.log[0]),
        reading_checked(read.study, snakemake.params.key) as study,
    ):
        tables = [*read.tables, *read.assessed, *read.beside]
        write_text(report_page(study, tables, read.figures), snakemake.output[0])

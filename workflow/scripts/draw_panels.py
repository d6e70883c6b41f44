"""Draw the panels of the first screen of a report, as PNG and PDF."""

from pathlib import Path

from jointclosure.storage.files import read_csv
from jointclosure.storage.folders import write
from jointclosure.storage.logs import logging_to
from studies.assessment.report_panels import first_panels

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        read, params = snakemake.input, snakemake.params
        differences = read_csv(read.differences) if read.differences else None
        panels = first_panels(read_csv(read.hardness), params.titles, differences, params.within)
        for path in map(Path, snakemake.output):
            write(panels[path.stem], path)

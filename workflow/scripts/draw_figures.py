"""Draw the figures of the study, as PNG and PDF."""

from pathlib import Path

from jointclosure.storage.files import read_csv
from jointclosure.storage.folders import write
from jointclosure.storage.logs import logging_to
from jointclosure.storage.netcdf import reading_netcdf
from studies.frame.checked_files import reading_checked
from studies.paper.figures import study_figures
from studies.paper.measured_curves import measured_curves

if __name__ == "__main__":
    read, params = snakemake.input, snakemake.params
    with (
        logging_to(snakemake.log[0]) as log,
        reading_checked(read.study, params.key) as study,
        reading_netcdf(read.surfaces) as surfaces,
    ):
        figures = study_figures(
            study,
            surfaces,
            read_csv(read.intervals),
            read_csv(read.closures),
            params.rocks,
            params.seating_stress,
            params.wall_strength_ratio,
            curves=measured_curves(params.measured),
            fits=read_csv(read.fits) if read.fits else None,
            flow=read_csv(read.flow) if read.flow else None,
            report=log,
        )
        for path in map(Path, snakemake.output):
            write(figures[path.stem], path)

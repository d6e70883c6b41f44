"""Find the realisations that fit the measured curves best."""

from jointclosure.config.plain import from_plain
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.measured.curves import CurveSettings, fit_table, measured_curves
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.storage.text import read_text, write_csv


def main(study: str, settings: dict, output: str, log: Logbook) -> None:
    """Write the best fit of each rock with a measured curve, cycle by cycle."""
    curves = measured_curves(from_plain(dict[str, CurveSettings], settings["curves"]), read_text)
    with reading_netcdf(study) as dataset:
        fits = fit_table(dataset, curves, settings["seating_stress"])
    write_csv(fits, output)
    for row in fits.itertuples():
        log(
            f"{row.rock}, cycle {row.cycle}: realisation {row.best_realization}, "
            f"misfit {row.misfit_mm:.3g} mm, {row.samples} samples"
        )


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.input.study, dict(snakemake.params), snakemake.output[0], logbook)

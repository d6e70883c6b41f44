"""Fit the bearing-area law to a study's first loadings, and test it on other joints."""

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import Grid, Surface
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv
from jointclosure.surrogate.calibration import calibrate


def main(ensemble: str, settings: dict, output: str, log: Logbook) -> None:
    """Write constants and errors."""
    grid, surface = from_plain(Grid, settings["grid"]), from_plain(Surface, settings["surface"])
    table = calibrate(read_netcdf(ensemble), grid, surface)
    write_csv(table, output)
    for row in table.drop_duplicates(["constants", "at_strength"]).itertuples():
        name = row.rock if row.constants == "own" else "all rocks"
        log(f"{name}: area fraction {row.at_strength:.4f} (stress/strength)^{row.exponent:.4f}")
    log(f"wrote {output}: {len(table)} rows")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.input.pool, dict(snakemake.params), snakemake.output[0], logbook)

"""Put a study of the scale effect together: all that was read, ratios, exponents, scalings."""

import xarray as xr

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import SizeSpectrum
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import write_csv
from jointclosure.studies.size.scaling import collapse_table
from jointclosure.studies.size.table import barton_bandis_table, exponent_table, size_table


def main(
    inputs: dict[str, dict[str, str]],
    told: dict,
    configuration: dict,
    outputs: list[str],
    log: Logbook,
) -> None:
    """Write a dataset over (rock, spectrum, ...), and four tables."""
    runs = {
        rock: xr.concat([read_netcdf(file) for file in files.values()], "spectrum").assign_coords(
            spectrum=list(files)
        )
        for rock, files in inputs.items()
    }
    together = xr.concat(list(runs.values()), "rock").assign_coords(rock=list(runs))
    study, *tables = outputs
    write_netcdf(together.assign_attrs(provenance(configuration)), study)
    base = tuple(told["base"])
    spectra = from_plain(dict[str, SizeSpectrum], told["spectra"])
    found = (
        size_table(runs, base),
        exponent_table(runs, base),
        collapse_table(runs, {name: each.roll_off for name, each in spectra.items()}),
        barton_bandis_table(runs, base, told["rocks"], told["strength_ratio"]),
    )
    for table, output in zip(found, tables, strict=True):
        write_csv(table, output)
        log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        files = iter(snakemake.input.runs)
        main(
            {
                rock: {spectrum: next(files) for spectrum in snakemake.params.spectra}
                for rock in snakemake.params.rocks
            },
            dict(snakemake.params),
            snakemake.config,
            [snakemake.output.study, *snakemake.output.tables],
            logbook,
        )

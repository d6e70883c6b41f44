"""Put a study of mismatch together: all that was read, means, and the shift that unmates."""

import xarray as xr

from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import write_csv
from jointclosure.studies.mismatch.table import independence_table, mismatch_table


def main(
    inputs: dict[str, list[str]],
    tolerance: float,
    configuration: dict,
    outputs: dict[str, str],
    log: Logbook,
) -> None:
    """Write a dataset over (rock, wavelength, shift, realization, cycle), and its tables."""
    runs = {
        rock: xr.concat([read_netcdf(file) for file in files], "wavelength", join="outer")
        for rock, files in inputs.items()
    }
    together = xr.concat(list(runs.values()), "rock", join="outer")
    together = together.assign_coords(rock=list(runs)).assign_attrs(provenance(configuration))
    write_netcdf(together, outputs["study"])
    write_csv(mismatch_table(runs), outputs["table"])
    shifts = independence_table(runs, tolerance, configuration["study"]["root_seed"])
    write_csv(shifts, outputs["shifts"])
    for row in shifts.itertuples():
        log(
            f"{row.rock}, mismatch {row.wavelength_mm:g} mm: as independent walls from a shift of "
            f"{row.shift_mm:.3g} mm ({row.low:.3g} to {row.high:.3g})"
        )


if __name__ == "__main__":
    with job(snakemake) as logbook:
        files = list(snakemake.input.runs)
        each = len(files) // len(snakemake.params.rocks)
        main(
            {
                rock: files[each * place : each * (place + 1)]
                for place, rock in enumerate(snakemake.params.rocks)
            },
            snakemake.params.tolerance,
            snakemake.config,
            {name: snakemake.output[name] for name in ("study", "table", "shifts")},
            logbook,
        )

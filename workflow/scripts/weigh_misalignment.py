"""Put a study of misalignment together: all that was read, and what tilt and rotation change."""

import xarray as xr

from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf, write_netcdf
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import write_csv
from jointclosure.studies.misalignment.table import misalignment_table


def main(
    inputs: dict[str, list[str]], configuration: dict, outputs: dict[str, str], log: Logbook
) -> None:
    """Write a dataset over (rock, wavelength, condition, realization, cycle), and its table."""
    runs = {
        rock: xr.concat([read_netcdf(file) for file in files], "wavelength")
        for rock, files in inputs.items()
    }
    together = xr.concat(list(runs.values()), "rock", combine_attrs="drop_conflicts")
    together = together.assign_coords(rock=list(runs)).assign_attrs(provenance(configuration))
    write_netcdf(together, outputs["study"])
    table = misalignment_table(runs)
    write_csv(table, outputs["table"])
    log(f"wrote {outputs['table']}: {len(table)} rows")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        files = list(snakemake.input.runs)
        each = len(files) // len(snakemake.params.rocks)
        main(
            {
                rock: files[each * place : each * (place + 1)]
                for place, rock in enumerate(snakemake.params.rocks)
            },
            snakemake.config,
            {name: snakemake.output[name] for name in ("study", "table")},
            logbook,
        )

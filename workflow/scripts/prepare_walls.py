"""Read the scanned walls of a rock, bring them to the grid, and check that there is room."""

from jointclosure.storage.logs import Logbook
from jointclosure.storage.netcdf import write_netcdf
from studies.frame.jobs import job
from studies.frame.rocks import wall_files
from studies.frame.walls import Cutter, walls_of_files


def main(settings: dict, output: str, log: Logbook) -> None:
    """Write the walls (y, x) of a rock, with the digests of their files."""
    walls, grid = settings["walls"], settings["grid"]
    read = (settings[name] for name in ("jrc_relation", "unusual_values"))
    prepared = walls_of_files(walls, grid.spacing, *read)
    log(prepared.attrs.get("registration", "as they lie"))
    for side, file in wall_files(walls).items():
        about = prepared[side].attrs | {"file": file, "sha256": settings["digests"][side]}
        prepared[side].attrs = about
        log(f"{side}: {about}")
    # the check is the same whatever the order
    cutter = Cutter(prepared, grid.shape, 0)
    prepared.attrs |= cutter.room()
    log(str(cutter.room()))
    cutter.check(settings["realizations"])
    write_netcdf(prepared, output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.params), snakemake.output[0], logbook)

"""Read the measured walls of a rock, bring them to the grid, and check that there is room."""

from jointclosure.config.units import to_si
from jointclosure.config.walls import wall_files, wall_settings
from jointclosure.ensemble.measured_walls import cutter_of, prepared_walls, room
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.scans import read_scan
from jointclosure.storage.netcdf import write_netcdf


def main(settings: dict, output: str, log: Logbook) -> None:
    """Write the walls (y, x) of a rock, with the digests of their files."""
    walls, grid = wall_settings(settings["walls"]), to_si(settings["grid"])
    files = wall_files(settings["walls"])
    given = {name: walls[name] for name in ("units", "spacing", "variable")}
    scans = {side: read_scan(file, **given) for side, file in files.items()}
    prepared = prepared_walls(scans, walls, grid["spacing"], settings["jrc_relation"])
    for side, file in files.items():
        about = prepared[side].attrs | {"file": file, "sha256": settings["digests"][side]}
        prepared[side].attrs = about
        log(f"{side}: {about}")
    # the check is the same whatever the order
    cutter = cutter_of(prepared, (grid["cells_y"], grid["cells_x"]), 0, "wall")
    prepared.attrs |= room(cutter)
    log(str(room(cutter)))
    cutter.check(settings["realizations"])
    write_netcdf(prepared, output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.params), snakemake.output[0], logbook)

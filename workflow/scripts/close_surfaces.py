"""Close all surface pairs of a case, or of a block of its realisations."""

import json
from pathlib import Path

import xarray as xr

from jointclosure.config.plain import from_plain
from jointclosure.ensemble.closing import close_surfaces
from jointclosure.ensemble.settings import ClosureSettings, as_text, check_settings
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.jobs.progress import Countdown
from jointclosure.parameters import Effects, scene_name
from jointclosure.storage.netcdf import read_netcdf, reading_netcdf, write_netcdf_blocks
from jointclosure.storage.text import read_text


def main(
    surfaces: str,
    pilot: tuple[str | None, str | None],
    settings: ClosureSettings,
    output: str,
    log: Logbook,
) -> None:
    """Write the closures (realization, cycle, branch, stress).

    ``pilot``: files of the effects that it chose, and of what it closed with all effects.
    """
    chosen, before = pilot
    told = settings if chosen is None else settings.with_effects(chosen_effects(chosen))
    log(f"settings: {as_text(told)}")
    scene, label = scene_name(told.case.effects), told.case.label
    with reading_netcdf(surfaces) as pairs:
        check_settings(surfaces, pairs.attrs, settings.surfaces)
        countdown = Countdown(label, pairs.sizes["realization"])
        closed = close_surfaces(
            pairs,
            told,
            report=lambda line: log(f"{line}; {countdown()}"),
            repeated_by=repeated_by(Path(output), label),
            before=closed_by_pilot(before, label) if before and told == settings else None,
        )
        marked = (block.assign_attrs(settings=as_text(settings), scene=scene) for block in closed)
        write_netcdf_blocks(marked, "realization", output)
    log(f"wrote {output}")


def chosen_effects(path: str) -> Effects:
    """The effects that the pilot of the case's rock chose."""
    return Effects(**json.loads(read_text(path))["effects"])


def closed_by_pilot(path: str, label: str) -> xr.Dataset:
    """What the pilot closed of a case, with all effects."""
    closed = read_netcdf(path)
    return closed.isel(realization=(closed.case == label).values)


def repeated_by(output: Path, label: str) -> str:
    """The command that does a realisation of a case again, but for its number."""
    pool = "--pool " if output.parent.name == "pool" else ""
    return f"jointclosure repeat {pool}{output.parents[1]} {label}"


if __name__ == "__main__":
    with job(snakemake) as logbook:
        pilot = tuple(snakemake.input.get(name) or None for name in ("effects", "before"))
        settings = from_plain(ClosureSettings, snakemake.params.settings)
        main(snakemake.input.surfaces, pilot, settings, snakemake.output[0], logbook)

"""Close all surface pairs of a case, or of a block of its realisations."""

import json
from pathlib import Path

import xarray as xr

from jointclosure.engine.joints import close_surfaces, rows_by_seed
from jointclosure.engine.progress import Countdown
from jointclosure.engine.settings import ClosureSettings, as_text, check_settings
from jointclosure.inputs.plain import from_plain
from jointclosure.parameters import Effects, scene_name
from jointclosure.storage.netcdf import read_netcdf, reading_netcdf, write_netcdf_blocks
from jointclosure.storage.text import read_text
from studies.frame.jobs.job import job
from studies.frame.jobs.logbook import Logbook


def main(
    surfaces: str,
    pilot: tuple[str | None, str | None],
    settings: ClosureSettings,
    output: str,
    log: Logbook,
) -> None:
    """Write the closures (realization, cycle, branch, stress).

    ``pilot``: files of the effects that it chose, and of the joints that it closed with them.
    """
    chosen, before = pilot
    used = settings if chosen is None else settings.with_effects(chosen_effects(chosen))
    log(f"settings: {as_text(used)}")
    scene, label = scene_name(used.case.effects), used.case.label
    with reading_netcdf(surfaces) as pairs:
        check_settings(surfaces, pairs.attrs, settings.surfaces)
        countdown = Countdown(label, pairs.sizes["realization"])
        closed = close_surfaces(
            pairs,
            used,
            report=lambda line: log(f"{line}; {countdown()}"),
            repeated_by=repeated_by(Path(output), label),
            known=rows_by_seed(closed_by_pilot(before, label)) if before else {},
        )
        marked = (block.assign_attrs(settings=as_text(settings), scene=scene) for block in closed)
        write_netcdf_blocks(marked, "realization", output)
    log(f"wrote {output}")


def chosen_effects(path: str) -> Effects:
    """Return the effects that the pilot of the case's rock chose."""
    return Effects(**json.loads(read_text(path))["effects"])


def closed_by_pilot(path: str, label: str) -> xr.Dataset:
    """Return the joints of a case that the pilot closed with the selected effects."""
    closed = read_netcdf(path)
    return closed.isel(realization=(closed.case == label).values)


def repeated_by(output: Path, label: str) -> str:
    """Return the command that repeats a realisation of a case, without its number."""
    pool = "--pool " if output.parent.name == "pool" else ""
    return f"python -m studies repeat {pool}{output.parents[1]} {label}"


if __name__ == "__main__":
    with job(snakemake) as logbook:
        pilot = tuple(snakemake.input.get(name) or None for name in ("effects", "before"))
        settings = from_plain(ClosureSettings, snakemake.params.settings)
        main(snakemake.input.surfaces, pilot, settings, snakemake.output[0], logbook)

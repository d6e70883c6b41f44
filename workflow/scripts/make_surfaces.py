"""Generate the surface pairs of a case, or of a block of its realisations."""

from jointclosure.engine.settings import SurfaceSettings, as_text
from jointclosure.engine.surfaces import surfaces_of
from jointclosure.inputs.plain import from_plain
from jointclosure.storage.netcdf import write_netcdf_blocks
from studies.frame.jobs.job import job
from studies.frame.jobs.logbook import Logbook


def main(settings: SurfaceSettings, output: str, log: Logbook) -> None:
    """Write walls (realization, y, x)."""
    log(f"settings: {as_text(settings)}")
    surfaces = surfaces_of(settings)
    marked = (pair.assign_attrs(settings=as_text(settings)) for pair in surfaces)
    write_netcdf_blocks(marked, "realization", output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        settings = from_plain(SurfaceSettings, snakemake.params.settings)
        main(settings, snakemake.output[0], logbook)

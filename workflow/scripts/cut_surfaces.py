"""Cut the surface pairs of a case, or of a block of its realisations, out of scanned walls."""

from jointclosure.engine.settings import SurfaceSettings, as_text
from jointclosure.engine.surfaces import seeds_of
from jointclosure.inputs.plain import from_plain
from jointclosure.storage.netcdf import read_netcdf, write_netcdf_blocks
from studies.frame.ensemble.measured_walls import cut_surfaces, cutter_for
from studies.frame.jobs.job import job
from studies.frame.jobs.logbook import Logbook


def main(walls: str, settings: SurfaceSettings, output: str, log: Logbook) -> None:
    """Write walls (realization, y, x)."""
    log(f"settings: {as_text(settings)}")
    cutter = cutter_for(read_netcdf(walls), settings)
    surfaces = cut_surfaces(cutter, seeds_of(settings), settings.first_realization)
    marked = (pair.assign_attrs(settings=as_text(settings)) for pair in surfaces)
    write_netcdf_blocks(marked, "realization", output)
    log(f"wrote {output}: of {len(cutter.windows)} windows of {cutter.shape} cells")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        settings = from_plain(SurfaceSettings, snakemake.params.settings)
        main(snakemake.input[0], settings, snakemake.output[0], logbook)

"""Close all surface pairs of a case, or of a block of its realisations."""

from pathlib import Path

from jointclosure.dataset import reading_netcdf, write_netcdf_blocks
from jointclosure.logbook import Logbook, logging_to
from jointclosure.study.cases import Case
from jointclosure.study.ensemble import close_surfaces, closing_arguments
from jointclosure.study.settings import as_text, check_settings


def main(surfaces: str, settings: dict, output: str, log: Logbook) -> None:
    """Write the closures (realization, cycle, branch, stress)."""
    log(f"settings: {as_text(settings)}")
    case = Case(**settings["case"])
    with reading_netcdf(surfaces) as pairs:
        check_settings(surfaces, pairs.attrs, settings["surfaces"])
        closed = close_surfaces(
            pairs,
            case,
            **closing_arguments(settings),
            report=log,
            repeated_by=f"jointclosure repeat {Path(output).parents[1]} {case.label}",
        )
        marked = (block.assign_attrs(settings=as_text(settings)) for block in closed)
        write_netcdf_blocks(marked, "realization", output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(snakemake.input.surfaces, snakemake.params.settings, snakemake.output[0], logbook)

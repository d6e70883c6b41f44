"""Close all surface pairs of a case."""

import numpy as np

from jointclosure import Choices, Effects, Numerics
from jointclosure.dataset import reading_netcdf, write_netcdf_blocks
from jointclosure.logbook import Logbook, logging_to
from jointclosure.parameters import to_si
from jointclosure.study.cases import Case
from jointclosure.study.ensemble import close_surfaces


def main(surfaces: str, settings: dict, output: str, log: Logbook) -> None:
    """Write the closures (realization, cycle, branch, stress) of a case."""
    case = Case(**settings["case"])
    log(f"{case.label}: {case}")
    stresses = np.linspace(0.0, 1e6 * settings["largest_stress_MPa"], settings["stress_points"])
    with reading_netcdf(surfaces) as pairs:
        closed = close_surfaces(
            pairs,
            case,
            cycles=settings["cycles"],
            seating_stress=1e6 * settings["seating_stress_MPa"],
            effects=Effects(**settings["effects"]),
            choices=Choices(**to_si(settings["choices"])),
            numerics=Numerics(**to_si(settings["numerics"])),
            stresses=stresses,
            report=log,
        )
        write_netcdf_blocks(closed, "realization", output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(snakemake.input.surfaces, dict(snakemake.params), snakemake.output[0], logbook)

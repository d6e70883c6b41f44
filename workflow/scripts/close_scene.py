"""Close the surfaces of a rock in one scene, at all conditions."""

from jointclosure.logbook import Logbook, logging_to
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.studies.effects.ablation import SCENES, close_scene


def main(configuration: dict, rock: str, scene: str, output: str, log: Logbook) -> None:
    """Write closures and times (jrc, stress, realization, cycle)."""
    write_netcdf(close_scene(configuration, rock, SCENES[scene], log), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(
            snakemake.params.configuration,
            snakemake.wildcards.rock,
            snakemake.wildcards.scene,
            snakemake.output[0],
            logbook,
        )

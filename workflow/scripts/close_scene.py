"""Close the surfaces of a rock in one scene, at all conditions."""

from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.studies.effects.ablation import SCENES, close_scene


def main(configuration: dict, rock: str, scene: str, output: str, log: Logbook) -> None:
    """Write closures and times (jrc, stress, realization, cycle)."""
    write_netcdf(close_scene(configuration, rock, SCENES[scene], log), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            snakemake.params.configuration,
            snakemake.wildcards.rock,
            snakemake.wildcards.scene,
            snakemake.output[0],
            logbook,
        )

"""Close the surfaces of a rock in one scene, at all conditions."""

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import Ablation
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.studies.effects.ablation import SCENES, close_scene


def main(
    conditions: list[ClosureSettings], design: Ablation, scene: str, output: str, log: Logbook
) -> None:
    """Write closures and times (jrc, stress, realization, cycle)."""
    write_netcdf(close_scene(conditions, design, SCENES[scene], log), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            from_plain(list[ClosureSettings], snakemake.params.conditions),
            from_plain(Ablation, snakemake.params.design),
            snakemake.wildcards.scene,
            snakemake.output[0],
            logbook,
        )

"""Compile every kernel that the study needs, before the cases fan out.

Two processes that fill a cold cache at once can swap each other's code.
"""

from jointclosure import Choices, Effects, Numerics, Rock, simulate, wall_pair
from jointclosure.compilation import cache_folder
from jointclosure.dataset import write_text
from jointclosure.logbook import Logbook, logging_to
from jointclosure.parameters import to_si


def main(effects: dict, choices: dict, solver: str, output: str, log: Logbook) -> None:
    """Close a small joint in the study's scene, which compiles what it needs."""
    log(f"kernels are kept in {cache_folder()}")
    walls = wall_pair(8.0, (24, 24), 0.25e-3, seed=1)
    simulate(
        *walls,
        spacing=0.25e-3,
        rock=Rock(78e9, 0.2, 165e6),
        max_normal_stress=1e6,
        effects=Effects(**effects),
        choices=Choices(**to_si(choices)),
        numerics=Numerics(solver=solver),
    )
    log("compiled")
    write_text(f"kernels compiled for {cache_folder().name}\n", output)


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(
            snakemake.params.effects,
            snakemake.params.choices,
            snakemake.params.solver,
            snakemake.output[0],
            logbook,
        )

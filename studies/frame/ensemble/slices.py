"""Parts of a configuration that the files of a case depend on."""

from jointclosure.engine.settings import Case, ClosureSettings, SurfaceSettings, Walls
from jointclosure.walls.scans import file_digest
from studies.frame.config.model import Configuration
from studies.frame.config.rocks import wall_files
from studies.frame.ensemble.cases import wall_name


def closed_keys(keys: dict) -> dict:
    """Return the keys of a configuration that may change closures: no others are in their file."""
    output = {key: value for key, value in keys["output"].items() if key != "wall_strength_ratio"}
    return {key: value for key, value in keys.items() if key != "statistics"} | {"output": output}


def surface_settings(configuration: Configuration, case: Case, block: range) -> SurfaceSettings:
    """Settings of the surface pairs of a case that closes its own: its ``surface`` is its label."""
    walls = configuration.rocks[case.rock].walls
    return SurfaceSettings(
        jrc=case.jrc,
        walls=walls,
        sha256=wall_digests(walls) if walls else {},
        root_seed=configuration.study.root_seed,
        seeds_named_by=tuple(wall_name(configuration.study, case)),
        first_realization=block.start,
        realizations=len(block),
        grid=configuration.grid,
        surface=configuration.surface,
    )


def wall_digests(walls: Walls) -> dict[str, str]:
    """SHA-256 of the files of scanned walls, which depends on their content only."""
    return {side: file_digest(file) for side, file in wall_files(walls).items()}


def block_settings(
    configuration: Configuration, cases: dict[str, Case], label: str, block: range
) -> ClosureSettings:
    """Settings of the closures of a case and a block of realisations."""
    case = cases[label]
    return ClosureSettings(
        case=case,
        surfaces=surface_settings(configuration, cases[case.surface], block),
        cycles=configuration.study.cycles,
        seating_stress=configuration.seating_stress,
        choices=configuration.choices,
        numerics=configuration.numerics,
        stress_points=configuration.output.stress_points,
        largest_stress=configuration.output.largest_stress,
        effects_chosen_to=configuration.effects_chosen_to,
        flow=configuration.flow,
    )

"""Parts of a configuration that the files of a case depend on."""

from jointclosure.engine.settings import Case, ClosureSettings, SurfaceSettings, Walls
from jointclosure.walls.scans import file_digest
from studies.frame.config.typed import Configuration
from studies.frame.config.walls import wall_files
from studies.frame.ensemble.cases import wall_name


def closed_keys(keys: dict) -> dict:
    """Return the keys of a configuration that may change closures: no others are in their file."""
    output = {key: value for key, value in keys["output"].items() if key != "wall_strength_ratio"}
    return {key: value for key, value in keys.items() if key != "statistics"} | {"output": output}


def surface_settings(
    configuration: Configuration, case: Case, block: range, code: str = ""
) -> SurfaceSettings:
    """Settings of the surface pairs of a case.

    Parameters
    ----------
    configuration : Configuration
    case : Case
        A case that closes its own surfaces: its ``surface`` is its label.
    block : range
        Realisations, see `studies.frame.ensemble.cases.blocks_of`.
    code : str
        Digest of the sources that make surfaces, for surfaces that are stored in a file.
    """
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
        code=code,
    )


def wall_digests(walls: Walls) -> dict[str, str]:
    """SHA-256 of the files of scanned walls, which depends on their content only."""
    return {side: file_digest(file) for side, file in wall_files(walls).items()}


def closure_settings(
    configuration: Configuration, case: Case, surfaces: SurfaceSettings, code: str = ""
) -> ClosureSettings:
    """Settings of the closures of a case.

    Parameters
    ----------
    configuration : Configuration
    case : Case
    surfaces : SurfaceSettings
        Settings of the surface pairs that are closed.
    code : str
        Digest of the sources that close them, for closures that are stored in a file.
    """
    return ClosureSettings(
        case=case,
        surfaces=surfaces,
        cycles=configuration.study.cycles,
        seating_stress=configuration.seating_stress,
        choices=configuration.choices,
        numerics=configuration.numerics,
        stress_points=configuration.output.stress_points,
        largest_stress=configuration.output.largest_stress,
        effects_chosen_to=configuration.effects_chosen_to,
        flow=configuration.flow,
        code=code,
    )


def block_settings(
    configuration: Configuration,
    cases: dict[str, Case],
    label: str,
    block: range,
    surface_code: str = "",
    solver_code: str = "",
) -> ClosureSettings:
    """Return `closure_settings` of a case and a block, with those of its surfaces."""
    case = cases[label]
    surfaces = surface_settings(configuration, cases[case.surface], block, surface_code)
    return closure_settings(configuration, case, surfaces, solver_code)

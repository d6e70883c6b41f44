"""Cases of a study: every rock with its base values, and with one parameter changed.

The label of a case is used only to name files and is never parsed: rock, parameter, level and value
are fields of `Case`, and coordinates of every dataset.
"""

from collections.abc import Mapping

from jointclosure.assessment.numerical_settings import FINEST
from jointclosure.joint.conditions import Conditions
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.two_level import FEWEST_DIFFERENCES
from jointclosure.uncertainty.expected_cost import relative_cost
from jointclosure.walls.scans import file_digest
from studies.frame.configuration import Configuration
from studies.frame.keys import Study
from studies.frame.rocks import ScannedWalls, wall_files
from studies.frame.settings import (
    BASE,
    Case,
    ClosureSettings,
    JointGrid,
    Synthesis,
    surface_settings,
)

BLOCK = 10
"""Realisations in a block of a requested accuracy with the numerics of the study."""
FEW = 4
"""Realisations in a block of a requested accuracy with the finest numerics."""
JOB_SECONDS = 300.0
"""Approximate processor time [s] of a job that simulates joints."""


def level_names(levels: tuple[float, ...], base: float) -> list[str]:
    """Return the names of ascending levels.

    Three levels around the base are low, base and high. Otherwise level i of k (from 1) is level_i,
    except for the base.
    """
    if len(levels) == 3 and levels[1] == base:
        return ["low", BASE, "high"]
    return [BASE if level == base else f"level_{i + 1}" for i, level in enumerate(levels)]


def base_case(study: Configuration, name: str) -> Case:
    """Return the case of a rock with its base values."""
    rock = study.rocks[name]
    conditions = Conditions(
        study.grid.spacing, rock.intact, rock.max_normal_stress, study.study.cycles,
        study.seating_stress, rock.effects, study.choices, study.numerics, study.flow,
    )  # fmt: skip
    return Case(f"{name}-{BASE}", name, BASE, BASE, float("nan"), rock.jrc, conditions)


def cases_of(study: Configuration) -> list[Case]:
    """Return all cases by rock in the order of the study, with the base case of each rock first."""
    cases = []
    for name, rock in study.rocks.items():
        cases.append(base := base_case(study, name))
        for parameter in (name for name in PROPERTIES if name in rock.levels):
            levels = rock.levels[parameter]
            named = zip(level_names(levels, base.number(parameter)), levels, strict=True)
            for level, value in named:
                if level != BASE:
                    label = f"{name}-{parameter}-{level}"
                    case = base.changed(parameter, value)._replace(label=label, value=value)
                    cases.append(case._replace(parameter=parameter, level=level))
    return cases


def pool_of(whole: Configuration) -> Configuration:
    """Return the configuration of the pool: all cases of a study on the same further surfaces."""
    study = whole.study
    return whole._replace(
        study=study._replace(
            realizations=study.pool or study.realizations,
            draws="common",
            surfaces_of=f"{study.surfaces_of or study.name} pool",  # cannot be a study's name
            pool=None,
            accuracy=None,
        )
    )


def ensembles_of(whole: Configuration) -> dict[str, Configuration]:
    """Return the configurations of a study's ensembles by name, which is that of their folder.

    ``cases`` is the study itself. ``finest`` is added for a requested accuracy: at most
    `FEWEST_DIFFERENCES` realisations with the finest numerics, without flow, and with all effects
    that are stated, none of which `effects.auto` leaves out. ``pool`` is added for a study with a
    pool.
    """
    study = whole.study
    ensembles = {"cases": whole}
    if study.accuracy:
        count = min(FEWEST_DIFFERENCES, study.realizations)
        few = {"realizations": count, "realizations_per_job": None, "pool": None, "accuracy": None}
        ensembles["finest"] = whole._replace(
            study=study._replace(**few),
            numerics=FINEST,
            effects=whole.effects._replace(auto=None),
            flow=False,
        )
    return ensembles | ({"pool": pool_of(whole)} if study.pool is not None else {})


def dataset_of(ensemble: str) -> str:
    """Return the name of the file of an ensemble's dataset in the folder of the study."""
    return "study.nc" if ensemble == "cases" else f"{ensemble}.nc"


def wall_name(study: Study, case: Case) -> tuple[str, ...]:
    """Return the name from which, with a realisation's number, the seed of its walls derives."""
    name = study.surfaces_of or study.name, case.rock
    return (*name, case.parameter, case.level) if study.draws == "independent" else name


def blocks_of(whole: Configuration, realizations: int | None = None) -> list[range]:
    """Split the realisations of every case into blocks, one for each job.

    Blocks have ``study.realizations_per_job`` realisations. If this is null, they take about
    `JOB_SECONDS`. For a requested accuracy, which gives a growing number of ``realizations``, they
    then have `BLOCK` realisations (`FEW` with the finest numerics): complete blocks do not change.
    """
    study = whole.study
    last = realizations or study.realizations
    step = study.realizations_per_job
    if step is None and realizations is not None:
        step = FEW if whole.numerics == FINEST else BLOCK
    if step is None:
        step = max(1, round(JOB_SECONDS / expected_seconds(whole)))
    return [range(first, min(first + step, last)) for first in range(0, last, step)]


def expected_seconds(whole: Configuration) -> float:
    """Return roughly the processor time [s] of a joint of the rock whose effects cost most.

    Realisations are split over jobs by this time. An error by a factor of three changes only the
    length of the jobs.
    """
    scenes = (rock.effects for rock in whole.rocks.values())
    return seconds_by_paper(whole) * max(relative_cost(one, whole.numerics) for one in scenes)


def seconds_by_paper(whole: Configuration) -> float:
    """Return roughly the processor time [s] of a joint by the paper's steps with all effects.

    Joints of 100 x 100 cells take about half a second (docs/accuracy.md).
    """
    cells = whole.grid.cells_x * whole.grid.cells_y
    return 0.25 * whole.study.cycles * (cells / 1e4) ** 1.5


def closed_keys(keys: dict) -> dict:
    """Return the keys on which closures may depend; only these are stored with the closures."""
    without = {"output": "wall_strength_ratio", "study": "accuracy"}
    parts = {part: {k: v for k, v in keys[part].items() if k != no} for part, no in without.items()}
    # the title of a rock changes no closure, and rocks that the study has not change nothing
    studied = keys["study"]["rocks"]
    parts["rocks"] = {name: keys["rocks"][name] | {"title": name} for name in studied}
    others = ("statistics", "assessment")
    return {key: value for key, value in keys.items() if key not in others} | parts


def wall_digests(walls: ScannedWalls) -> dict[str, str]:
    """Return the SHA-256 of the content of the files of scanned walls, by side."""
    return {side: file_digest(file) for side, file in wall_files(walls).items()}


def joint_grid(study: Configuration) -> JointGrid:
    """Return the grid of a study's joints."""
    return JointGrid(*(getattr(study.grid, name) for name in JointGrid._fields))


def synthesis(study: Configuration) -> Synthesis:
    """Return how a study makes walls from a JRC."""
    return Synthesis(*(getattr(study.surface, name) for name in Synthesis._fields))


def block_settings(study: Configuration, case: Case, block: range) -> ClosureSettings:
    """Return the settings of the joints of a case and a block of realisations."""
    walls = study.rocks[case.rock].walls
    return ClosureSettings(
        case=case,
        walls=walls,
        sha256=wall_digests(walls) if walls else {},
        root_seed=study.study.root_seed,
        seeds_named_by=wall_name(study.study, case),
        first_realization=block.start,
        realizations=len(block),
        grid=joint_grid(study),
        surface=synthesis(study),
        stress_points=study.output.stress_points,
        largest_stress=study.output.largest_stress,
        effects_chosen_to=study.effects.auto,
    )


def first_with_surfaces(whole: Configuration, cases: Mapping[str, Case]) -> dict[str, str]:
    """Return for each label of a case the label of the first case with the same surfaces."""
    first: dict[str, str] = {}
    return {
        label: first.setdefault(
            repr(surface_settings(block_settings(whole, case, range(1)))), label
        )
        for label, case in cases.items()
    }

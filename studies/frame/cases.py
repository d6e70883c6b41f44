"""Which cases, blocks of realisations and ensembles a study has, and the settings of their joints.

A study has each rock with its base values, and with one parameter changed. The class `Case` is in
`settings.py`, as settings of joints contain it. The label of a case only names files and is never
parsed: rock, parameter, level and value are fields of `Case`, and coordinates of every dataset.
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
"""Realisations in a block of a study with a requested accuracy."""
FEW = 4
"""Realisations in a block of the ensemble with the finest numerics of such a study."""
JOB_SECONDS = 300.0
"""Approximate processor time [s] of a job that simulates joints."""


def level_names(levels: tuple[float, ...], base: float) -> list[str]:
    """Return the names of the ascending levels of a parameter.

    Three levels with the rock's own value ``base`` in the middle are "low", "base" and "high".
    Otherwise the rock's own value is "base", and others are "level_1", "level_2" and so on by their
    place among all levels.
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
    """Return all cases of a study, rock by rock in its order; the base case of a rock is first."""
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
    """Return the configuration of a study's pool: its cases, all on the same further surfaces.

    It has ``study.pool`` realisations. The pool has neither a pool nor a requested accuracy.
    """
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

    "cases" is the study itself. "finest" is there if an accuracy is requested: it has at most
    `FEWEST_DIFFERENCES` realisations with the finest numerics, without flow, and with all stated
    effects, also those that `effects.auto` would leave out. "pool" is there if the study has one.
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
    """Return the name of the file of an ensemble's dataset in the study's folder of results."""
    return "study.nc" if ensemble == "cases" else f"{ensemble}.nc"


def wall_name(study: Study, case: Case) -> tuple[str, ...]:
    """Return the name of a case's walls; seeds derive from it and the realisations' numbers.

    With common draws it names only the study (or the one whose surfaces are used) and the rock, so
    that all cases of a rock have the same random numbers. With independent draws it names the case.
    """
    name = study.surfaces_of or study.name, case.rock
    return (*name, case.parameter, case.level) if study.draws == "independent" else name


def blocks_of(whole: Configuration, realizations: int | None = None) -> list[range]:
    """Return the blocks into which the realisations of every case are split, one for each job.

    Blocks have ``study.realizations_per_job`` realisations, the last one maybe fewer. If this is
    null, a block takes about `JOB_SECONDS`. ``realizations`` are those reached so far of a study
    with a requested accuracy, in which their number grows. If ``realizations_per_job`` is null,
    blocks then have `BLOCK` realisations (`FEW` with the finest numerics), so that complete blocks
    never change.
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
    """Return roughly the processor time [s] of a joint of that rock whose effects take longest.

    The number of realisations in a job is chosen by this time. If it is wrong by a factor of three,
    only the duration of jobs changes.
    """
    scenes = (rock.effects for rock in whole.rocks.values())
    return seconds_by_paper(whole) * max(relative_cost(one, whole.numerics) for one in scenes)


def seconds_by_paper(whole: Configuration) -> float:
    """Return roughly the processor time [s] of a joint by the paper's steps with all effects.

    A joint of 100 x 100 cells takes a quarter of a second for each cycle (docs/accuracy.md).
    """
    cells = whole.grid.cells_x * whole.grid.cells_y
    return 0.25 * whole.study.cycles * (cells / 1e4) ** 1.5


def closed_keys(keys: dict) -> dict:
    """Return the part of the keys of a configuration on which closures may depend.

    Only this part is stored with the closures. Titles of rocks are replaced by their names.
    """
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
    """Return for each case, by label, the label of the first case that has the same surfaces."""
    first: dict[str, str] = {}
    return {
        label: first.setdefault(
            repr(surface_settings(block_settings(whole, case, range(1)))), label
        )
        for label, case in cases.items()
    }

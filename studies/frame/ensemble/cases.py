"""Cases of a study: every rock with its base values, and with one parameter changed.

The label of a case is used only to name files and is never parsed: rock, parameter, level and value
are fields of `Case`, and coordinates of every dataset.
"""

from jointclosure.engine.settings import BASE, Case
from jointclosure.parameters import PROPERTIES
from studies.frame.config.model import Configuration
from studies.frame.config.rocks import StudyRock
from studies.frame.config.sections import Study


def level_names(levels: tuple[float, ...], base: float) -> list[str]:
    """Return names of ascending levels: low, base, high, or level_1 to level_k and base."""
    if len(levels) == 3 and levels[1] == base:
        return ["low", BASE, "high"]
    return [BASE if level == base else f"level_{i + 1}" for i, level in enumerate(levels)]


def base_case(name: str, rock: StudyRock) -> Case:
    """Return the case of a rock with its base values."""
    label = f"{name}-{BASE}"
    return Case(
        label,
        name,
        BASE,
        BASE,
        float("nan"),
        rock.intact,
        rock.jrc,
        rock.max_normal_stress,
        rock.effects,
        surface=label,
    )


def cases_of(configuration: Configuration) -> list[Case]:
    """Return all cases by rock in the order of the study, with the base case of each rock first."""
    common = configuration.study.draws == "common"
    cases = []
    for name, rock in configuration.rocks.items():
        base = base_case(name, rock)
        cases.append(base)
        for parameter in (name for name in PROPERTIES if name in rock.levels):
            levels = rock.levels[parameter]
            named = zip(level_names(levels, base.property(parameter)), levels, strict=True)
            for level, value in named:
                if level == BASE:
                    continue
                label = f"{name}-{parameter}-{level}"
                shared = common and parameter != "jrc"
                cases.append(
                    base.changed(parameter, value)._replace(
                        label=label,
                        parameter=parameter,
                        level=level,
                        value=value,
                        surface=base.label if shared else label,
                    )
                )
    return cases


def pool_of(configuration: Configuration) -> Configuration:
    """Return the configuration of a study's pool: all its cases closed on common surfaces.

    The surfaces differ from those of any study. They are named by the study, and their number is
    ``study.pool`` (null: the number of realisations of the study). The blocks of its jobs are as
    large as those of the study.
    """
    study = configuration.study
    return configuration._replace(
        study=study._replace(
            realizations=study.pool or study.realizations,
            realizations_per_job=study.realizations_per_job or study.realizations,
            draws="common",
            surfaces_of=f"{study.surfaces_of or study.name} pool",  # cannot be a study's name
            pool=None,
        )
    )


def ensembles_of(configuration: Configuration) -> dict[str, Configuration]:
    """Return the ensembles of a study by folder of their files: "cases", and "pool" if any."""
    ensembles = {"cases": configuration}
    if configuration.study.pool is not None:
        ensembles["pool"] = pool_of(configuration)
    return ensembles


def wall_name(study: Study, case: Case) -> list[str]:
    """Return the name from which the seeds of a case's surface pairs derive, without realisation.

    It never contains an index of cases, so that adding, removing or reordering cases changes no
    surface.
    """
    name = [study.surfaces_of or study.name, case.rock]
    if study.draws == "independent":
        name += [case.parameter, case.level]
    return name


def blocks_of(study: Study) -> list[range]:
    """Split the realisations of every case into the blocks of jobs."""
    last, step = study.realizations, study.realizations_per_job or study.realizations
    return [range(first, min(first + step, last)) for first in range(0, last, step)]

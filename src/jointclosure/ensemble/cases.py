"""The cases of a study: every rock at its base, and with one parameter changed.

A case's label names files only. It is never taken apart: rock, parameter,
level and value are fields of `Case`, and coordinates of every dataset.
"""

from jointclosure.config.typed import Configuration, Study, StudyRock
from jointclosure.ensemble.settings import Case
from jointclosure.parameters import PROPERTIES

BASE = "base"
"""Parameter and level of a case in which none is changed."""


def level_names(levels: tuple[float, ...], base: float) -> list[str]:
    """Names of ascending levels: low, base, high, or level_1 to level_k and base."""
    if len(levels) == 3 and levels[1] == base:
        return ["low", BASE, "high"]
    return [BASE if level == base else f"level_{i + 1}" for i, level in enumerate(levels)]


def base_case(name: str, rock: StudyRock) -> Case:
    """The case of a rock as it is."""
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
    """All cases, by rock in the study's order, the base case of each first."""
    common = configuration.study.draws == "common"
    cases = []
    for name, rock in configuration.rocks.items():
        base = base_case(name, rock)
        cases.append(base)
        for parameter in (each for each in PROPERTIES if each in rock.levels):
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
    """The configuration of a study's pool: all its cases closed on common surfaces.

    They are other surfaces than any study's, named by it, and as many as ``study.pool``
    says (null: as many as the study's own). The blocks of its jobs are as large as those of
    the study.
    """
    study = configuration.study
    return configuration._replace(
        study=study._replace(
            realizations=study.pool or study.realizations,
            realizations_per_job=study.realizations_per_job or study.realizations,
            draws="common",
            surfaces_of=f"{study.surfaces_of or study.name} pool",  # no name of a study
            pool=None,
        )
    )


def ensembles_of(configuration: Configuration) -> dict[str, Configuration]:
    """What a study closes, by the folder of its files: its "cases", and a "pool" if it has one."""
    ensembles = {"cases": configuration}
    if configuration.study.pool is not None:
        ensembles["pool"] = pool_of(configuration)
    return ensembles


def wall_name(study: Study, case: Case) -> list[str]:
    """What the seeds of a case's surface pairs are named by, but for the realisation.

    Never an index of cases: adding, dropping or reordering them changes no surface.
    """
    name = [study.surfaces_of or study.name, case.rock]
    if study.draws == "independent":
        name += [case.parameter, case.level]
    return name


def blocks_of(study: Study) -> list[range]:
    """The realisations of every case, split over jobs."""
    last, step = study.realizations, study.realizations_per_job or study.realizations
    return [range(first, min(first + step, last)) for first in range(0, last, step)]

"""Assessment of a study's rocks: the variants of `jointclosure.assess` at each condition."""

import itertools
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

import pandas as pd

from jointclosure.engine.assess import COPIES, READ, assessed, variants_of, worst_first
from jointclosure.engine.ensembles import Point
from jointclosure.engine.settings import Case, ClosureSettings, Walls, walls_of
from studies.assessment import figures
from studies.assessment.figures import condition
from studies.assessment.section import Assessment
from studies.frame.cases import base_case
from studies.frame.configuration import Configuration, Configured
from studies.frame.experiments import Design, Experiment, Tables, settings_of
from studies.frame.summary import grouped
from studies.frame.walls import cut_walls, walls_of_files

_CONDITION = ("rock", "jrc", "stress_MPa")
_VALUES = ["value", "low", "high"]


def assessment_design(configured: Configured) -> Design:
    """Make a job for each condition and variant; copies are closed by the variant as stated."""
    configuration = configured.typed
    section, jobs, ladders = configuration.section(Assessment), {}, {}
    for number, case in enumerate(_conditions(configuration, section)):
        settings = settings_of(configuration, case)
        count = section.joints
        if settings.surfaces.walls:  # a scan has room for a number of joints
            count = min(count, configuration.study.realizations)
        surfaces = settings.surfaces._replace(realizations=count)
        settings = settings._replace(surfaces=surfaces)
        stated, ladder, variants = variants_of(settings.conditions())
        ladders[case.rock] = stated, ladder
        options = {"unusual_values": configuration.study.unusual_values == "allow"}
        for name, conditions in variants.items():
            varied = settings._replace(numerics=conditions.numerics)
            varied = varied.with_effects(conditions.effects)
            at = {"rock": case.rock, "jrc": case.jrc, "stress": case.max_normal_stress}
            jobs[f"{case.rock}.{number}.{name.replace(' ', '_').replace(chr(39), '')}"] = [
                Point(
                    at | {"variant": name, "copy_of_walls": copy},
                    varied,
                    f"{__name__}:copies",
                    options | {"copy": copy},
                )
                for copy in (COPIES if name == stated else ["as it is"])
            ]
    names = ("assessment_price", "assessment_effects", "assessment_hardness")
    parameters = {"ladders": ladders, "within": section.within}
    return Design(jobs, ("assessment", "hardness", "assessment.md"), names, parameters)


def _conditions(configuration: Configuration, section: Assessment) -> Iterator[Case]:
    """Generate the base case of each rock at each roughness and stress."""
    for name, rock in configuration.rocks.items():
        base = base_case(name, rock)
        roughnesses = (not rock.walls and section.jrc) or (base.jrc,)
        for jrc, stress in itertools.product(
            roughnesses, section.stress or (base.max_normal_stress,)
        ):
            yield base._replace(jrc=jrc, max_normal_stress=stress)


def copies(settings: ClosureSettings, copy: str, unusual_values: bool) -> Iterator[Walls]:
    """Generate copies (`COPIES`) of the walls of a block, made or cut out of scans."""
    surfaces = settings.surfaces
    if surfaces.walls:
        about = surfaces.grid.spacing, surfaces.surface.jrc_relation, unusual_values
        pairs = cut_walls(_scanned(surfaces.walls, *about), surfaces)
    else:
        pairs = walls_of(surfaces)
    for upper, lower in pairs:
        yield COPIES[copy](upper), COPIES[copy](lower)


_scanned = lru_cache(maxsize=1)(walls_of_files)


def assessment_tables(joints: pd.DataFrame, parameters: Mapping[str, Any]) -> Tables:
    """Return differences of variants, the hardness of each joint, and sentences."""
    closures = joints.rename(columns={"realization": "joint"}).assign(error="")
    differences, hardness, lines = [], [], ["# Assessment", ""]
    for at, part in grouped(closures, "rock", "jrc", "stress"):
        stated, ladder = parameters["ladders"][at["rock"]]
        found = assessed(part, ladder, stated, parameters["within"], None)
        percent = (100.0 * found.differences[_VALUES]).add_suffix("_percent")
        verdicts = {name: found.verdict(name) for name in found.effects.index}
        table = found.differences.drop(columns=_VALUES).join(percent)
        differences.append(table.assign(**at, verdict=table.variant.map(verdicts).fillna("")))
        hardness.append(found.hardness.assign(**at))
        title = condition(**at)
        lines += [f"## {title}", ""]
        for table in (found.price, found.effects):
            rows = table.rename_axis("variant").reset_index()
            cells = [rows.columns, ["---"] * rows.shape[1], *rows.to_numpy()]
            lines += [f"| {' | '.join(map(str, row))} |" for row in cells] + [""]
        lines += [*(f"- {line}" for line in found.sentences), ""]
    return {
        "assessment": _first(differences, *_CONDITION, "variant", "reference"),
        "hardness": worst_first(_first(hardness, *_CONDITION)),
        "assessment.md": "\n".join(lines),
    }


def _first(tables: list[pd.DataFrame], *names: str) -> pd.DataFrame:
    table = pd.concat(tables)
    return table[[*names, *(name for name in table if name not in names)]]


def _draw(name: str, tables: Tables, parameters: Mapping[str, Any]) -> Any:
    if name == "assessment_hardness":
        return figures.hardness_panels(tables["hardness"], parameters["within"])
    draw = figures.price_panels if name == "assessment_price" else figures.effect_panels
    return draw(tables["assessment"], parameters["within"])


EXPERIMENT = Experiment(
    title="accuracy and its cost, hardness, and effects that are needed",
    quantities=tuple(name for name in READ if name not in ("status", "timing_simulation")),
    design=assessment_design,
    tabulate=assessment_tables,
    draw=_draw,
)

"""Assessment of a study's rocks: the variants of `jointclosure.assess` at each condition."""

import itertools
from collections.abc import Iterator, Mapping
from typing import Any

import pandas as pd

from jointclosure.engine.assess import variants_of
from jointclosure.engine.assessment import ASSESSED, assessed, hardness_of
from jointclosure.engine.points import Point
from jointclosure.engine.settings import Case, ClosureSettings
from jointclosure.engine.walls import COPIES
from studies.assessment import figures
from studies.assessment.section import Assessment
from studies.frame.cases import base_case
from studies.frame.configuration import Configuration, Configured
from studies.frame.experiments import Design, Experiment, Tables, settings_of
from studies.frame.summary import grouped

_CONDITION = ("rock", "jrc", "stress_MPa")
_VALUES = ["value", "low", "high"]


def assessment_design(configured: Configured) -> Design:
    """Make a job for each condition and variant; copies are closed by the variant as stated."""
    configuration = configured.typed
    section, jobs, ladders = configuration.section(Assessment), {}, {}
    for number, case in enumerate(_conditions(configuration, section)):
        settings = settings_of(configuration, case)
        surfaces = settings.surfaces._replace(realizations=section.joints)
        settings = settings._replace(surfaces=surfaces)
        stated, variants = variants_of(settings.conditions())
        ladder = [name for name in variants if not name.startswith("without ")]
        ladders[case.rock] = stated, ladder
        for name, conditions in variants.items():
            varied = settings._replace(numerics=conditions.numerics)
            jobs[f"{case.rock}.{number}.{name.replace(' ', '_').replace(chr(39), '')}"] = list(
                _points(varied.with_effects(conditions.effects), name, name == stated)
            )
    names = ("assessment_price", "assessment_effects", "assessment_hardness")
    parameters = {"ladders": ladders, "within": section.within}
    return Design(jobs, ("assessment", "hardness", "assessment.md"), names, parameters)


def _conditions(configuration: Configuration, section: Assessment) -> Iterator[Case]:
    """Generate the base case of each rock at each roughness and stress."""
    for name, rock in configuration.rocks.items():
        base = base_case(name, rock)
        roughnesses = section.jrc or (base.jrc,)
        for jrc, stress in itertools.product(
            roughnesses, section.stress or (base.max_normal_stress,)
        ):
            yield base._replace(jrc=jrc, max_normal_stress=stress)


def _points(settings: ClosureSettings, variant: str, stated: bool) -> Iterator[Point]:
    """Generate the points of a variant: its walls as they are, and copies if it is as stated."""
    case = settings.case
    at = {"rock": case.rock, "jrc": case.jrc, "stress": case.max_normal_stress}
    for copy in COPIES if stated else ["as it is"]:
        coordinates = at | {"variant": variant, "copy_of_walls": copy}
        yield Point(coordinates, settings, "copied", {"copy": copy})


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
        for joint, copies in part.groupby("joint"):
            judged = hardness_of(copies, stated, parameters["within"])
            spread = judged.pop("spread")
            judged["spread_percent"] = 100.0 * max(spread.values())
            hardness.append(at | {"joint": joint} | judged)
        title = f"{at['rock'].capitalize()}, JRC {at['jrc']:g}, {at['stress_MPa']:g} MPa"
        lines += [f"## {title}", ""]
        for table in (found.price, found.effects):
            rows = table.rename_axis("variant").reset_index()
            cells = [rows.columns, ["---"] * rows.shape[1], *rows.to_numpy()]
            lines += [f"| {' | '.join(map(str, row))} |" for row in cells] + [""]
        lines += [*(f"- {line}" for line in found.sentences), ""]
    order = pd.Categorical([row["verdict"] for row in hardness], ["not stable", "hard", "easy"])
    table = pd.DataFrame(hardness).assign(order=order)
    table = table.sort_values(["order", "spread_percent"], ascending=[True, False])
    return {
        "assessment": _first(pd.concat(differences), *_CONDITION, "variant", "reference"),
        "hardness": table.drop(columns="order"),
        "assessment.md": "\n".join(lines),
    }


def _first(table: pd.DataFrame, *names: str) -> pd.DataFrame:
    return table[[*names, *(name for name in table if name not in names)]]


def _draw(name: str, tables: Tables, parameters: Mapping[str, Any]) -> Any:
    if name == "assessment_hardness":
        return figures.hardness_figure(tables["hardness"], parameters["within"])
    draw = figures.price_panels if name == "assessment_price" else figures.effect_panels
    return draw(tables["assessment"], parameters["within"])


EXPERIMENT = Experiment(
    title="accuracy and its cost, hardness, and effects that are needed",
    quantities=(*ASSESSED, "unbreakable_share", "oracle_ratio"),
    design=assessment_design,
    tabulate=assessment_tables,
    draw=_draw,
)

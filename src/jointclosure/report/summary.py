"""The first screen of a study's page: the finding in a sentence, its numbers, its validity."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.claims.statements import TOLERANCE
from jointclosure.config.properties import PARAMETER_TITLES
from jointclosure.config.typed import Configuration
from jointclosure.ensemble.aggregation import succeeded
from jointclosure.report.sheets import Sheet, number_text, sheet
from jointclosure.statistics.ratios import harmonic_mean
from jointclosure.statistics.verdicts import (
    CANNOT_BE_TOLD,
    FALLS,
    NO_DIFFERENCE,
    STANDS,
    t_interval,
    verdict,
)

FIRST_PICTURES = ("fig_5_closure", "table_3_intervals")
"""Shown on the first screen, those of them that a study has."""


STAYS = "Of it since seating, net, stays (%)"


def summary_sheet(study: xr.Dataset, closures: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Tabulate closure, what stays of it and net normal stiffness of each rock as it is."""
    base = closures[closures.parameter == "base"]
    rows = []
    for rock, own in base.groupby("rock", sort=False):
        own = own.set_index("cycle")
        stays = own.residual_closure_seated_net_mean_mm[1] / own.max_closure_seated_net_mean_mm[1]
        row = {"rock": titles[rock], "stays": 100.0 * stays}
        for cycle in own.index:
            row[f"closure_{cycle}"] = own.max_closure_mean_mm[cycle]
            row[f"kn_{cycle}"] = 1e-9 * mean_stiffness(study, rock, cycle)
        rows.append(row)
    cycles = [int(cycle) for cycle in study.cycle.values]
    columns = {"rock": "Rock"}
    columns |= {f"closure_{cycle}": f"Closure, cycle {cycle} (mm)" for cycle in cycles}
    columns |= {"stays": STAYS}
    columns |= {f"kn_{cycle}": f"Net kn, cycle {cycle} (MPa/mm)" for cycle in cycles}
    caption = (
        "Mean maximum closure of each rock as it is, share of the first cycle's net closure since "
        "seating that stays at seating, and net normal stiffness kn on loading from half of the "
        "maximum stress to where joints begin to land on it by small steps"
    )
    return sheet("in-short", caption, pd.DataFrame(rows), columns)


def mean_stiffness(study: xr.Dataset, rock: str, cycle: int) -> float:
    """Net normal stiffness of a rock's mean loading curve [Pa/m] (`harmonic_mean` over joints)."""
    case = study.case.values[(study.rock.values == rock) & (study.parameter.values == "base")][0]
    own = study.sel(case=case)
    return harmonic_mean(own.stiffness_net.sel(cycle=cycle).values[succeeded(own).values]).value


def finding(numbers: Sheet, elasticities: pd.DataFrame | None, configuration: Configuration) -> str:
    """Closures of the first and last cycle and what they are sensitive to, in sentences."""
    named = dict(zip(numbers.titles, zip(*numbers.rows, strict=True), strict=True))
    rocks = named.pop("Rock")
    said = {name: _range([cell.key for cell in cells]) for name, cells in named.items()}
    stresses = _range([1e-6 * rock.max_normal_stress for rock in configuration.rocks.values()])
    who = (
        f"Joints of {rocks[0].text.lower()}" if len(rocks) == 1 else f"Joints of {len(rocks)} rocks"
    )
    first = said["Closure, cycle 1 (mm)"]
    text = f"{who} close {first} mm when they are first loaded to {stresses} MPa"
    if "Closure, cycle 2 (mm)" in said:
        text += f", and {said['Closure, cycle 2 (mm)']} mm when they are loaded again"
    text += f"; {said[STAYS]} % of the first net closure since seating stays."
    return f"{text} {_sensitive(elasticities)}".strip()


def _sensitive(elasticities: pd.DataFrame | None) -> str:
    """The property that the last cycle's closure is most sensitive to, where that can be told."""
    if elasticities is None or not len(elasticities):
        return ""
    last = elasticities[elasticities.cycle == elasticities.cycle.max()]
    last = last.dropna(subset="elasticity")
    sizes = last.assign(size=last.elasticity.abs()).groupby("rock", sort=False)
    rocks = len(sizes)
    if not rocks or sizes.size().min() < 2:
        return ""
    first = last.loc[sizes["size"].idxmax()].parameter.value_counts().index[0]
    answer = most_sensitive(last, str(first))
    cycle = last.cycle.iloc[0]
    if answer == STANDS:
        where = "" if rocks == 1 else f" in all {rocks} rocks"
        title = _lower(PARAMETER_TITLES[str(first)])
        return f"In cycle {cycle} closure is most sensitive to {title}{where}."
    reason = {
        FALLS: "differs between rocks",
        NO_DIFFERENCE: "makes no difference worth noticing",
        CANNOT_BE_TOLD: "cannot be told from so many joints",
    }[answer]
    return f"Which property the closure of cycle {cycle} is most sensitive to {reason}."


def most_sensitive(elasticities: pd.DataFrame, parameter: str) -> str:
    """Verdict on a property being the most sensitive one in all rocks, of one cycle.

    Errors of elasticities are taken as independent. The intervals of all differences between
    their sizes hold together with 95 %; sizes within `TOLERANCE` are alike.
    """
    lows, highs = [], []
    differences = len(elasticities) - elasticities.rock.nunique()
    confidence = 1.0 - 0.05 / differences
    for _, own in elasticities.groupby("rock"):
        own = own.set_index("parameter")
        if parameter not in own.index:
            return CANNOT_BE_TOLD
        first, others = own.loc[parameter], own.drop(parameter)
        for other in others.itertuples():
            error = np.hypot(first.elasticity_standard_error, other.elasticity_standard_error)
            difference = abs(first.elasticity) - abs(other.elasticity)
            interval = t_interval((difference, error), int(first.samples), confidence)
            lows.append(interval.low)
            highs.append(interval.high)
    return verdict((np.min(lows), np.min(highs)), (TOLERANCE, np.inf), TOLERANCE)


def _lower(title: str) -> str:
    """A property's title within a sentence: names keep their capitals."""
    return title if title.startswith(("Young", "Poisson", "JRC")) else title[0].lower() + title[1:]


def _range(values: list) -> str:
    known = [float(value) for value in values if value != ""]
    if not known:
        return "an unknown number of"
    low, high = number_text(min(known), 2), number_text(max(known), 2)
    return low if low == high else f"{low} to {high}"


def validity(configuration: Configuration, outcome: dict) -> list[str]:
    """What the numbers hold for, in sentences."""
    surface, said = configuration.surface, []
    if any(rock.walls is None for rock in configuration.rocks.values()):
        mated = surface.correlation > 0.0 or surface.mismatch_wavelength is not None
        said.append(
            "Walls are random and mated in part, as the configuration says."
            if mated
            else "Walls are random and independent of each other. Natural joints mate in part, "
            "close less and are stiffer: the numbers are not theirs."
        )
    said.append("No fluid pressure acts on walls, and no shear; a cell of the grid is an asperity.")
    if any(rock.max_normal_stress_is_assumed for rock in configuration.rocks.values()):
        said.append("Maximum stresses are assumptions.")
    flagged = outcome["flags"]["outside_model_range"]
    if flagged or outcome["failed"]:
        said.append(
            f"{flagged} of {outcome['simulations']} simulations are outside of the model's range, "
            f"{outcome['failed']} failed."
        )
    return said

"""First screen of a study's page: result in a sentence, numbers, and validity."""

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.cli.page import Sheet, number_text, sheet
from jointclosure.engine.aggregation import succeeded
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.ratios import harmonic_mean, ratio_of_means
from jointclosure.statistics.standard_errors import Estimate
from jointclosure.statistics.verdicts import (
    FALLS,
    NO_DIFFERENCE,
    STANDS,
    UNDECIDED,
    t_interval,
    verdict,
)
from studies.frame.config.typed import Configuration
from studies.paper.claims import TOLERANCE

FIRST_PICTURES = {
    "independent": ("closure_since_seating", "table_3_intervals"),
    "common": ("closure_since_seating",),
}
"""Tables of the first screen by the draws of a study; missing ones are left out."""


_CLOSURE = "Net closure since seating, cycle {} (mm)"
STAYS = "Share that remains at seating (%)"


def summary_sheet(study: xr.Dataset, closures: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Tabulate closure, residual share and net normal stiffness of each rock's base case."""
    base = closures[closures.parameter == "base"]
    rows = []
    for rock, of_rock in base.groupby("rock", sort=False):
        case = study.sel(case=of_rock.case.iloc[0])
        used = case.isel(realization=succeeded(case).values)
        first = used.sel(cycle=1)
        stays = ratio_of_means(
            first.residual_closure_seated_net.values, first.max_closure_seated_net.values
        )
        row = {"rock": titles[rock]} | _estimated("stays", stays, 100.0)
        for cycle, means in of_rock.set_index("cycle").iterrows():
            name = "max_closure_seated_net_mean_mm"
            closure = Estimate(means[name], means[f"{name}_standard_error"])
            stiffness = harmonic_mean(used.stiffness_net.sel(cycle=cycle).values)
            row |= _estimated(f"closure_{cycle}", closure)
            row |= _estimated(f"kn_{cycle}", stiffness, 1e-9)
        rows.append(row)
    cycles = [int(cycle) for cycle in study.cycle.values]
    columns = {"rock": "Rock"}
    columns |= {f"closure_{cycle}": _CLOSURE.format(cycle) for cycle in cycles}
    columns |= {"stays": STAYS}
    columns |= {f"kn_{cycle}": f"Net kn, cycle {cycle} (MPa/mm)" for cycle in cycles}
    caption = (
        "Mean maximum net closure since seating of each rock's base case, share of that of the "
        "first cycle that remains at seating, and net normal stiffness kn on loading from half "
        "of the maximum stress to the small steps before the maximum; ± standard error"
    )
    return sheet("in-short", caption, pd.DataFrame(rows), columns)


def _estimated(name: str, estimate: Estimate, scale: float = 1.0) -> dict[str, float]:
    """Return the columns of a number and of its standard error, in the unit of the table."""
    return {
        name: scale * estimate.value,
        f"{name}_standard_error": scale * estimate.standard_error,
    }


def finding(numbers: Sheet, elasticities: pd.DataFrame | None, configuration: Configuration) -> str:
    """Describe closures of the first and last cycle, and their sensitivity, in sentences."""
    named = dict(zip(numbers.titles, zip(*numbers.rows, strict=True), strict=True))
    rocks = named.pop("Rock")
    ranges = {name: _range([cell.key for cell in cells]) for name, cells in named.items()}
    stresses = _range([1e-6 * rock.max_normal_stress for rock in configuration.rocks.values()])
    who = (
        f"Joints of {rocks[0].text.lower()}" if len(rocks) == 1 else f"Joints of {len(rocks)} rocks"
    )
    first = ranges[_CLOSURE.format(1)]
    text = f"{who} close {first} mm when they are first loaded to {stresses} MPa"
    if _CLOSURE.format(2) in ranges:
        text += f", and {ranges[_CLOSURE.format(2)]} mm when they are loaded again"
    text += f" (net of the half-spaces, since {1e-6 * configuration.seating_stress:g} MPa)"
    text += f"; {ranges[STAYS]} % of the first closure remains."
    return f"{text} {sensitivity_sentence(elasticities)}".strip()


def sensitivity_sentence(elasticities: pd.DataFrame | None) -> str:
    """State the property with the largest effect on the last cycle's closure, if it is clear."""
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
        title = _lower(PROPERTIES[str(first)].title)
        return f"In cycle {cycle} closure is most sensitive to {title}{where}."
    reason = {
        FALLS: "differs between rocks",
        NO_DIFFERENCE: "makes no difference worth noticing",
        UNDECIDED: "cannot be decided from so few joints",
    }[answer]
    return f"Which property the closure of cycle {cycle} is most sensitive to {reason}."


def most_sensitive(elasticities: pd.DataFrame, parameter: str) -> str:
    """Return the verdict on a property having the largest elasticity in all rocks, for one cycle.

    Errors of elasticities are treated as independent. The intervals of all differences between
    their magnitudes are simultaneous with 95 %. Magnitudes that differ by less than `TOLERANCE`
    count as equal.
    """
    lows, highs = [], []
    differences = len(elasticities) - elasticities.rock.nunique()
    confidence = 1.0 - 0.05 / differences
    for _, of_rock in elasticities.groupby("rock"):
        of_rock = of_rock.set_index("parameter")
        if parameter not in of_rock.index:
            return UNDECIDED
        first, others = of_rock.loc[parameter], of_rock.drop(parameter)
        for other in others.itertuples():
            error = np.hypot(first.elasticity_standard_error, other.elasticity_standard_error)
            difference = abs(first.elasticity) - abs(other.elasticity)
            interval = t_interval((difference, error), int(first.samples), confidence)
            lows.append(interval.low)
            highs.append(interval.high)
    return verdict((np.min(lows), np.min(highs)), TOLERANCE, TOLERANCE)


def _lower(title: str) -> str:
    """Return a property's title within a sentence: names keep their capitals."""
    return title if title.startswith(("Young", "Poisson", "JRC")) else title[0].lower() + title[1:]


def _range(values: list) -> str:
    known = [float(value) for value in values if value != ""]
    if not known:
        return "an unknown number of"
    low, high = number_text(min(known), 2), number_text(max(known), 2)
    return low if low == high else f"{low} to {high}"


def validity(configuration: Configuration, outcome: dict) -> list[str]:
    """Describe the validity of the numbers, in sentences."""
    surface, sentences = configuration.surface, []
    if any(rock.walls is None for rock in configuration.rocks.values()):
        mated = surface.correlation > 0.0 or surface.mismatch_wavelength is not None
        sentences.append(
            "Walls are random and mated in part, as the configuration says."
            if mated
            else "Walls are random and independent of each other. Natural joints mate in part, "
            "close less and are stiffer: the numbers are not theirs."
        )
    sentences.append(
        "No fluid pressure acts on walls, and no shear; a cell of the grid is an asperity."
    )
    if any(rock.max_normal_stress_is_assumed for rock in configuration.rocks.values()):
        sentences.append("Maximum stresses are assumptions.")
    flagged = outcome["flags"]["outside_model_range"]
    if flagged or outcome["failed"]:
        sentences.append(
            f"{flagged} of {outcome['simulations']} simulations are outside of the model's range, "
            f"{outcome['failed']} failed."
        )
    return sentences

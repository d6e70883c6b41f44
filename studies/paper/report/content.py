"""Content of a study's page: values for its template, from the dataset and the tables."""

import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.cli.report import Picture, provenance_rows, size_text
from jointclosure.execution.progress import duration
from jointclosure.parameters import PROPERTIES, Numerics
from jointclosure.statistics.number_texts import number_text, percent, rounded
from jointclosure.statistics.standard_errors import (
    Estimate,
    confidence_limits,
    half_width,
    harmonic_mean,
    ratio_of_means,
)
from jointclosure.statistics.verdicts import UNDECIDED, verdict
from studies.frame.configuration import Configuration, read_stored, sections
from studies.frame.joint_tables import changes_of_cases, succeeded
from studies.frame.settings import SIDES
from studies.paper.checks import (
    REMARKS,
    change_in_words,
    most_changed,
    remarked_joints,
)
from studies.paper.claims import OURS, TOLERANCE
from studies.paper.report.page_tables import About, frames_of, with_limits
from studies.paper.report.stability import stability
from studies.paper.report.verdicts import (
    JUMPS,
    REFERENCE,
    TOO_FEW,
    VERDICT_OF,
    is_too_wide,
    is_unknown,
    verdict_of_cycles,
)
from studies.paper.requirements import REPORTED
from studies.paper.tables_1_to_3 import test_name

STAYS = "Share that remains at seating (%)"
CLOSES = "Net closure since seating, cycle {cycle} (mm)"
DECIDES = "make assess with the configuration of this study decides this."
"""What to do where joints of the assessment are too few."""
ERRORS = {
    "change_percent": "net closure since seating",
    "gross_percent": "gross closure",
    "stiffness_percent": "net chord stiffness",
}
"""Results whose numerical error is stated in the headline, by column of the assessment."""
HALF_WIDTH = "_half_width"
"""Suffix of the columns of half-widths of 95 % intervals."""


class Material(NamedTuple):
    """What a report is made of.

    These are the dataset and tables of a study, the paper's Table 3, the default configuration
    (that of the paper), the schema of its keys, and the figures.
    """

    study: xr.Dataset
    tables: Mapping[str, pd.DataFrame]
    paper: pd.DataFrame
    default: dict
    schema: dict
    pictures: Mapping[str, Picture]


def content(material: Material) -> dict:
    """Return the values of the template by name."""
    study = material.study
    known = material.tables
    keys = json.loads(study.attrs["configuration"])
    configuration = read_stored(keys)
    titles = configuration.titles
    grid = configuration.grid
    of_paper = set(titles) & set(material.paper.rock)
    rows = setting_rows(keys, material.default, material.schema)
    numbers = summary_frame(study, known["max_closure"], titles)
    of_assessment = assessed(known, configuration, titles)
    return {
        "ranges": ranges_over_rocks(numbers, configuration),
        "bias": numerical_bias(of_assessment),
        "headlines": headlines(known.get("elasticities")),
        "configuration": configuration,
        "rocks": configuration.rocks,
        "joint_size": size_text((grid.cells_y, grid.cells_x), grid.spacing),
        "cases": study.sizes["case"],
        "outcome": outcome(study, titles),
        "jumping": jumping(known["study_hardness"]) if "study_hardness" in known else 0,
        "assessed": of_assessment,
        "measured": measured_closures(known.get("measured_fit"), numbers, titles),
        "chosen_effects": chosen_effects(study, titles),
        "stability": stability(known, of_assessment),
        "scanned": scanned_walls(study),
        "verdicts": _verdicts(known["claims"]) if "claims" in known else {},
        "tolerance": TOLERANCE,
        "test": test_name(known.get("table_3_indifference", pd.DataFrame())),
        "compared": [titles[name] for name in titles if name in of_paper],
        "not_compared": [titles[name] for name in titles if name not in of_paper],
        "finer_numerics": finer_numerics(configuration.numerics),
        "departures": departures(rows),
        "failed_checks": int((~known["checks"].passed).sum()),
        "limited_checks": int((known["checks"].required != REPORTED).sum()),
        "pictures": material.pictures,
        "provenance": provenance_rows(study.attrs),
        "median_time": duration(float(study.timing_simulation.median())),
        "frames": frames_of(study, known, About(titles, of_paper))
        | {"configuration": rows, "in_short": numbers},
    }


def finer_numerics(numerics: Numerics) -> str:
    """Return the key of a configuration with smaller errors than those of ``numerics``.

    It resolves breakage, with a fifth of the tolerance where breakage is resolved already.
    """
    finer = f", tolerance: {numerics.tolerance / 5.0:g}" if numerics.breakage == "resolved" else ""
    return f"numerics: {{breakage: resolved{finer}}}"


def chosen_effects(study: xr.Dataset, titles: Mapping[str, str]) -> dict[str, list[str]]:
    """Return the sentences by which `effects.auto` decided on effects, by the title of a rock.

    It is empty for a study that states its effects.
    """
    chosen = json.loads(study.attrs.get("effects_chosen", "{}"))
    return {
        titles[rock]: [reason for case in about["cases"].values() for reason in case["reasons"]]
        for rock, about in chosen.items()
        if rock in titles
    }


def scanned_walls(study: xr.Dataset) -> dict[str, dict]:
    """Return files and warnings of the scanned walls of each rock, and joints that share no cell.

    ``apart`` is the number of realisations, or that of windows without a common cell if it is less.
    """
    walls = json.loads(study.attrs.get("walls", "{}"))
    return {
        rock: {
            "files": [about[side]["file"] for side in SIDES if "file" in about.get(side, {})],
            "warnings": about.get("warnings", "").splitlines(),
            "apart": min(about["windows_side_by_side"], study.sizes["realization"]),
        }
        for rock, about in walls.items()
    }


def jumping(hardness: pd.DataFrame) -> int:
    """Return how many joints are hard only because their closure jumps, from `hardness_table`."""
    counts = hardness.loc[hardness.verdict == JUMPS, "verdict_joints"]
    return int(counts.iloc[0]) if len(counts) else 0


def outcome(study: xr.Dataset, titles: Mapping[str, str]) -> dict:
    """Count simulations: all, used, failed, and those that are used with a remark.

    ``remarks`` has for each remark the number of joints, that of their cases, and a text on the
    largest change of a mean closure when they are left out.
    """
    good = succeeded(study)
    used = good.sum("realization")
    remarked = remarked_joints(study)
    remarks = {}
    for name in REMARKS.values():
        rows = remarked[remarked.remark == name]
        of_cases = rows.drop_duplicates("case")
        most = most_changed(rows)
        change = "no joint is left without them"
        if most is not None:
            changed = changes_of_cases(study)[most.case]
            case = titles[most.rock] + (f", {changed}" if changed else "")
            change = (
                "mean net closures since seating without them change at most by "
                f"{change_in_words(most)} (± standard error; {case}, cycle {most.cycle})"
            )
        joints = int(of_cases.joints.sum())
        cases = len(of_cases)
        remarks[name] = {"joints": joints, "cases": cases, "change": change}
    return {
        "simulations": good.size,
        "used": int(good.sum()),
        "failed": int((~good).sum()),
        "least_used": int(used.min()),
        "most_used": int(used.max()),
        "remarks": remarks,
    }


def assessed(
    known: Mapping[str, pd.DataFrame], configuration: Configuration, titles: Mapping[str, str]
) -> dict[str, Any]:
    """Return what a report shows of the assessment of a study.

    ``known`` are the tables of the study by name, ``titles`` those of its rocks by key. The
    ``state`` is "off" (null in the configuration), "missing" (the tables were not made), "too long"
    (the fewest joints would take more than their share of the time) or "done".
    """
    if getattr(configuration, "assessment", None) is None:
        return {"state": "off"}
    if not {"study_assessment", "study_assessment_cost"} <= known.keys():
        return {"state": "missing"}
    cost = known["study_assessment_cost"].iloc[0]
    about = {"cost": cost, "state": "done" if cost.closed else "too long"}
    table = known["study_assessment"]
    whole = table[~table.rock.isin(titles)] if (~table.rock.isin(titles)).any() else table
    effects = whole[(whole.kind == "effects") & whole.reason.fillna("").ne("")]
    about["reasons"] = {
        row.variant.removeprefix("without "): f"{row.state}: {row.reason}"
        for row in effects.drop_duplicates("variant").itertuples()
    }
    if not cost.closed:
        return about
    settings = whole[whole.kind == "setting"]
    assessment: Any = configuration.section(sections()["assessment"])
    within = assessment.within
    about["within"] = percent(within)
    reached = settings[settings.of_study.eq(True) & (settings.verdict != REFERENCE)]
    if len(reached):  # that of make assess may be finer
        about["cost"] = cost.copy()
        about["cost"]["reference"] = reached.reference.iloc[0]
    about["errors"] = [
        f"net {with_unit(row, 'change_percent', '%')}, gross "
        f"{with_unit(row, 'gross_percent', '%')} on cycle {row.cycle:.0f}: {row.verdict}"
        for _, row in reached.iterrows()
    ]
    about["prices"] = prices(settings, about["within"])
    about["errors_of"] = {
        title: [
            f"{with_unit(row, name, '%')} on cycle {row.cycle:.0f}"
            for _, row in reached.iterrows()
            if name in row and not is_unknown(row, name)
        ]
        for name, title in ERRORS.items()
    }
    about["unknown_errors"] = any(
        is_unknown(row, name) for _, row in reached.iterrows() for name in ERRORS
    )
    about["errors_of_share"] = [
        with_unit(row, "remains_points", "percentage points")
        for _, row in reached[reached.cycle == 1].dropna(subset="remains_points").iterrows()
    ]
    changes = whole[whole.verdict.fillna("").ne(REFERENCE)]
    about["too_few"] = any(is_too_wide(row, "change_percent") for _, row in changes.iterrows())
    about["verdicts"] = {
        name: verdict_of_cycles(rows) for name, rows in settings.groupby("variant", sort=False)
    }
    about["samples"] = int(settings.joints.max())
    larger = cost.get("joints_of_make_assess", 0)
    about["larger"] = larger > 0
    about["joints"] = int(larger) if larger > 0 else cost.joints
    rocks = [*titles] if larger > 0 else str(cost.rocks).split(", ")
    about["rocks"] = [titles[rock] for rock in rocks]
    return about


def prices(settings: pd.DataFrame, within: str) -> list[str]:
    """Say of each setting of the numerics what time a joint takes, and the verdict on its error.

    ``settings`` are rows of the study's assessment, in the order of their accuracy, and ``within``
    is the request in words. Settings whose time is not known are left out.
    """
    words = {
        REFERENCE: "the finest setting, with which others are compared",
        VERDICT_OF[True]: f"its error is within {within}",
        VERDICT_OF[False]: f"its error is beyond {within}",
        VERDICT_OF[None]: f"these joints do not show whether its error is within {within}",
    }
    return [
        f"{number_text(seconds, 2)} s by {name} ({words[verdict_of_cycles(rows)]})"
        for name, rows in settings.groupby("variant", sort=False)
        if np.isfinite(seconds := float(rows.seconds.iloc[0]))
    ]


def with_unit(row: pd.Series, name: str, unit: str) -> str:
    """Format a number with its interval and unit, or why it is not known (`with_limits`)."""
    words = with_limits(row, name)
    return words if words == TOO_FEW else f"{words} {unit}"


def numerical_bias(about: Mapping[str, Any]) -> str:
    """Describe the error of the numerics of a study in its headline, or why it is not known.

    ``about`` is what `assessed` returns.
    """
    unknown = "The error of their numerics is not known, because "
    if about["state"] == "off":
        return f"{unknown}the configuration has assessment: null."
    if about["state"] == "missing":
        return f"{unknown}the study was not assessed; make report does so."
    if about["state"] == "too long":
        return (
            f"{unknown}two joints by finer numerics would take more than assessment.share allows."
        )
    if not about["errors"]:
        return f"{unknown}no finer numerics than the study's ({about['cost'].stated}) are compared."
    joints = f"{about['samples']} joints of {', '.join(about['rocks'])}"
    known = {title: errors for title, errors in about["errors_of"].items() if errors}
    if not known:
        return f"{unknown}{joints} are too few. {DECIDES}"
    changes = "; ".join(f"{title} {' and '.join(errors)}" for title, errors in known.items())
    others = (
        f" Of other results and cycles: {TOO_FEW}. {DECIDES}" if about["unknown_errors"] else ""
    )
    share = "".join(
        f"; the share that remains is off by {error}" for error in about["errors_of_share"]
    )
    return (
        f"Besides the scatter of joints, the numerics of this study ({about['cost'].stated}) have "
        f"errors against {about['cost'].reference} on the same walls: {changes}{share} (95 % "
        f"intervals, {joints}).{others} No number on this page is corrected for them, and no ± "
        "contains them."
    )


def _verdicts(claims: pd.DataFrame) -> dict[str, int]:
    """Count the verdicts on the claims of the paper, without variants added here."""
    ours = claims.section == OURS if "section" in claims else np.zeros(len(claims), dtype=bool)
    return claims[~ours].verdict.value_counts(sort=False).to_dict()


def summary_frame(
    study: xr.Dataset, closures: pd.DataFrame, titles: dict[str, str]
) -> pd.DataFrame:
    """Tabulate closure, residual share and net chord stiffness of each rock's base case.

    Columns with the suffix `HALF_WIDTH` have half of the 95 % interval of the number before them,
    ``Joints (n)`` the number of joints.
    """
    base = closures[closures.parameter == "base"]
    rows = []
    for rock, of_rock in base.groupby("rock", sort=False):
        case = study.sel(case=of_rock.case.iloc[0])
        used = case.isel(realization=succeeded(case).values)
        joints = used.sizes["realization"]
        row: dict[str, object] = {"Rock": titles[str(rock)], "Joints (n)": joints}
        name = "max_closure_seated_net_mean_mm"
        for cycle, means in of_rock.set_index("cycle").iterrows():
            closure = Estimate(means[name], means[f"{name}_standard_error"])
            row |= _with_half_width(CLOSES.format(cycle=cycle), closure, joints)
        over, under = (
            used[f"{end}_closure_seated_net"].sel(cycle=1).values for end in ("residual", "max")
        )
        share = ratio_of_means(100.0 * over, under)
        row |= _with_half_width(STAYS, share, int(np.isfinite(over + under).sum()))
        for cycle in of_rock.cycle:
            values = 1e-9 * used.stiffness_net.sel(cycle=cycle).values
            known = int(np.isfinite(values).sum())
            title = f"Net chord stiffness, cycle {cycle} (MPa/mm)"
            row |= _with_half_width(title, harmonic_mean(values), known)
        rows.append(row)
    return pd.DataFrame(rows)


def _with_half_width(name: str, estimate: Estimate, joints: int) -> dict[str, object]:
    """Return the columns of a number and of half of its 95 % interval by so many joints."""
    return {
        name: estimate.value,
        f"{name}{HALF_WIDTH}": half_width(estimate.standard_error, joints),
    }


def measured_closures(
    fits: pd.DataFrame | None, numbers: pd.DataFrame, titles: Mapping[str, str]
) -> list[str]:
    """Return a sentence on measured closures and those of the model for each measured rock.

    ``fits`` is the table ``measured_fit``, or None, and ``numbers`` that of `summary_frame`.
    """
    sentences = []
    cycles = None if fits is None else fits[fits.cycle.astype(str) != "all"]
    for rock, rows in () if cycles is None else cycles.groupby("rock", sort=False):
        of_rock = numbers[numbers.Rock == titles[str(rock)]].iloc[0]
        columns = {cycle: CLOSES.format(cycle=cycle) for cycle in rows.cycle}
        measured = [f"{number_text(value, 2)} mm" for value in rows.largest_closure_mm]
        modelled = [
            f"{rounded(of_rock[name], of_rock[f'{name}{HALF_WIDTH}'])} mm"
            for name in columns.values()
        ]
        where = " and ".join(f"cycle {cycle}" for cycle in columns)
        sentences.append(
            f"The measured joint of {titles[str(rock)]} closes by {' and '.join(measured)} on "
            f"{where}, the joints of the model by {' and '.join(modelled)} (largest net closure "
            "since seating; the measured curve may end at a lower stress)."
        )
    return sentences


def ranges_over_rocks(numbers: pd.DataFrame, configuration: Configuration) -> dict[str, str]:
    """Return the ranges over the rocks of the columns of `summary_frame`, and of stresses.

    Their ends have half of their 95 % intervals, where the column has these.
    """
    stresses = [1e-6 * rock.max_normal_stress for rock in configuration.rocks.values()]
    counts = " to ".join(
        map(str, sorted({numbers["Joints (n)"].min(), numbers["Joints (n)"].max()}))
    )
    return {"stress": _range(stresses), "joints": counts} | {
        name: _range_with_errors(numbers[[name, f"{name}{HALF_WIDTH}"]].dropna(subset=name))
        for name in numbers.columns
        if f"{name}{HALF_WIDTH}" in numbers
    }


def headlines(elasticities: pd.DataFrame | None) -> list[dict[str, Any]]:
    """Return the property with the largest effect on the closure of the first and the last cycle.

    The closure is the net one since seating, or the gross one where a table does not have its
    elasticities. The property is that with the largest elasticity in most rocks, with a verdict on
    this. A cycle in which elasticities of two properties are not known in every rock is left out.
    """
    if elasticities is None or not len(elasticities):
        return []
    of = "gross closure"
    if SEATED in elasticities and elasticities[SEATED].notna().any():
        of = "net closure since seating"
        error = elasticities[f"{SEATED}_standard_error"]
        columns = {"elasticity": elasticities[SEATED], "elasticity_standard_error": error}
        elasticities = elasticities.assign(**columns)
    known = elasticities.dropna(subset="elasticity")
    ends = sorted({known.cycle.min(), known.cycle.max()}) if len(known) else []
    found = (_headline(known[known.cycle == cycle]) for cycle in ends)
    return [about | {"of": of} for about in found if about]


SEATED = "elasticity_seated_net"
"""Column of the elasticities of the net closure since seating."""
NOT_VARIED = "not varied"
"""Verdict on a property that is not varied in every rock."""


def _headline(of_cycle: pd.DataFrame) -> dict[str, Any]:
    """Return the most sensitive property of one cycle, of `headlines`; empty if it is not known.

    ``elasticity`` is its elasticity with a standard error, or the range of that of several rocks.
    ``other``, ``rock`` and ``difference`` are of the least difference of sizes of elasticities.
    """
    sizes = of_cycle.assign(size=of_cycle.elasticity.abs()).groupby("rock", sort=False)
    if not len(sizes) or sizes.size().min() < 2:
        return {}
    first = str(of_cycle.loc[sizes["size"].idxmax()].parameter.value_counts().index[0])
    about = {"property": _in_sentence(first), "rocks": len(sizes)}
    about["cycle"] = of_cycle.cycle.iloc[0]
    sizes = of_cycle.loc[of_cycle.parameter == first, ["elasticity", "elasticity_standard_error"]]
    about["elasticity"] = _range_with_errors(sizes)
    about["verdict"] = most_sensitive(of_cycle, first)
    if about["verdict"] == UNDECIDED and of_cycle.rock.nunique() > len(sizes):
        return about | {"verdict": NOT_VARIED}
    rock, other, difference = min(_differences(of_cycle, first), key=lambda row: row[2].value)
    about |= {"other": _in_sentence(other), "rock": rock, "difference": rounded(*difference)}
    return about | {"is_equal": difference.value == 0.0}


def _in_sentence(parameter: str) -> str:
    """Return the title of a property within a sentence; names keep their capitals."""
    title = PROPERTIES[parameter].title
    keeps = title.startswith(("Young", "Poisson", "JRC"))
    return title if keeps else title[0].lower() + title[1:]


def _differences(elasticities: pd.DataFrame, parameter: str) -> Iterator[tuple[str, str, Estimate]]:
    """Generate rock, other property, and how much larger the property's elasticity is in size.

    Rocks in which the property is not varied are left out. Errors are taken as independent.
    """
    for rock, of_rock in elasticities.groupby("rock", sort=False):
        of_rock = of_rock.set_index("parameter")
        if parameter in of_rock.index:
            first = of_rock.loc[parameter]
            for other in of_rock.drop(parameter).itertuples():
                error = np.hypot(first.elasticity_standard_error, other.elasticity_standard_error)
                difference = abs(first.elasticity) - abs(other.elasticity)
                yield str(rock), str(other.Index), Estimate(float(difference), float(error))


def most_sensitive(elasticities: pd.DataFrame, parameter: str) -> str:
    """Judge whether a property has the largest elasticity in all rocks.

    Intervals are simultaneous, and errors of elasticities are taken as independent.
    """
    rows = elasticities[elasticities.parameter == parameter]
    if rows.rock.nunique() < elasticities.rock.nunique():
        return UNDECIDED
    samples = rows.set_index("rock").samples
    confidence = 1.0 - 0.05 / (len(elasticities) - elasticities.rock.nunique())
    limits = [
        confidence_limits(difference, int(samples[rock]), confidence)
        for rock, _, difference in _differences(elasticities, parameter)
    ]
    lows, highs = zip(*limits, strict=True)
    return verdict((np.min(lows), np.min(highs)), TOLERANCE, TOLERANCE)


def _range_with_errors(numbers: pd.DataFrame) -> str:
    """Return the range of the first column of a table; its ends have the errors of the second."""
    if not len(numbers):
        return _range([])
    ends = numbers.sort_values(numbers.columns[0]).iloc[[0, -1]].to_numpy()
    low, high = (
        rounded(value, error) if error > 0.0 else number_text(value, 2) for value, error in ends
    )
    return low if len(numbers) == 1 else f"{low} to {high}"


def _range(values: list[float]) -> str:
    if not values:
        return "an unknown number of"
    low = number_text(min(values), 2)
    high = number_text(max(values), 2)
    return low if low == high else f"{low} to {high}"


def setting_rows(configuration: dict, paper: dict, schema: dict) -> pd.DataFrame:
    """Tabulate the keys of a study: value, that of the paper, whether they differ, and meaning."""
    chosen = {key: value for key, value in configuration.items() if key not in sections()}
    chosen["rocks"] = {name: chosen["rocks"][name] for name in chosen["study"]["rocks"]}
    theirs = dict(_leaves(paper, schema, ""))
    rows = []
    for key, (value, meaning) in _leaves(chosen, schema, ""):
        known = key in theirs
        row = {"key": key, "value": _json_text(value), "meaning": meaning}
        row["paper"] = _json_text(theirs[key][0]) if known else ""
        rows.append(row | {"differs": not known or theirs[key][0] != value})
    return pd.DataFrame(rows)


def departures(rows: pd.DataFrame) -> list[str]:
    """Return the keys, except the name, in which a study differs from that of the paper."""
    return rows[rows.differs & (rows.key != "study.name")].key.tolist()


def _leaves(value: dict, schema: dict, path: str):
    """Generate (key, (value, description)) of all nested keys that are not sections."""
    known = schema.get("properties", {})
    extra = schema.get("additionalProperties")
    order = {name: place for place, name in enumerate(known)}
    for name, entry in sorted(value.items(), key=lambda item: order.get(item[0], len(order))):
        about = known.get(name, extra if isinstance(extra, dict) else {})
        if isinstance(entry, dict):
            yield from _leaves(entry, about, f"{path}{name}.")
        else:
            yield f"{path}{name}", (entry, about.get("description", ""))


def _json_text(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)

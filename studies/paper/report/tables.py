"""Tables of the page: what a study found, and how it ran."""

from collections.abc import Callable, Iterable, Mapping

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.assessment import ASSESSED, JUDGED
from jointclosure.joint.protocol import FAILURE
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.standard_errors import percent, rounded
from studies.frame.tables import succeeded
from studies.paper.claims import CLAIMS
from studies.paper.conclusions import COUNTS, FOUND
from studies.paper.layout import table_3, test_name
from studies.paper.report.page import Cell, Sheet, cell, headings, sheet

Titles = dict[str, str]
"""Titles of the rocks of a study, in order."""
NOT_TRIED = "not tried"
"""Entry for a claim without readings or choices."""
LEAST_SHOWN = 0.001
"""Smallest probability that is shown as a number."""
MOST_FAILURES = 500
"""Largest number of failed simulations that are listed."""
_PROPERTY = {name: about.title for name, about in PROPERTIES.items()}
_WITH_UNITS = {name: about.title + about.in_brackets for name, about in PROPERTIES.items()}
_HEADS = {"rock": "Rock", "parameter": "Parameter", "cycle": "Cycle", "samples": "Joints used (n)"}
_HEADS |= {"number": "No.", "claim": "Claim", "section": "Place in the paper"}
_HEADS |= {"found": "Studies that find it"}
"""Headings that several tables have."""


def _heads(*columns: str) -> dict[str, str]:
    return {column: _HEADS[column] for column in columns}


def _titled(table: pd.DataFrame, titles: Titles, parameters: dict = _PROPERTY) -> pd.DataFrame:
    """Replace names of rocks, and of properties, by their titles."""
    table = table.assign(rock=table.rock.map(titles))
    if "parameter" in table:
        table["parameter"] = table.parameter.map(parameters)
    return table


def closure_sheet(closures: pd.DataFrame, titles: Titles) -> Sheet:
    """Maximum closure of each rock's base case."""
    columns = _heads("rock", "cycle", "samples") | {
        "max_closure_mean_mm": "Maximum closure, mean (mm)",
        "max_closure_adjusted_mean_mm": "Mean, adjusted (mm)",
        "max_closure_standard_deviation_mm": "Standard deviation between joints (mm)",
    }
    columns |= headings(
        "max_closure_net_mean_mm", "max_closure_seated_mean_mm", "residual_closure_mean_mm"
    )
    caption = (
        "Maximum closure of each rock's base case, from the start of the cycle; residual closure "
        "is from first touch; ± standard error"
    )
    base = closures[closures.parameter == "base"]
    return sheet("closures", caption, _titled(base, titles), columns)


def flow_sheet(flow: pd.DataFrame, titles: Titles) -> Sheet:
    """Apertures of each rock's base case at the largest stress that all joints reach."""
    loading = flow[(flow.parameter == "base") & (flow.branch == "loading")]
    by = ["rock", "cycle", "direction"]
    most = loading.groupby(by, sort=False).samples.transform("max")
    reached = loading[loading.samples == most]
    at = reached.loc[reached.groupby(by, sort=False).stress_MPa.idxmax()]
    columns = _heads("rock", "cycle") | {"direction": "Flow along", "stress_MPa": "Stress (MPa)"}
    columns |= {"samples": "Joints (n)", "blocked": "Of these blocked"}
    columns |= {
        "mean_aperture_mean_mm": "Mechanical aperture (mm)",
        "hydraulic_aperture_mean_mm": "Hydraulic aperture (mm)",
        "hydraulic_aperture_standard_deviation_mm": "Its standard deviation (mm)",
        "ratio_mean": "Hydraulic / mechanical",
    }
    caption = (
        "Hydraulic aperture of each rock's base case, by Reynolds' equation, at the largest stress "
        "of loading that all of its joints reach; means over the joints"
    )
    return sheet("flow", caption, _titled(at, titles), columns)


def layout_sheet(intervals: pd.DataFrame, titles: Titles, of_paper: set[str]) -> Sheet:
    """Table 3 in the paper's layout, with the paper's lengths below those of the study."""
    ours = table_3(intervals, titles)
    theirs = table_3(intervals, titles, "paper_") if of_paper else None
    percents = intervals.set_index(["parameter", "cycle", "rock"]).percent.dropna().to_dict()
    rows = []
    for parameter in ours.index:
        for cycle in dict.fromkeys(cycle for cycle, _ in ours.columns):
            cells = [Cell(_PROPERTY[parameter], parameter), Cell(str(cycle), cycle)]
            for rock, title in titles.items():
                text = ours.loc[parameter, [(cycle, title)]].iloc[0]
                if theirs is not None and rock in of_paper:
                    text += f"\npaper {theirs.loc[parameter, [(cycle, title)]].iloc[0]}"
                cells.append(Cell(text, percents.get((parameter, cycle, rock), "")))
            rows.append(cells)
    beside = ", the paper's (unpaired) below" if of_paper else ""
    caption = f"Table 3: length of indifference intervals, {test_name(intervals)}{beside}"
    return Sheet("table-3", caption, ["Parameter", "Cycle", *titles.values()], rows)


def measured_sheet(fits: pd.DataFrame, titles: Titles) -> Sheet:
    """Fit of the joints to the measured curves."""
    columns = _heads("rock", "cycle") | {"points": "Points measured"}
    columns |= {"largest_closure_mm": "Largest closure measured (mm)", **_heads("samples")}
    columns |= {"best_realization": "Joint that fits best", "misfit_mm": "Its misfit (mm)"}
    columns |= {"misfit_percent": "Its misfit (%)", "median_misfit_mm": "Median misfit (mm)"}
    caption = "Measured closure curves: the joint that fits best, and its misfit"
    return sheet("measured", caption, _titled(fits, titles), columns)


def claim_sheet(claims: pd.DataFrame, compared: bool) -> Sheet:
    """Claims with both judgements, and the paper's if it has the rocks."""
    columns = _heads("number", "claim") | {"verdict": "True of the model"}
    columns |= _heads("found") | {"found_here": "Found by this study"}
    if compared and "paper" in claims:
        columns |= _heads("section") | {"paper_finds": "Found in the paper's Table 3"}
    caption = "The paper's claims: truth in the model, and studies that find them"
    return sheet("claims", caption, pd.DataFrame(_judged(claims)), columns)


def _judged(claims: pd.DataFrame) -> list[dict]:
    """Rows of claims with texts of the share of studies that confirm them and of the verdict."""
    remarks = {claim.number: f" ({claim.remark})" for claim in CLAIMS if claim.remark}
    return [
        row | {"found": found_text(row), "verdict": row["verdict"] + remarks.get(row["number"], "")}
        for row in claims.to_dict("records")
    ]


def evidence_sheet(
    claims: pd.DataFrame, margins: pd.DataFrame, titles: Titles, compared: bool
) -> Sheet:
    """Numbers that decide claims, for the model by rock, and for the paper."""
    rows = []
    for claim in claims.itertuples():
        about = {"number": claim.number, "verdict": claim.verdict}
        for row in margins[(margins.number == claim.number) & margins.decides].itertuples():
            value = Cell(rounded(row.value, row.standard_error), row.value)
            of = {"by": "the model", "where": titles[row.rock], "cycle": row.cycle}
            rows.append(about | of | {"quantity": row.quantity, "value": value})
        if compared and isinstance(getattr(claim, "paper", None), str):
            paper = {"by": "the paper", "where": "", "cycle": "", "value": claim.paper}
            rows.append(about | paper)  # not NaN, which would make fractions of the cycles
    columns = {"number": "No.", "by": "By", "where": "Of", "cycle": "Cycle", "quantity": "What"}
    columns |= {"value": "Number", "verdict": "The claim"}
    frame = pd.DataFrame(rows, columns=list(columns))
    return sheet("evidence", "The numbers that decide each claim", frame, columns)


def conclusion_sheet(conclusions: pd.DataFrame) -> Sheet:
    """Evidence for each claim, and the conclusion (`make conclusions`)."""
    columns = _heads("number", "claim", "section") | {"verdict": "As configured"}
    columns |= _heads("found") | {
        "readings": "Readings of all rocks: stands, falls, no difference, open",
        "partial": "Readings of some rocks: true there, false, no difference, open",
        "choices": "True for so many open choices",
        "conclusion": "Conclusion",
    }
    shown = []
    for row in _judged(conclusions):
        for kind in ("readings", "partial"):
            row[kind] = _tried([row[f"{kind}_{name}"] for name in COUNTS])
        row["choices"] = NOT_TRIED
        if not pd.isna(row["choices_share"]):
            share, low, high = (
                percent(row[f"choices_share{end}"]) for end in ("", "_low", "_high")
            )
            row["choices"] = f"{share} ({low} to {high})"
        shown.append(row)
    caption = "Conclusion on each claim under readings and choices that the paper leaves open"
    return sheet("conclusions", caption, pd.DataFrame(shown), columns)


def _tried(counts: list[float]) -> str:
    if pd.isna(counts[0]):
        return NOT_TRIED
    return ", ".join(f"{count:.0f}" for count in counts) if sum(counts) else "none"


def probability(value: float, error: float) -> Cell:
    """Format a probability with its standard error; "< 0.001" if it is smaller with its error."""
    if pd.isna(value):
        return cell(None)
    small = value < LEAST_SHOWN and not error >= LEAST_SHOWN
    return Cell(f"< {LEAST_SHOWN:g}" if small else rounded(value, error), value)


def percent_text(share: float, error: float, low: float = np.nan, high: float = np.nan) -> str:
    """Format a share and its standard error in percent; with an error of 0, its interval."""
    if pd.isna(share):
        return ""
    text = f"{rounded(100.0 * share, 100.0 * error)} %"
    if error > 0.0 or pd.isna(low):
        return text
    return f"{text} ({100.0 * low:.3g} to {100.0 * high:.3g})"


def found_text(row: Mapping, prefix: str = "") -> str:
    """Format the share of studies that confirm a claim, from `FOUND` of a table's row."""
    return percent_text(*(row[f"{prefix}{name}"] for name in FOUND))


def _with_errors(table: pd.DataFrame, names: Iterable[str], shown: Callable) -> pd.DataFrame:
    """Replace columns by cells of their numbers and errors (columns with the suffix _error)."""
    return table.assign(
        **{name: list(map(shown, table[name], table[f"{name}_error"])) for name in names}
    )


def predictive_sheet(predictive: pd.DataFrame, titles: Titles, compared: bool) -> Sheet:
    """Each entry of Table 3 over repetitions of the study, with the paper's value."""
    shares = zip(predictive.share_without_root, predictive.share_error, strict=True)
    none = [Cell(percent_text(share, error), share) for share, error in shares]
    table = _titled(predictive, titles, _WITH_UNITS).assign(none=none)
    columns = _heads("rock", "parameter", "cycle") | {"median": "Median", "low_95": "2.5 %"}
    columns |= {"low_90": "5 %", "high_90": "95 %", "high_95": "97.5 %", "none": "No real root"}
    if compared and "p" in table:
        columns |= {"paper_length": "The paper", "p": "Its p", "null_p": "p without effect"}
        table = _with_errors(table, ("p", "null_p"), probability)
    caption = (
        "Predicted results of repetitions of this study, lengths by the unpaired t test on "
        "independent draws; p: of the paper's entry, two-sided; without "
        "effect: probability that noise alone gives a length as short"
    )
    return sheet("predictive", caption, table, columns)


def joint_sheet(joint: pd.DataFrame) -> Sheet:
    """Joint tests of whether the paper's entries are a draw of this model, or of noise."""
    columns = {"entries": "Entries", "number": "Number", "dashes": "Dashes in the paper"}
    columns |= {"p": "p of this model", "null_p": "p without any effect"}
    columns |= {"log_likelihood": "Log-likelihood, this model"}
    columns |= {"null_log_likelihood": "Without any effect"}
    table = _with_errors(joint, ("p", "null_p"), probability)
    likelihoods = ("log_likelihood", "null_log_likelihood")
    table = _with_errors(table, likelihoods, lambda *pair: Cell(rounded(*pair), pair[0]))
    caption = (
        "Joint tests of the paper's Table 3, including dashes; errors are due to repetitions and, "
        "for p, to the pool's surfaces. The p without any effect hardly depends on the model; if "
        "it is small, the table shows that these properties have an effect, but supports no model"
    )
    return sheet("joint", caption, table, columns)


def elasticity_sheet(elasticities: pd.DataFrame, titles: Titles) -> Sheet:
    """Elasticities of the mean maximum closure, with their standard errors."""
    columns = _heads("rock", "parameter", "cycle", "samples")
    columns |= {"elasticity_shown": "Elasticity", "elasticity_adjusted_shown": "Adjusted"}
    columns |= {"elasticity_net_shown": "Net of bulk indentation"}
    caption = (
        "Elasticities, d ln(mean closure)/d ln(property): change in % for a change of the property "
        "by 1 %"
    )
    return sheet("elasticities", caption, _titled(elasticities, titles), columns)


def check_sheet(checks: pd.DataFrame) -> Sheet:
    """Checks of the results."""
    verdict = np.where(checks.passed, "passed", "FAILED")
    verdict = np.where(checks.required == "reported only", "reported only", verdict)
    names = ("ensemble", "check", "required", "found", "verdict")
    columns = {name: name.capitalize() for name in names}
    return sheet("checks", "Checks of the results", checks.assign(verdict=verdict), columns)


def assessment_sheet(table: pd.DataFrame) -> Sheet:
    """Differences of variants from the finest setting, and of scenes without effects from all."""
    shown = table[(table.variant != table.reference) & table.quantity.isin(JUDGED)]
    shown = shown.assign(quantity=shown.quantity.map(ASSESSED))
    columns = {"rock": "Rock", "stress_MPa": "Stress (MPa)", "variant": "Variant"}
    columns |= {"seconds": "Time of a joint (s)", "quantity": "Mean", "cycle": "Cycle"}
    columns |= {"value_percent": "Change (%)", "low_percent": "From", "high_percent": "To"}
    columns |= {"verdict": "Effect"}
    caption = (
        "Error of each setting of the numerics, and change without each effect, 95 % intervals"
    )
    return sheet("assessment", caption, shown, columns)


def hardness_sheet(table: pd.DataFrame) -> Sheet:
    """Hardness of the joints of an assessment, the worst first."""
    columns = {"rock": "Rock", "stress_MPa": "Stress (MPa)", "joint": "Joint"}
    columns |= {"verdict": "Verdict", "spread": "Spread of copies"}
    columns |= {"unbreakable_share": "Share of force on contacts that cannot break"}
    columns |= {"largest_jump": "Largest jump", "nearest": "Nearest hard case", "reason": "Reason"}
    return sheet("hardness", "Hardness of joints, the worst first", table, columns)


def reached_sheet(table: pd.DataFrame, titles: Titles) -> Sheet:
    """Results of which an accuracy was requested, and what was reached."""
    columns = _heads("rock", "parameter", "cycle") | {"level": "Level", "quantity": "Result"}
    columns |= {"value": "Value", "low": "From", "high": "To", "unit": "Unit"}
    columns |= {"study_value": "By the study's numerics alone", "within_percent": "Requested (%)"}
    columns |= {"half_width_percent": "Half-width (%)", "met": "Met"}
    names = [ASSESSED.get(name, name.replace("_", " ")) for name in table.quantity]
    shown = _titled(table.assign(quantity=names), titles)
    caption = "Results at the finest numerics by two levels (docs/accuracy.md), 95 % intervals"
    return sheet("accuracy-reached", caption, shown, columns)


_IN_WORDS = {
    "outside_model_range": "Outside of the model's range",
    "target_jumped": "Jumped over the target",
    "breakage_not_at_rest": "Breakage did not come to rest",
    "rigid_contact": "Contact without compliance",
}


def in_words(name: str) -> str:
    """Return the text of a status (docs/reference.md)."""
    return _IN_WORDS.get(name, name.replace("_", " ").capitalize())


def flag_names(study: xr.Dataset) -> dict[int, str]:
    """Return the names of the bits of a status."""
    about = study.status.attrs
    return dict(zip(map(int, about["flag_masks"]), about["flag_meanings"].split(), strict=True))


def status_sheet(study: xr.Dataset, titles: Titles) -> Sheet:
    """Statuses of the simulations of each case."""
    good = succeeded(study)
    frame = pd.DataFrame(
        {
            "rock": [titles[rock] for rock in study.rock.values],
            "parameter": [_PROPERTY.get(p, "as it is") for p in study.parameter.values],
            "level": study.level.values,
            "scene": study.scene.values,
            "simulations": study.sizes["realization"],
            "used": good.sum("realization").values,
            "failed": (~good).sum("realization").values,
        }
    )
    columns = {"rock": "Rock", "parameter": "Changed", "level": "Level"}
    columns |= {"simulations": "Simulations", "used": "Used (n)", "failed": "Failed"}
    for mask, name in flag_names(study).items():
        frame[name] = ((study.status & mask) > 0).sum("realization").values
        if mask < FAILURE or frame[name].any():
            columns[name] = in_words(name)
    columns["scene"] = "Effects that act"
    return sheet("statuses", "Statuses by case", frame, columns)


def failure_sheet(study: xr.Dataset) -> Sheet:
    """Every failed simulation, with the seed of its walls."""
    flags = flag_names(study)
    rows = []
    statuses = study.status.transpose("case", "realization").values
    seeds = study.seed.transpose("case", "realization").values
    failed = np.argwhere(statuses >= FAILURE)
    for i, j in failed[:MOST_FAILURES]:
        words = [in_words(name) for mask, name in flags.items() if int(statuses[i, j]) & mask]
        row = {"case": study.case.values[i], "realization": int(study.realization.values[j])}
        rows.append(row | {"status": ", ".join(words), "seed": str(seeds[i, j])})
    columns = {"case": "Case", "realization": "Realisation", "status": "Status"}
    columns["seed"] = "Seed of its walls"
    caption = "Failed simulations"
    if len(failed) > MOST_FAILURES:
        caption += f", the first {MOST_FAILURES} of {len(failed)}"
    return sheet("failures", caption, pd.DataFrame(rows, columns=list(columns)), columns)

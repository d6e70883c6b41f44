"""What a study found: closures, intervals and claims, as tables of the page."""

import re

import numpy as np
import pandas as pd

from jointclosure.config.properties import PARAMETER_TITLES, PROPERTIES
from jointclosure.report.sheets import Cell, Sheet, cell, given, number_text, sheet
from jointclosure.statistics.standard_errors import rounded
from jointclosure.tables import is_paired, table_3

_WITH_UNITS = {name: about.title + about.in_brackets for name, about in PROPERTIES.items()}


def closure_sheet(closures: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Maximum closure of each rock as it is."""
    base = closures[closures.parameter == "base"]
    columns = {
        "rock": "Rock",
        "cycle": "Cycle",
        "samples": "Joints used (n)",
        "max_closure_mean_mm": "Maximum closure, mean (mm)",
        "max_closure_adjusted_mean_mm": "Mean, adjusted (mm)",
        "max_closure_standard_deviation_mm": "Its standard deviation (mm)",
        "max_closure_net_mean_mm": "Net of bulk indentation (mm)",
        "max_closure_seated_mean_mm": "Counted from seating (mm)",
        "residual_closure_mean_mm": "Residual closure (mm)",
    }
    return sheet(
        "closures",
        "Maximum closure of each rock as it is; a cycle's counts from the cycle's start, "
        "residual closure from first touch",
        base.assign(rock=base.rock.map(titles)),
        columns,
    )


def flow_sheet(flow: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Apertures of each rock as it is, at the largest stress that all of its joints reach."""
    loading = flow[(flow.parameter == "base") & (flow.branch == "loading")]
    groups = loading.groupby(["rock", "cycle", "direction"], sort=False)
    reached = loading[loading.samples == groups.samples.transform("max")]
    at = reached.loc[
        reached.groupby(["rock", "cycle", "direction"], sort=False).stress_MPa.idxmax()
    ]
    columns = {
        "rock": "Rock",
        "cycle": "Cycle",
        "direction": "Flow along",
        "stress_MPa": "Stress (MPa)",
        "samples": "Joints (n)",
        "blocked": "Of these blocked",
        "mean_aperture_mean_mm": "Mechanical aperture (mm)",
        "hydraulic_aperture_mean_mm": "Hydraulic aperture (mm)",
        "hydraulic_aperture_standard_deviation_mm": "Its standard deviation (mm)",
        "ratio_mean": "Hydraulic / mechanical",
    }
    return sheet(
        "flow",
        "Hydraulic aperture of each rock as it is, by Reynolds' equation, at the largest stress "
        "of loading that all of its joints reach; means over the joints",
        at.assign(rock=at.rock.map(titles)),
        columns,
    )


def ranking_sheet(intervals: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Parameters of each rock and cycle, the most sensitive first."""
    rows = []
    for (rock, cycle), part in intervals.groupby(["rock", "cycle"], sort=False):
        known = part.dropna(subset="percent").sort_values("percent")
        ranked = [
            f"{PARAMETER_TITLES[row.parameter]} ({number_text(row.percent, 2)} %)"
            for row in known.itertuples()
        ]
        none = [PARAMETER_TITLES[p] for p in part[part.percent.isna()].parameter]
        rows.append(
            {
                "rock": titles[rock],
                "cycle": cycle,
                "first": ranked[0] if ranked else "",
                "then": ", ".join(ranked[1:]),
                "none": ", ".join(none),
            }
        )
    columns = {"rock": "Rock", "cycle": "Cycle", "first": "Most sensitive", "then": "Then"}
    columns["none"] = "No real root"
    return sheet(
        "ranking",
        "Parameters by the length of their indifference interval, in percent of the rock's own "
        "value, the shortest first",
        pd.DataFrame(rows, columns=list(columns)),
        columns,
    )


def layout_sheet(intervals: pd.DataFrame, titles: dict[str, str], of_paper: set[str]) -> Sheet:
    """Table 3 in the paper's layout, the paper's length below ours where it has the rock."""
    ours = table_3(intervals, titles)
    theirs = table_3(intervals, titles, "paper_") if of_paper else None
    with_paper = {titles[rock] for rock in of_paper}
    heads = ["Parameter", "Cycle", *titles.values()]
    rows = []
    for parameter in ours.index:
        for cycle in dict.fromkeys(cycle for cycle, _ in ours.columns):
            cells = [Cell(PARAMETER_TITLES[parameter], parameter), Cell(str(cycle), cycle)]
            for title in titles.values():
                text = ours.loc[parameter, [(cycle, title)]].iloc[0]
                if theirs is not None and title in with_paper:
                    text += f"\npaper {theirs.loc[parameter, [(cycle, title)]].iloc[0]}"
                cells.append(Cell(text, _percent(intervals, titles, parameter, cycle, title)))
            rows.append(cells)
    test = ", paired test on common surfaces" if is_paired(intervals) else ""
    beside = ", the paper's below" if of_paper else ""
    return Sheet("table-3", f"Table 3: length of indifference intervals{test}{beside}", heads, rows)


def _percent(intervals, titles, parameter, cycle, title) -> float | str:
    found = intervals[
        (intervals.parameter == parameter)
        & (intervals.cycle == cycle)
        & (intervals.rock.map(titles) == title)
    ].percent.dropna()
    return float(found.iloc[0]) if len(found) else ""


def interval_sheet(intervals: pd.DataFrame, titles: dict[str, str], of_paper: set[str]) -> Sheet:
    """Every indifference interval with its confidence interval, and the paper's."""
    table = intervals.assign(
        rock=intervals.rock.map(titles),
        base=intervals.base.map(given),
        parameter=intervals.parameter.map(_WITH_UNITS),
    )
    columns = {
        "rock": "Rock",
        "parameter": "Parameter",
        "cycle": "Cycle",
        "samples": "Joints used (n)",
        "base": "The rock's own value",
        "length": "Length",
        "length_low": "From",
        "length_high": "To",
        "percent": "% of own value",
        "length_net": "Net of bulk indentation",
    }
    if is_paired(intervals):
        columns["unpaired_length"] = "By the unpaired test"
    if of_paper:
        table["paper"] = [
            Cell("no real root", "") if row.rock in of_paper and pd.isna(row.paper_length)
            else given(row.paper_length) if row.rock in of_paper
            else cell(None)
            for row in intervals.itertuples()
        ]  # fmt: skip
        table["ratio"] = intervals.length / intervals.paper_length
        columns |= {"paper": "The paper's length", "ratio": "Ours over the paper's"}
    columns["status"] = "Remark"
    return sheet(
        "intervals",
        "Indifference intervals with their bootstrap confidence intervals (from, to)",
        table,
        columns,
    )


def measured_sheet(fits: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """How well the joints fit the measured curves."""
    columns = {
        "rock": "Rock",
        "cycle": "Cycle",
        "points": "Points measured",
        "largest_closure_mm": "Largest closure measured (mm)",
        "samples": "Joints used (n)",
        "best_realization": "Joint that fits best",
        "misfit_mm": "Its misfit (mm)",
        "misfit_percent": "Its misfit (%)",
        "median_misfit_mm": "Median misfit (mm)",
    }
    return sheet(
        "measured",
        "Measured closure curves: the joint that fits best, and how far it is off",
        fits.assign(rock=fits.rock.map(titles)),
        columns,
    )


def claim_sheet(claims: pd.DataFrame, compared: bool) -> Sheet:
    """The paper's claims with both answers, and the paper's where it has the rocks."""
    columns = {"number": "No.", "claim": "Claim", "verdict": "True of the model"}
    columns |= {"found": "Studies that find it", "found_here": "Found by this one"}
    if compared and "paper" in claims:
        columns["said_in"] = "Said in"
        columns["paper_finds"] = "Found in the paper's Table 3"
    shown = claims.assign(
        found=[
            percent_text(row.found_share, row.found_error, row.found_low, row.found_high)
            for row in claims.itertuples()
        ]
    )
    return sheet("claims", "The paper's claims: true of the model, and found?", shown, columns)


def evidence_sheet(claims: pd.DataFrame, compared: bool) -> Sheet:
    """A row for each number that decides a claim: of the model by rock, and of the paper."""
    rows = []
    for claim in claims.itertuples():
        about = {"number": claim.number, "verdict": claim.verdict}
        rows += [about | {"by": "the model"} | part for part in _parts(claim.model)]
        if compared and isinstance(getattr(claim, "paper", None), str):
            rows.append(about | {"by": "the paper", "where": "", "value": claim.paper})
    columns = {"number": "No.", "by": "By", "where": "Of", "quantity": "What", "value": "Number"}
    columns["verdict"] = "The claim"
    caption = "The numbers that decide each claim"
    return sheet("evidence", caption, pd.DataFrame(rows, columns=list(columns)), columns)


def conclusion_sheet(conclusions: pd.DataFrame) -> Sheet:
    """What each claim rests on, and what is left of it (`make conclusions`)."""
    columns = {
        "number": "No.",
        "claim": "Claim",
        "said_in": "Said in",
        "verdict": "As configured",
        "found": "Studies that find it",
        "readings": "Readings of all rocks: stands, falls, open",
        "partial": "Readings of some rocks: true there, false, open",
        "choices": "True for so many open choices",
        "conclusion": "Left of it",
    }
    shown = [
        row._asdict()
        | {
            "found": percent_text(row.found_share, row.found_error, row.found_low, row.found_high),
            "readings": _tried(row.readings_stand, row.readings_fall, row.readings_open),
            "partial": _tried(row.partial_stand, row.partial_fall, row.partial_open),
            "choices": NOT_TRIED
            if pd.isna(row.choices_share)
            else f"{_percents(row.choices_share)} % ({_percents(row.choices_share_low)} to "
            f"{_percents(row.choices_share_high)})",
        }
        for row in conclusions.itertuples()
    ]
    caption = "What is left of each claim under readings and choices that the paper leaves open"
    return sheet("conclusions", caption, pd.DataFrame(shown), columns)


def moved_sheet(conclusions: pd.DataFrame) -> Sheet:
    """What moves the verdict on each claim, of those that something was found to move."""
    widest = conclusions.jrc_half_width.max()
    columns = {
        "number": "No.",
        "verdict": "As configured",
        "opposed_by": "Contradicted by the reading",
        "opened_by": "Left open by the readings",
        "moved_by": "Over the open choices it varies most with",
        "jrc_found": f"Studies that find it, JRC known to ±{widest:g}",
    }
    told = conclusions.fillna({"opposed_by": "", "opened_by": "", "moved_by": ""})
    moved = told[(told.opposed_by + told.opened_by + told.moved_by) != ""]
    shown = [
        row._asdict()
        | {
            "jrc_found": percent_text(
                row.jrc_found_share, row.jrc_found_error, row.jrc_found_low, row.jrc_found_high
            )
        }
        for row in moved.itertuples()
    ]
    caption = "What moves a verdict: readings, and the input that a claim's margin goes with"
    return sheet(
        "moved", caption, pd.DataFrame(shown, columns=[*told.columns, "jrc_found"]), columns
    )


NOT_TRIED = "not tried"
"""Of a claim that readings or choices were not asked about."""


def _tried(*counts: float) -> str:
    if pd.isna(counts[0]):
        return NOT_TRIED
    return ", ".join(f"{each:.0f}" for each in counts) if sum(counts) else "none"


def _percents(share: float) -> str:
    return f"{100.0 * share:.0f}"


_DECIDES = re.compile(r"(?:([\w ]+): )?(.*?)\s*([-−]?[\d.]+(?: ± [\d.]+)?)?$")
"""What decides a claim, as in "slate: |e(E)| - |e(nu)| 0.02 ± 0.01": where, what, how much."""


def _parts(model: object) -> list[dict[str, str]]:
    """The numbers of a claim's text on the model, which stand between semicolons."""
    if not isinstance(model, str):
        return []
    found = (_DECIDES.fullmatch(part.strip()) for part in model.split(";"))
    return [
        {"where": part[1] or "", "quantity": part[2], "value": part[3] or ""}
        for part in found
        if part
    ]


def percent_text(share: float, error: float, low: float = np.nan, high: float = np.nan) -> str:
    """A share and its standard error in percent; where that is 0, the interval from low to high.

    Nothing of a share that is not known.
    """
    if pd.isna(share):
        return ""
    text = f"{rounded(100.0 * share, 100.0 * error)} %"
    if error > 0.0 or pd.isna(low):
        return text
    return f"{text} ({100.0 * low:.3g} to {100.0 * high:.3g})"


def predictive_sheet(predictive: pd.DataFrame, titles: dict[str, str], compared: bool) -> Sheet:
    """Each entry of Table 3 over repetitions of the study, and the paper's among them."""
    table = predictive.assign(
        rock=predictive.rock.map(titles),
        parameter=predictive.parameter.map(_WITH_UNITS),
        none=100.0 * predictive.share_without_root,
    )
    columns = {
        "rock": "Rock",
        "parameter": "Parameter",
        "cycle": "Cycle",
        "median": "Median",
        "low_95": "2.5 %",
        "low_90": "5 %",
        "high_90": "95 %",
        "high_95": "97.5 %",
        "none": "No real root (%)",
    }
    if compared and "p" in table:
        columns |= {"paper_length": "The paper", "p": "Its p", "null_p": "p without effect"}
    return sheet(
        "predictive",
        "What repetitions of this study would publish; p: of the paper's entry, two-sided; without "
        "effect: probability that noise alone gives a length as short",
        table,
        columns,
    )


def joint_sheet(joint: pd.DataFrame) -> Sheet:
    """Whether the paper's entries together are a draw of this model, or of noise alone."""
    columns = {
        "entries": "Entries",
        "number": "Number",
        "dashes": "Dashes in the paper",
        "p": "p of this model",
        "null_p": "p without any effect",
        "log_likelihood": "Log-likelihood, this model",
        "null_log_likelihood": "Without any effect",
    }
    return sheet("joint", "Joint tests of the paper's Table 3, dashes included", joint, columns)


def elasticity_sheet(elasticities: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Elasticities of the mean maximum closure, with their standard errors."""
    table = elasticities.assign(
        rock=elasticities.rock.map(titles),
        parameter=elasticities.parameter.map(PARAMETER_TITLES),
    )
    columns = {
        "rock": "Rock",
        "parameter": "Parameter",
        "cycle": "Cycle",
        "samples": "Joints used (n)",
        "elasticity_shown": "Elasticity",
        "elasticity_adjusted_shown": "Adjusted",
        "elasticity_net_shown": "Net of bulk indentation",
    }
    return sheet(
        "elasticities",
        "Elasticities, d ln(mean closure)/d ln(property): what 1 % more of the property does, in %",
        table,
        columns,
    )

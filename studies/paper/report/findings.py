"""Tables of the page on results of a study: closures, intervals and claims."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from jointclosure.cli.page import Cell, Sheet, cell, given, headings, sheet
from jointclosure.parameters import PROPERTIES
from jointclosure.statistics.standard_errors import percent, rounded
from studies.paper.claims import CLAIMS
from studies.paper.conclusions import COUNTS, FOUND
from studies.paper.layout import is_paired, table_3, test_name

_WITH_UNITS = {name: about.title + about.in_brackets for name, about in PROPERTIES.items()}


def closure_sheet(closures: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Tabulate the maximum closure of each rock's base case."""
    base = closures[closures.parameter == "base"]
    columns = {
        "rock": "Rock",
        "cycle": "Cycle",
        "samples": "Joints used (n)",
        "max_closure_mean_mm": "Maximum closure, mean (mm)",
        "max_closure_adjusted_mean_mm": "Mean, adjusted (mm)",
        "max_closure_standard_deviation_mm": "Standard deviation between joints (mm)",
        **headings(
            "max_closure_net_mean_mm", "max_closure_seated_mean_mm", "residual_closure_mean_mm"
        ),
    }
    return sheet(
        "closures",
        "Maximum closure of each rock's base case, from the start of the cycle; residual closure "
        "is from first touch; ± standard error",
        base.assign(rock=base.rock.map(titles)),
        columns,
    )


def flow_sheet(flow: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Tabulate apertures of each rock's base case at the largest stress that all joints reach."""
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
        "Hydraulic aperture of each rock's base case, by Reynolds' equation, at the largest stress "
        "of loading that all of its joints reach; means over the joints",
        at.assign(rock=at.rock.map(titles)),
        columns,
    )


def ranking_sheet(elasticities: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Tabulate elasticities of each rock and cycle, the largest first."""
    rows = []
    for (rock, cycle), part in elasticities.groupby(["rock", "cycle"], sort=False):
        order = part.elasticity.abs().sort_values(ascending=False).index
        ranked = [
            f"{PROPERTIES[row.parameter].title} "
            + rounded(row.elasticity, row.elasticity_standard_error)
            for row in part.loc[order].itertuples()
        ]
        rows.append({"rock": titles[rock], "cycle": cycle, "ranked": ", ".join(ranked)})
    columns = {"rock": "Rock", "cycle": "Cycle", "ranked": "Elasticities, the largest first"}
    return sheet(
        "ranking",
        "Elasticities of the mean maximum closure, with standard errors: change in % for a change "
        "of the property by 1 %. The claims state which differences are significant",
        pd.DataFrame(rows, columns=list(columns)),
        columns,
    )


def layout_sheet(intervals: pd.DataFrame, titles: dict[str, str], of_paper: set[str]) -> Sheet:
    """Tabulate Table 3 in the paper's layout, with the paper's lengths below those of the study."""
    ours = table_3(intervals, titles)
    theirs = table_3(intervals, titles, "paper_") if of_paper else None
    with_paper = {titles[rock] for rock in of_paper}
    heads = ["Parameter", "Cycle", *titles.values()]
    rows = []
    for parameter in ours.index:
        for cycle in dict.fromkeys(cycle for cycle, _ in ours.columns):
            cells = [Cell(PROPERTIES[parameter].title, parameter), Cell(str(cycle), cycle)]
            for title in titles.values():
                text = ours.loc[parameter, [(cycle, title)]].iloc[0]
                if theirs is not None and title in with_paper:
                    text += f"\npaper {theirs.loc[parameter, [(cycle, title)]].iloc[0]}"
                cells.append(Cell(text, _percent(intervals, titles, parameter, cycle, title)))
            rows.append(cells)
    beside = ", the paper's (unpaired) below" if of_paper else ""
    caption = f"Table 3: length of indifference intervals, {test_name(intervals)}{beside}"
    return Sheet("table-3", caption, heads, rows)


def _percent(intervals, titles, parameter, cycle, title) -> float | str:
    values = intervals[
        (intervals.parameter == parameter)
        & (intervals.cycle == cycle)
        & (intervals.rock.map(titles) == title)
    ].percent.dropna()
    return float(values.iloc[0]) if len(values) else ""


def interval_sheet(intervals: pd.DataFrame, titles: dict[str, str], of_paper: set[str]) -> Sheet:
    """Tabulate every indifference interval with its confidence interval, and the paper's."""
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
        "base": "The rock's value",
        "length": "Length",
        "length_low": "From",
        "length_high": "To",
        "percent": "% of the rock's value",
        "length_net": "Net of bulk indentation",
    }
    if is_paired(intervals):
        columns["unpaired_length"] = "By the unpaired t test"
    if of_paper:
        table["paper"] = [
            Cell("no real root", "") if row.rock in of_paper and pd.isna(row.paper_length)
            else given(row.paper_length) if row.rock in of_paper
            else cell(None)
            for row in intervals.itertuples()
        ]  # fmt: skip
        table["ratio"] = intervals.length / intervals.paper_length
        columns |= {"paper": "The paper's length (unpaired)", "ratio": "This study over the paper"}
        if is_paired(intervals):
            del columns["ratio"]  # a ratio of lengths by different tests
    columns["status"] = "Remark"
    return sheet(
        "intervals",
        f"Indifference intervals, {test_name(intervals)}, with their bootstrap confidence "
        "intervals (from, to)",
        table,
        columns,
    )


def measured_sheet(fits: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Tabulate the fit of the joints to the measured curves."""
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
        "Measured closure curves: the joint that fits best, and its misfit",
        fits.assign(rock=fits.rock.map(titles)),
        columns,
    )


def claim_sheet(claims: pd.DataFrame, compared: bool) -> Sheet:
    """Tabulate the paper's claims with both judgements, and the paper's if it has the rocks."""
    columns = {"number": "No.", "claim": "Claim", "verdict": "True of the model"}
    columns |= {"found": "Studies that find it", "found_here": "Found by this study"}
    if compared and "paper" in claims:
        columns["section"] = "Place in the paper"
        columns["paper_finds"] = "Found in the paper's Table 3"
    rows = claims.to_dict("records")
    texts = {"found": found_text, "verdict": verdict_text}
    shown = claims.assign(**{name: [text(row) for row in rows] for name, text in texts.items()})
    caption = "The paper's claims: truth in the model, and studies that find them"
    return sheet("claims", caption, shown, columns)


def evidence_sheet(
    claims: pd.DataFrame, margins: pd.DataFrame, titles: dict[str, str], compared: bool
) -> Sheet:
    """Tabulate the numbers that decide claims, for the model by rock, and for the paper."""
    rows = []
    for claim in claims.itertuples():
        about = {"number": claim.number, "verdict": claim.verdict}
        deciding = margins[(margins.number == claim.number) & margins.decides]
        rows += [
            about
            | {"by": "the model", "where": titles[row.rock], "cycle": row.cycle}
            | {"quantity": row.quantity}
            | {"value": Cell(rounded(row.value, row.standard_error), row.value)}
            for row in deciding.itertuples()
        ]
        if compared and isinstance(getattr(claim, "paper", None), str):
            paper = {"by": "the paper", "where": "", "cycle": "", "value": claim.paper}
            rows.append(about | paper)  # not NaN, which would make fractions of the cycles
    columns = {"number": "No.", "by": "By", "where": "Of", "cycle": "Cycle", "quantity": "What"}
    columns |= {"value": "Number", "verdict": "The claim"}
    frame = pd.DataFrame(rows, columns=list(columns))
    return sheet("evidence", "The numbers that decide each claim", frame, columns)


def conclusion_sheet(conclusions: pd.DataFrame) -> Sheet:
    """Tabulate the evidence for each claim, and the conclusion (`make conclusions`)."""
    columns = {
        "number": "No.",
        "claim": "Claim",
        "section": "Place in the paper",
        "verdict": "As configured",
        "found": "Studies that find it",
        "readings": "Readings of all rocks: stands, falls, no difference, open",
        "partial": "Readings of some rocks: true there, false, no difference, open",
        "choices": "True for so many open choices",
        "conclusion": "Conclusion",
    }
    shown = [
        row
        | {
            "found": found_text(row),
            "verdict": verdict_text(row),
            "readings": _tried([row[f"readings_{name}"] for name in COUNTS]),
            "partial": _tried([row[f"partial_{name}"] for name in COUNTS]),
            "choices": NOT_TRIED
            if pd.isna(row["choices_share"])
            else f"{percent(row['choices_share'])} ({percent(row['choices_share_low'])} to "
            f"{percent(row['choices_share_high'])})",
        }
        for row in conclusions.to_dict("records")
    ]
    caption = "Conclusion on each claim under readings and choices that the paper leaves open"
    return sheet("conclusions", caption, pd.DataFrame(shown), columns)


def moved_sheet(conclusions: pd.DataFrame) -> Sheet:
    """Tabulate what changes the verdict on claims, for those with such a reading or input."""
    widest = conclusions.jrc_half_width.max()
    columns = {
        "number": "No.",
        "verdict": "As configured",
        "opposed_by": "Contradicted by the reading",
        "opened_by": "Left open by the readings",
        "moved_by": "Over the open choices it varies most with",
        "jrc_found": f"Studies that find it, JRC known to ±{widest:g}",
    }
    filled = conclusions.fillna({"opposed_by": "", "opened_by": "", "moved_by": ""})
    moved = filled[(filled.opposed_by + filled.opened_by + filled.moved_by) != ""]
    shown = moved.assign(jrc_found=[found_text(row, "jrc_") for row in moved.to_dict("records")])
    caption = "Causes of a changed verdict: readings, and the input with most effect on a margin"
    return sheet("moved", caption, shown, columns)


NOT_TRIED = "not tried"
"""Entry for a claim without readings or choices."""


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


LEAST_SHOWN = 0.001
"""Smallest probability that is shown as a number."""


def percent_text(share: float, error: float, low: float = np.nan, high: float = np.nan) -> str:
    """Format a share and its standard error in percent; with an error of 0, its interval.

    Empty for an unknown share.
    """
    if pd.isna(share):
        return ""
    text = f"{rounded(100.0 * share, 100.0 * error)} %"
    if error > 0.0 or pd.isna(low):
        return text
    return f"{text} ({100.0 * low:.3g} to {100.0 * high:.3g})"


def verdict_text(row: Mapping) -> str:
    """Format the verdict on a claim, with what it rests on where the claim has such a remark."""
    remark = next((claim.remark for claim in CLAIMS if claim.number == row["number"]), "")
    return f"{row['verdict']} ({remark})" if remark else row["verdict"]


def found_text(row: Mapping, prefix: str = "") -> str:
    """Format the share of studies that confirm a claim, from `FOUND` of a table's row."""
    return percent_text(*(row[f"{prefix}{name}"] for name in FOUND))


def predictive_sheet(predictive: pd.DataFrame, titles: dict[str, str], compared: bool) -> Sheet:
    """Tabulate each entry of Table 3 over repetitions of the study, with the paper's value."""
    table = predictive.assign(
        rock=predictive.rock.map(titles),
        parameter=predictive.parameter.map(_WITH_UNITS),
        none=[
            Cell(percent_text(row.share_without_root, row.share_error), row.share_without_root)
            for row in predictive.itertuples()
        ],
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
        "none": "No real root",
    }
    if compared and "p" in table:
        columns |= {"paper_length": "The paper", "p": "Its p", "null_p": "p without effect"}
        table = table.assign(
            **{
                name: [
                    probability(*pair)
                    for pair in zip(table[name], table[f"{name}_error"], strict=True)
                ]
                for name in ("p", "null_p")
            }
        )
    return sheet(
        "predictive",
        "Predicted results of repetitions of this study, lengths by the unpaired t test on "
        "independent draws; p: of the paper's entry, two-sided; without "
        "effect: probability that noise alone gives a length as short",
        table,
        columns,
    )


def joint_sheet(joint: pd.DataFrame) -> Sheet:
    """Tabulate joint tests of whether the paper's entries are a draw of this model, or of noise."""
    columns = {
        "entries": "Entries",
        "number": "Number",
        "dashes": "Dashes in the paper",
        "p": "p of this model",
        "null_p": "p without any effect",
        "log_likelihood": "Log-likelihood, this model",
        "null_log_likelihood": "Without any effect",
    }
    table = joint.assign(
        **{
            name: [shown(*pair) for pair in zip(joint[name], joint[f"{name}_error"], strict=True)]
            for prefix in ("", "null_")
            for name, shown in (
                (f"{prefix}p", probability),
                (f"{prefix}log_likelihood", lambda *pair: Cell(rounded(*pair), pair[0])),
            )
        }
    )
    caption = (
        "Joint tests of the paper's Table 3, including dashes; errors are due to repetitions and, "
        "for p, to the pool's surfaces. The p without any effect hardly depends on the model; if "
        "it is small, the table shows that these properties have an effect, but supports no model"
    )
    return sheet("joint", caption, table, columns)


def elasticity_sheet(elasticities: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Tabulate elasticities of the mean maximum closure, with their standard errors."""
    table = elasticities.assign(
        rock=elasticities.rock.map(titles),
        parameter=elasticities.parameter.map(lambda name: PROPERTIES[name].title),
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
        "Elasticities, d ln(mean closure)/d ln(property): change in % for a change of the property "
        "by 1 %",
        table,
        columns,
    )

"""What a study found: closures, intervals and claims, as tables of the page."""

import pandas as pd

from jointclosure.config.properties import PARAMETER_TITLES, PROPERTIES
from jointclosure.report.sheets import Cell, Sheet, cell, given, number_text, sheet
from jointclosure.tables import table_3


def closure_sheet(closures: pd.DataFrame, titles: dict[str, str]) -> Sheet:
    """Maximum closure of each rock as it is."""
    base = closures[closures.parameter == "base"]
    columns = {
        "rock": "Rock",
        "cycle": "Cycle",
        "samples": "Joints used (n)",
        "max_closure_mean_mm": "Maximum closure, mean (mm)",
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
    columns["none"] = "No change is significant"
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
    beside = ", the paper's below" if of_paper else ""
    return Sheet("table-3", f"Table 3: length of indifference intervals{beside}", heads, rows)


def _percent(intervals, titles, parameter, cycle, title) -> float | str:
    found = intervals[
        (intervals.parameter == parameter)
        & (intervals.cycle == cycle)
        & (intervals.rock.map(titles) == title)
    ].percent.dropna()
    return float(found.iloc[0]) if len(found) else ""


def interval_sheet(intervals: pd.DataFrame, titles: dict[str, str], of_paper: set[str]) -> Sheet:
    """Every indifference interval with its confidence interval, and the paper's."""
    titles_with_units = {p: about.title + about.in_brackets for p, about in PROPERTIES.items()}
    table = intervals.assign(
        rock=intervals.rock.map(titles),
        base=intervals.base.map(given),
        parameter=intervals.parameter.map(titles_with_units),
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
    """The paper's claims with verdicts; its own figures where it has the rocks."""
    columns = {"number": "No.", "verdict": "Verdict", "claim": "Claim", "ours": "This study"}
    if compared and "paper" in claims:
        columns["paper"] = "The paper"
    return sheet("claims", "The paper's claims, held against this study", claims, columns)

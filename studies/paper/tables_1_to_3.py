"""Tables 1 to 3 of a study as data frames and Markdown; titles from users are escaped in texts."""

import contextlib
import re
import unicodedata

import pandas as pd

from jointclosure.parameters import PROPERTIES, Rock, key_of
from jointclosure.parameters.units import in_unit
from jointclosure.statistics.number_texts import rounded, significant
from jointclosure.statistics.standard_errors import half_width
from studies.frame.cases import level_names
from studies.frame.rocks import StudyRock
from studies.frame.settings import BASE, SIDES

LONGEST_TITLE = 40
"""Largest number of letters of a rock's title in a figure; longer titles are cut."""


def rock_table(rocks: dict[str, StudyRock], closures: pd.DataFrame | None = None) -> pd.DataFrame:
    """Return Table 1: the properties of the rocks, in its units, and their maximum stresses.

    With ``closures``, the table of `max_closure_table`, it also has the mean maximum closures [mm]
    of the base cases by cycle.
    """
    rows = []
    for name, rock in rocks.items():
        row: dict[str, object] = {"rock": name, "title": rock.title}
        for field in Rock._fields:
            row[key_of(field)] = in_unit(getattr(rock.intact, field), PROPERTIES[field].unit)
        if not rock.walls:
            row["jrc"] = in_unit(rock.jrc, "1")
        row["max_normal_stress_MPa"] = in_unit(rock.max_normal_stress, "MPa")
        row["max_normal_stress_is_assumed"] = rock.max_normal_stress_is_assumed
        if rock.measured:
            row["measured"] = rock.measured.file
        if rock.walls:
            row |= {f"{side}_wall": getattr(rock.walls, side) for side in SIDES}
        rows.append(row | _closures_of(closures, name, BASE, BASE))
    return pd.DataFrame(rows).map(_plain_csv)


def roughness_title(rock: StudyRock) -> str:
    """Return words on the walls of a rock, for a figure: their JRC, or "scanned walls"."""
    return "scanned walls" if rock.walls else f"JRC {rock.jrc:g}"


def case_table(rocks: dict[str, StudyRock], closures: pd.DataFrame | None = None) -> pd.DataFrame:
    """Return Table 2, with a row for each rock, varied parameter and level.

    ``closures`` are as for `rock_table`.
    """
    rows = []
    for name, rock in rocks.items():
        for parameter in (name for name in PROPERTIES if name in rock.levels):
            levels = rock.levels[parameter]
            unit = PROPERTIES[parameter].unit
            base = getattr(rock, parameter)
            for level, value in zip(level_names(levels, base), levels, strict=True):
                row: dict[str, object] = {"rock": name, "parameter": parameter, "level": level}
                of = BASE if level == BASE else parameter
                row |= {"value": in_unit(value, unit), "unit": unit}
                rows.append(row | _closures_of(closures, name, of, level))
    columns = None if rows else ["rock", "parameter", "level", "value", "unit"]
    return pd.DataFrame(rows, columns=columns)


def _closures_of(closures: pd.DataFrame | None, rock: str, parameter: str, level: str) -> dict:
    """Return the mean maximum closures [mm] of a case as texts, by the column of the cycle.

    They are rounded to their standard errors. There are none without ``closures``.
    """
    if closures is None:
        return {}
    case = (closures.rock == rock) & (closures.parameter == parameter) & (closures.level == level)
    return {
        f"max_closure_cycle_{row.cycle}_mm": row.max_closure_shown
        for row in closures[case].itertuples()
    }


def with_paper(intervals: pd.DataFrame, paper: pd.DataFrame) -> pd.DataFrame:
    """Return the table of intervals with the paper's lengths beside those of the study.

    The column ``in_paper`` tells which rows the paper has. Without any the table stays as it is.
    """
    keys = ["rock", "parameter", "cycle"]
    published = paper[[*keys, "paper_length", "paper_percent"]].assign(in_paper=True)
    beside = intervals.merge(published, on=keys, how="left", validate="1:1")
    beside["in_paper"] = beside.in_paper.eq(True)
    return beside if beside.in_paper.any() else intervals


def interval_text(
    length: float, percent: float, mark: str = "", standard_error: float = float("nan")
) -> str:
    """Return the length of an interval as text like in the paper: number, mark, percentage.

    The number is rounded to its standard error, if this is known. It is a dash for NaN.
    """
    if pd.isna(length):
        return "–"
    known = 0.0 < standard_error < float("inf")
    figures = 2 if standard_error == float("inf") else 3
    number = rounded(length, standard_error) if known else significant(length, figures)
    return f"{number}{mark} ({significant(percent, 2)}%)"


def _mark(row: pd.Series, column: str) -> str:
    """Return the marks of an interval: * root outside of the levels, † negative deviation there.

    The mark ‡ is for a confidence interval without an upper end. ``column`` is as for `table_3`;
    intervals of the paper, and by the unpaired formula on common surfaces, have no marks.
    """
    if column in ("paper_", "unpaired_"):
        return ""
    endless = "‡" if row.get(f"length_high{column}", 0.0) == float("inf") else ""
    negative = "†" if "negative" in str(row.get(f"status{column}", "")) else ""
    return ("*" if row.get(f"extrapolated{column}", False) else "") + negative + endless


def closure_lines(closures: pd.DataFrame) -> list[str]:
    """Return a line for each rock on its mean net closures since seating, for the screen.

    ``closures`` is the table of `max_closure_table`. Means have half of their 95 % interval.
    """
    name = "max_closure_seated_net_mean_mm"
    base = closures[closures.parameter == BASE]
    return [
        f"{rock}: mean net closure since seating "
        + ", ".join(
            f"{rounded(row[name], half_width(row[f'{name}_standard_error'], row.samples))} mm "
            f"on cycle {row.cycle}"
            for _, row in part.iterrows()
        )
        + f" (± half of the 95 % interval, {int(part.samples.min())} joints)"
        for rock, part in base.groupby("rock", sort=False)
    ]


def table_3(table: pd.DataFrame, titles: dict[str, str], column: str = "") -> pd.DataFrame:
    """Return indifference intervals as texts in the paper's layout: parameters by cycle and rock.

    ``column`` selects the intervals of the table: it is the prefix ("paper_") or the suffix
    ("_net") of the names of their columns.
    """
    before, after = (column, "") if column.endswith("_") else ("", column)
    texts = [
        interval_text(
            row[f"{before}length{after}"],
            row[f"{before}percent{after}"],
            _mark(row, column),
            row.get(f"standard_error{column}", float("nan")),
        )
        for _, row in table.iterrows()
    ]
    return _by_cycle_and_rock(table.assign(text=texts), titles)


def _titles_in(table: pd.DataFrame, titles: dict[str, str]) -> dict[str, str]:
    """Return the titles of those rocks that are in a table."""
    return {rock: title for rock, title in titles.items() if (table.rock == rock).any()}


def _by_cycle_and_rock(table: pd.DataFrame, titles: dict[str, str]) -> pd.DataFrame:
    """Return the column ``text`` of a table in the paper's layout; missing entries are "".

    Rows are parameters, columns are (cycle, title of the rock).
    """
    texts = table.set_index(["parameter", "cycle", "rock"]).text.to_dict()
    rows = {
        parameter: {
            (cycle, title): texts.get((parameter, cycle, rock), "")
            for cycle in sorted(table.cycle.unique())
            for rock, title in titles.items()
        }
        for parameter in PROPERTIES
        if (table.parameter == parameter).any()
    }
    return pd.DataFrame.from_dict(rows, orient="index")


def table_3_markdown(
    table: pd.DataFrame, titles: dict[str, str], elasticities: pd.DataFrame | None = None
) -> str:
    """Return Table 3 as Markdown: gross and net intervals, those of the paper if any, and a note.

    If tests are paired, elasticities and the intervals by the unpaired formula are added.
    """
    if table.empty:
        return "No parameter is varied in this study: there is no indifference interval.\n"
    test = test_name(table)
    parts = {f"This study, {test}": ("", table)}
    lines = []
    if is_paired(table):
        if elasticities is not None and len(elasticities):
            shown = elasticities.assign(text=elasticities.elasticity_shown)
            rows = markdown_rows(_by_cycle_and_rock(shown, _titles_in(shown, titles)))
            about = "d ln(mean maximum closure)/d ln(property), with standard errors."
            lines += ["**Elasticities**", "", *rows, "", about, ""]
        lines += [PAIRED_NOTE, ""]
        parts[f"This study, {UNPAIRED_TEST} formula on common surfaces"] = ("unpaired_", table)
    parts[f"This study, net of bulk indentation, {test}"] = ("_net", table)
    if "paper_length" in table:
        parts[f"The paper, {UNPAIRED_TEST}"] = ("paper_", table[table.in_paper])
    for heading, (column, part) in parts.items():
        rows = markdown_rows(table_3(part, _titles_in(part, titles), column))
        lines += [f"**{heading}**", "", *rows, ""]
    lines.append(_note(table))
    return "\n".join(lines) + "\n"


def markdown_rows(frame: pd.DataFrame) -> list[str]:
    """Return the lines in Markdown of a table of parameters by (cycle, title of the rock)."""
    names = [f"{_plain_markdown(title)}, cycle {cycle}" for cycle, title in frame.columns]
    lines = ["| Parameter | " + " | ".join(names) + " |", "|---" * (len(names) + 1) + "|"]
    for parameter, row in frame.iterrows():
        lines.append(f"| {property_heading(parameter)} | " + " | ".join(row) + " |")
    return lines


def property_heading(parameter: str) -> str:
    """Return the heading of a property's row in Table 3, with symbol (such as σc) and unit."""
    if parameter == "jrc":
        return "Joint roughness coefficient (JRC)"
    about = PROPERTIES[parameter]
    letter, _, index = about.symbol.partition("_")
    with contextlib.suppress(KeyError):  # of a Latin letter
        letter = unicodedata.lookup(f"GREEK SMALL LETTER {letter.upper()}")
    return f"{about.title} {letter}{index}{about.in_brackets}"


def _plain_markdown(title: str) -> str:
    """Return a title as text of a cell of a Markdown table, in which its marks are escaped."""
    return re.sub(r"([\\`*_{}\[\]<>|#&~$!])", r"\\\1", _one_line(title))


def figure_text(title: str) -> str:
    """Return a title as text of a figure: without formulas, and cut to `LONGEST_TITLE` letters.

    A title that begins with "_" gets a blank before it, as legends would leave it out.
    """
    shown = _one_line(title)
    if len(shown) > LONGEST_TITLE:
        shown = f"{shown[: LONGEST_TITLE - 1]}…"
    shown = shown.replace("$", r"\$")  # two would enclose a formula
    return f" {shown}" if shown.startswith("_") else shown  # legends leave out "_..."


def _plain_csv(cell):
    """Return a cell of a CSV table; texts that spreadsheets take for formulas get an apostrophe."""
    if isinstance(cell, str) and cell.startswith(("=", "+", "-", "@", "\t", "\r")):
        return "'" + cell
    return cell


def _one_line(title: str) -> str:
    return " ".join(title.split())


PAIRED_NOTE = (
    "The same pairs of walls were simulated at every level (`draws: common`), so the test is the "
    "paired t test, of the differences of each pair of walls. Its lengths approach 0 if closures "
    "change smoothly, whatever the rock. Compare properties and rocks by elasticities, and do not "
    "compare a paired length with the paper's. The unpaired test does not use that the walls are "
    "the same, and mostly finds less. Its lengths stand beside because the paper's test is "
    "unpaired, with other walls at each level."
)
"""Reason for the paired test in a table of common draws."""


UNPAIRED_TEST = "unpaired t test"


def test_name(table: pd.DataFrame) -> str:
    """Return the name of the test of a table's lengths, for its title."""
    return "paired t test on common surfaces" if is_paired(table) else UNPAIRED_TEST


def is_paired(table: pd.DataFrame) -> bool:
    """Return whether the intervals of a table are those of the paired test."""
    return "test" in table and bool((table.test == "paired").any())


def _note(table: pd.DataFrame) -> str:
    fewest = int(table.samples.min())
    most = int(table.samples.max())
    samples = f"{most}" if fewest == most else f"{fewest} to {most} successful"
    if is_paired(table):
        test = "paired t test"
        size = ""
        seen = "the paired test finds no significant change at any distance"
    else:
        test = "unpaired t test on independent draws, Eqs. (28) and (29)"
        seen = "no real root; so many draws cannot tell any change from none, which there may be"
        size = " is close to t S √(2/n) / |slope| where the response is nearly linear: it"
    return (
        f"Lengths by the {test}, with bootstrap standard errors where they are finite. A dash: "
        f"{seen}. With n = {samples} realisations a length{size} falls as one over the root of n: "
        "it depends on the sample size as much as on the rock. An asterisk marks an extrapolated "
        "root, beyond the levels tested (the paper has some too, unmarked); a dagger one where the "
        "fitted deviation is negative, which means nothing; a double dagger one whose 95 % "
        "confidence interval has no upper end."
    )

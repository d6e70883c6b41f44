"""Numbers of texts by name, each with the stored rows that it comes from."""

from collections.abc import Callable
from typing import NamedTuple

import pandas as pd
from stored import ROOT, origin, path_of, stored

from content.markdown import MOST, listed, rows_of
from jointclosure.claims.table import OURS
from jointclosure.sensitivity.conclusions import DEPENDS, JUDGED_ELSEWHERE, ONLY_CONFIGURED
from jointclosure.statistics.standard_errors import rounded
from jointclosure.statistics.verdicts import CANNOT_BE_TOLD, FALLS, NO_DIFFERENCE, STANDS


class Number(NamedTuple):
    """A number of a text: rows of a stored table ("run/table"), made into words by ``text``."""

    table: str
    rows: dict
    column: str
    text: Callable[[pd.DataFrame], str]


def number(name: str) -> str:
    """Give the text of a number; `KeyError` where there is none of this name."""
    return NUMBERS[name].text(
        rows_of(stored(*NUMBERS[name].table.split("/")), **NUMBERS[name].rows)
    )


def origins() -> str:
    """Tabulate where the numbers come from."""
    rows = []
    for name, (table, chosen, column, _) in NUMBERS.items():
        run, file = table.split("/")
        rows.append(
            {
                "number": name,
                "is": number(name),
                "table": path_of(run, file).relative_to(ROOT).as_posix(),
                "column": column,
                "rows": ", ".join(f"{key} = {value}" for key, value in chosen.items()) or "all",
                "commit": origin(run)["commit"],
            }
        )
    forms = {"table": "`{table}`", "column": "`{column}`", "commit": "`{commit}`"}
    return listed(pd.DataFrame(rows), {name: forms.get(name, f"{{{name}}}") for name in rows[0]})


def span_of(table: str, value: str, error: str, scale: float = 1.0, **rows: object) -> Number:
    """Least and largest value of a column over rows, with their errors."""

    def text(chosen: pd.DataFrame) -> str:
        ends = chosen.sort_values(value).iloc[[0, -1]]
        pairs = zip(ends[value].tolist(), ends[error].tolist(), strict=True)
        low, high = (rounded(scale * end, scale * doubt) for end, doubt in pairs)
        return low if len(chosen) == 1 else f"{low} to {high}"

    return Number(table, rows, value, text)


def _elasticity(parameter: str, cycle: int, net: str = "") -> Number:
    value = f"elasticity{net}"
    rows = {"parameter": parameter, "cycle": cycle}
    return span_of("paper/elasticities", value, f"{value}_standard_error", **rows)


def _index(name: str, cycle: int) -> Number:
    rows = {"input": name, "response": "closure", "cycle": cycle, "rows": MOST}
    return span_of("global_sensitivity/global_indices", "total", "total_error", **rows)


def _choices(claim: str, response: str, cycle: int) -> Number:
    rows = {"number": claim, "response": response, "cycle": cycle, "rock": "all"}
    table = "global_sensitivity/global_conclusions"
    return span_of(table, "share", "share_error", 100.0, **rows)


def _joint(entries: str, kind: str = "p") -> Number:
    return span_of("paper/table_3_joint_tests", kind, f"{kind}_error", entries=entries)


def _mean(cycle: int) -> Number:
    value = "max_closure_mean_mm"
    rows = {"parameter": "base", "cycle": cycle}
    return span_of("paper/max_closure", value, f"{value}_standard_error", **rows)


def _jrc(parameter: str, cycle: int, half_width: float) -> Number:
    rows = {"parameter": parameter, "cycle": cycle, "half_width": half_width}
    return span_of("paper/jrc_range", "value", "standard_error", **rows)


def _found(claim: str) -> Number:
    return span_of("paper/claims", "found_share", "found_error", 100.0, number=claim)


def _steps(cycle: int) -> Number:
    """What the paper's steps are off by, with 95 % intervals, for each rock."""

    def text(chosen: pd.DataFrame) -> str:
        return " and ".join(
            f"{row.bias_percent:+.1f} % ({row.bias_low:+.1f} to {row.bias_high:+.1f})"
            for row in chosen.sort_values("bias_percent").itertuples()
        )

    rows = {"response": "mean", "method": "paper", "control_variates": False, "cycle": cycle}
    return Number("accuracy/accuracy_methods", rows, "bias_percent", text)


def _count(*conclusions: str) -> Number:
    """How many claims of the paper have such a conclusion (any, where none is named).

    A count has no error, and may be 0.
    """

    def text(chosen: pd.DataFrame) -> str:
        counted = chosen.conclusion.isin(conclusions) if conclusions else True
        return str(int((counted & (chosen.said_in != OURS)).sum()))

    which = f"conclusion = {' or '.join(conclusions)}, " if conclusions else ""
    return Number("paper/conclusions", {}, f"rows of {which}said_in not {OURS}", text)


def _readings(kind: str) -> Number:
    """How many readings that the paper allows closed all rocks (readings), or some (partial)."""
    columns = [f"{kind}_{verdict}" for verdict in ("stand", "fall", "open")]
    rows = {"number": "2a"}
    table = "conclusions/earlier_readings"
    return Number(
        table, rows, " + ".join(columns), lambda chosen: f"{chosen[columns].sum().sum():.0f}"
    )


def _share_of_rows(claim: str, cycle: int) -> Number:
    """At how many rows a conclusion is true of the row's changes, over rocks."""

    def text(chosen: pd.DataFrame) -> str:
        of_rocks = chosen[chosen.rock != "all"].rows_true
        return f"{of_rocks.min()} to {of_rocks.max()}"

    rows = {"number": claim, "response": "closure", "cycle": cycle}
    return Number("global_sensitivity/global_conclusions", rows, "rows_true", text)


def _margin(name: str) -> Number:
    """Share of the margin of Young's modulus on the second cycle that goes with an input."""

    def text(chosen: pd.DataFrame) -> str:
        return f"{100 * chosen.share.min():.0f} to {100 * chosen.share.max():.0f} %"

    rows = {"number": "2a", "response": "closure", "cycle": 2, "input": name}
    return Number("global_sensitivity/global_margins", rows, "share", text)


def _rows() -> Number:
    """Rows of the design of global sensitivity: a choice, without error."""
    table = "global_sensitivity/global_indices"
    return Number(table, {"rows": MOST}, "rows", lambda chosen: str(chosen.rows.iloc[0]))


def _tilted(cycle: int) -> Number:
    """What the largest tilt changes of independent walls."""
    rows = {"wavelength_mm": float("inf"), "rotation_degrees": 0.0, "tilt_degrees": MOST}
    rows |= {"response": "closure", "cycle": cycle}
    return span_of("misalignment/misalignment", "change_percent", "change_error", **rows)


def _larger(cycle: int) -> Number:
    """Ratio of the net closure since seating of the largest patch to that of the smallest."""
    rows = {"spectrum": "roll_off_3mm", "reading": "closure_seated_net"}
    rows |= {"cycle": cycle, "to_mm": MOST}
    return span_of("size/size_barton_bandis", "ratio", "error", **rows)


def _continuum(cycle: int) -> Number:
    """Closure of a continuum whose pressure is limited over that of the asperity model."""
    rows = {"model": "continuum, hardness at breakage (own)", "reading": f"closure_{cycle}_um"}
    return span_of("continuum/continuum", "ratio", "ratio_error", **rows)


NUMBERS = {
    "claims": _count(),
    "stand": _count(STANDS),
    "fall": _count(FALLS),
    "depend": _count(DEPENDS),
    "alike": _count(NO_DIFFERENCE),
    "untold": _count(CANNOT_BE_TOLD),
    "configured only": _count(*ONLY_CONFIGURED.values()),
    "elsewhere": _count(JUDGED_ELSEWHERE),
    "2a goes with the ratio": _margin("peak_modulus"),
    "2a goes with JRC": _margin("jrc"),
    "2a goes with the rule for peaks": _margin("peaks"),
    "readings of all rocks": _readings("readings"),
    "readings of some rocks": _readings("partial"),
    "rows": _rows(),
    "rows of 5a": _share_of_rows("5a", 2),
    "rows of 5b": _share_of_rows("5b", 2),
    "rows of 5c": _share_of_rows("5c", 1),
    "e(E) 2, net": _elasticity("youngs_modulus", 2, "_net"),
    "e(E) 2": _elasticity("youngs_modulus", 2),
    "e(E) 1, net": _elasticity("youngs_modulus", 1, "_net"),
    "e(sigma_c) 2, net": _elasticity("compressive_strength", 2, "_net"),
    "mean 1": _mean(1),
    "mean 2": _mean(2),
    "scatter 1": _jrc("base", 1, 0.0),
    "scatter 2": _jrc("base", 2, 0.0),
    "p": _joint("all"),
    "p of no effect, cycle 1 without JRC": _joint("cycle 1 without JRC", "null_p"),
    "p, cycle 1 without JRC": _joint("cycle 1 without JRC"),
    "e(sigma_c) 2": _elasticity("compressive_strength", 2),
    "e(JRC) 2": _elasticity("jrc", 2),
    "e(nu) 2": _elasticity("poisson_ratio", 2),
    "length of E 2": _jrc("youngs_modulus", 2, 0.0),
    "found 2a": _found("2a"),
    "e(JRC) 1": _elasticity("jrc", 1),
    "e(sigma_c) 1": _elasticity("compressive_strength", 1),
    "e(E) 1": _elasticity("youngs_modulus", 1),
    "e(nu) 1": _elasticity("poisson_ratio", 1),
    "found 2b": _found("2b"),
    "choices 2b": _choices("2a", "closure", 1),
    "found 1a 1": _found("1a, cycle 1"),
    "ratio on 2": _index("peak_modulus", 2),
    "roll-off on 1": _index("roll_off", 1),
    "JRC on 1": _index("jrc", 1),
    "stress on 1": _index("stress", 1),
    "ratio on 1": _index("peak_modulus", 1),
    "choices 2a": _choices("2a", "closure", 2),
    "choices 2a, net": _choices("2a", "closure_net", 2),
    "choices 1a 1": _choices("1a", "closure", 1),
    "choices 1a 2": _choices("1a", "closure", 2),
    "scatter 1, JRC to 2": _jrc("base", 1, 2.0),
    "tilt 1": _tilted(1),
    "tilt 2": _tilted(2),
    "larger 1": _larger(1),
    "larger 2": _larger(2),
    "steps 1": _steps(1),
    "steps 2": _steps(2),
    "continuum 1": _continuum(1),
    "continuum 2": _continuum(2),
}
"""Numbers of docs/conclusions.md, in its order."""

"""Numbers of texts by name, with the stored rows that they come from."""

from collections.abc import Mapping
from functools import partial
from types import MappingProxyType
from typing import NamedTuple

from content.markdown import Form, Group, value_of
from jointclosure.statistics.standard_errors import rounded
from jointclosure.statistics.verdicts import FALLS, NO_DIFFERENCE, STANDS, UNDECIDED
from studies.paper.claims import OURS
from studies.paper.conclusions import JUDGED_ELSEWHERE, ONLY_CONFIGURED


class Number(NamedTuple):
    """A number of a text: rows of a stored table ("run/table") that have some values."""

    table: str
    form: Form
    rows: Mapping[str, object] = MappingProxyType({})


def number(name: str) -> str:
    """Give the text of a number; `KeyError` where there is none of this name."""
    return value_of(NUMBERS[name].table, NUMBERS[name].form, **NUMBERS[name].rows)


def span(table: str, value: str, error: str, scale: float = 1.0, **rows: object) -> Number:
    """Least and largest value of a column over rows, with their errors."""

    def text(group: Group) -> str:
        ends = group.rows.sort_values(value).iloc[[0, -1]][[value, error]].to_numpy().tolist()
        low, high = (rounded(scale * end, scale * doubt) for end, doubt in ends)
        return low if len(group.rows) == 1 else f"{low} to {high}"

    return Number(table, text, rows)


_elasticity = partial(span, "paper/elasticities", "elasticity", "elasticity_standard_error")
_net = partial(span, "paper/elasticities", "elasticity_net", "elasticity_net_standard_error")
_mean = partial(
    span, "paper/max_closure", "max_closure_mean_mm", "max_closure_mean_mm_standard_error",
    parameter="base",
)  # fmt: skip
_scatter = partial(
    span, "jrc_range/jrc_range", "value", "standard_error", parameter="base", half_width=0.0
)
_choices_of_2a = partial(
    span, "global_sensitivity/global_sensitivity_conclusions", "share", "share_error", 100.0,
    rock="all", number="2a", cycle=2,
)  # fmt: skip
_E_OF_DOLERITE = {"rock": "dolerite", "parameter": "youngs_modulus"}


def _steps(cycle: int) -> Number:
    """Return the least and the largest error of the paper's steps of all rocks."""

    def text(group: Group) -> str:
        form = "{bias_percent:+.1f} % ({bias_low:+.1f} to {bias_high:+.1f})"
        rows = group.rows.sort_values("bias_percent").to_dict("records")
        return " to ".join(form.format_map(row) for row in (rows[0], rows[-1]))

    rows = {"response": "mean", "method": "paper", "control_variates": False, "cycle": cycle}
    return Number("accuracy_biases/accuracy_methods", text, rows)


def _count(*conclusions: str) -> Number:
    """How many claims of the paper have such a conclusion (any, where none is named).

    A count has no error, and may be 0.
    """

    def text(group: Group) -> int:
        counted = group.rows.conclusion.isin(conclusions) | (not conclusions)
        return (counted & (group.rows.section != OURS)).sum()

    return Number("paper/conclusions", text)


def _readings() -> Number:
    """How many readings that the paper allows closed all rocks."""

    def text(group: Group) -> str:
        counts = (group[f"readings_{verdict}"] for verdict in ("stand", "fall", "open"))
        return f"{sum(counts):.0f}"

    return Number("conclusions/earlier_readings", text, {"number": "2a"})


def _margin(name: str, rock: str) -> Number:
    """Share of a rock's margin of Young's modulus on the second cycle that goes with an input."""

    def text(group: Group) -> str:
        return f"{100 * group['share']:.0f} ± {100 * group['share_error']:.0f} %"

    rows = {"number": "2a", "response": "max_closure", "cycle": 2, "input": name, "rock": rock}
    return Number("global_sensitivity/global_sensitivity_margins", text, rows)


NUMBERS = {
    "claims": _count(),
    "stand": _count(STANDS),
    "fall": _count(FALLS),
    "alike": _count(NO_DIFFERENCE),
    "undecided": _count(UNDECIDED),
    "configured only": _count(*ONLY_CONFIGURED.values()),
    "elsewhere": _count(JUDGED_ELSEWHERE),
    "2a goes with the ratio": _margin("peak_modulus", "dolerite"),
    "2a goes with the Hurst exponent": _margin("hurst", "siltstone"),
    "readings of all rocks": _readings(),
    "e(E) 1": _elasticity(parameter="youngs_modulus", cycle=1),
    "e(E) 1, net": _net(parameter="youngs_modulus", cycle=1),
    "e(E) 2": _elasticity(parameter="youngs_modulus", cycle=2),
    "e(E) 2, net": _net(parameter="youngs_modulus", cycle=2),
    "e(sigma_c) 1": _elasticity(parameter="compressive_strength", cycle=1),
    "e(sigma_c) 2": _elasticity(parameter="compressive_strength", cycle=2),
    "e(sigma_c) 2, net": _net(parameter="compressive_strength", cycle=2),
    "e(JRC) 1": _elasticity(parameter="jrc", cycle=1),
    "e(JRC) 2": _elasticity(parameter="jrc", cycle=2),
    "e(nu) 1": _elasticity(parameter="poisson_ratio", cycle=1),
    "e(nu) 2": _elasticity(parameter="poisson_ratio", cycle=2),
    "mean 1": _mean(cycle=1),
    "mean 2": _mean(cycle=2),
    "scatter 1": _scatter(cycle=1),
    "scatter 2": _scatter(cycle=2),
    "p": span("large_pool/table_3_joint_tests", "p", "p_error", entries="all"),
    "repeated length of E 2": Number(
        "paper/table_3_predictive",
        "{low_90:.1f} to {high_90:.1f}",
        _E_OF_DOLERITE | {"cycle": 2},
    ),
    "no length of E 1": span(
        "paper/table_3_predictive",
        "share_without_root",
        "share_error",
        100.0,
        **_E_OF_DOLERITE,
        cycle=1,
    ),
    "choices 2a": _choices_of_2a(response="max_closure"),
    "choices 2a, net": _choices_of_2a(response="max_closure_net"),
    "steps 1": _steps(1),
    "steps 2": _steps(2),
    "continuum 1": span(
        "continuum/continuum", "ratio", "ratio_error",
        model="continuum, hardness at breakage (own)", reading="closure_1_mm",
    ),
}  # fmt: skip
"""Numbers of docs/conclusions.md."""

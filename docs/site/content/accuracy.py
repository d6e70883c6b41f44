"""Tables of docs/accuracy.md."""

import pandas as pd
from stored import origin, stored

from content.markdown import Form, Group, Table, chosen, rows_of, titled
from jointclosure.statistics import total_error
from studies.frame.config.presets import SCENES, radii_words

BIASES = {
    (response, cycle): f"bias of the {response}, cycle {cycle} (%)"
    for response, cycle in (("mean", 1), ("mean", 2), ("interval", 2))
}
FIRST = {"mean": (0.3, 10.0), "interval": (10.0, 100.0)}
"""Core-minutes that the page shows first, by response."""
RESULTS = {
    "mean": "mean maximum closure of a case",
    "interval": "indifference interval of Young's modulus",
}


def coverage(surfaces: int, sampling: float) -> str:
    """Count in how many of 100 studies the bound of the total error holds."""
    return f"{100 * total_error.coverage(surfaces, sampling):.0f}"


def _of_means(method: str) -> pd.DataFrame:
    """Return a method's means of the first cycle, by rock, without control variates."""
    table = stored("accuracy_biases", "accuracy_methods").set_index("rock")
    return rows_of(table, response="mean", cycle=1, method=method, control_variates=False)


def bias(method: str) -> str:
    """Give the least and the largest error [%] of a method's means of the first cycle."""
    sizes = _of_means(method).bias_percent.abs()
    return f"{sizes.min():.0f} to {sizes.max():.0f}"


def seconds(method: str) -> str:
    """Give the time [s] of a surface by a method, as it was measured with the biases."""
    times = _of_means(method).cost
    return f"{times.min():.2f} to {times.max():.2f}"


def dearer() -> str:
    """Give the time of `accurate` over that of the paper's steps, least and most of the rocks."""
    ratios = _of_means("accurate").cost / _of_means("paper").cost
    return f"{ratios.min():.1f} to {ratios.max():.1f}"


def floor(response: str, cycle: int) -> str:
    """Give the total error [%] below which no number of surfaces leads: that of the bias."""
    rows = rows_of(stored("accuracy_biases", "accuracy_split"), response=response, cycle=cycle)
    last = rows.loc[rows.budget.idxmax()]
    return f"{abs(last.bias_percent) + last.bias_error_percent:.2g}"


def worth(response: str) -> str:
    """Give how many plain simulations an adjusted one replaces, independent draws, cycle 1."""
    table = stored("variance_reduction", "variance_reduction")
    values = rows_of(table, response=response, cycle=1, draws="independent").worth
    return f"{values.min():.0f} to {values.max():.0f}"


def of_commit() -> str:
    """Name the commit at which biases and times were measured."""
    return f"`{origin('accuracy_biases')['commit'][:7]}`"


def _interval(name: str, digits: int, value: str = "{}_error_percent") -> str:
    """Form of an error and its confidence interval."""
    form = f"{{{value}:+.{digits}f}} ({{{{}}_low:+.{digits}f}} to {{{{}}_high:+.{digits}f}})"
    return form.replace("{}", name)


def _error_of(cycle: int) -> Form:
    """Write a setting's error and confidence interval, of the rock where it is largest."""

    def cell(group: Group) -> str:
        costs = stored("accuracy", "accuracy_cost").fillna({"value": ""})
        value = "" if pd.isna(group["value"]) else group["value"]
        part = rows_of(costs, scene=group["scene"], knob=group["knob"], value=value, cycle=cycle)
        worst = part.loc[part.mean_error_percent.abs().idxmax()]
        held = worst.mean_error_percent != 0.0
        return _interval("mean", 1).format_map(worst) if held else "reference"

    return cell


presets = Table(
    "accuracy/accuracy_settings",
    {
        "preset": "{preset}",
        "radii": lambda group: radii_words(group["scene"]),
        "numerics": lambda group: group["numerics"].strip("{}").replace('"', "") or "the paper's",
        "error of cycle 1 (%)": _error_of(1),
        "error of cycle 2 (%)": _error_of(2),
        "time": "{relative_time:.2g}",
        "s": "{seconds:.2g}",
    },
    prepare=lambda table: table[table.preset.notna() & table.scene.isin(SCENES.values())],
)


def _name(group: Group) -> str:
    return "bearing-area law" if group["method"] == "surrogate" else group["method"]


def _method(group: Group) -> str:
    return _name(group) + ", control variates" * group["control_variates"]


def _shown_first(table: pd.DataFrame) -> pd.DataFrame:
    """Choose two budgets of each response: the least that is of use, and much time."""
    return pd.concat(
        rows_of(table, response=response, budget=budget)
        for response, budgets in FIRST.items()
        for budget in budgets
    ).sort_values(["response", "cycle", "budget"], ascending=[False, True, True])


first = Table(
    "accuracy_biases/accuracy_split",
    {
        "result": lambda group: f"{RESULTS[group['response']]}, cycle {group['cycle']}",
        "core-minutes": "{budget:g}",
        "total error (%)": "{total_percent:.2g}",
        "method": lambda group: f"{_method(group)}, {group['surfaces']} surfaces",
    },
    prepare=_shown_first,
)
biases = Table(
    "accuracy_biases/accuracy_methods",
    {"s a surface": "{cost min:.2g}"},
    rows={"method": _name, "rock": "{rock}"},
    across="{title}",
    cell=_interval("bias", 1, "{}_percent"),
    prepare=lambda table: titled(
        rows_of(table, control_variates=False), BIASES, "response", "cycle"
    ),
)
sources = Table(
    "accuracy/accuracy_sources",
    rows={"source": "{source}"},
    across="{rock}, cycle {cycle}",
    cell="{error_percent!p} ({low!p} to {high!p})",
    prepare=chosen(scene="paper_size"),
)

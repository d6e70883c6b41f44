"""Tables of docs/accuracy.md."""

from collections.abc import Callable

import pandas as pd
from stored import stored

from content.markdown import Form, grouped, listed, rows_of
from jointclosure.config.presets import SCENES, radii_words

MOST_SHOWN = 100.0
"""Total errors [%] beyond which a budget is not shown."""


def presets() -> str:
    """Tabulate presets, what they stand for, their errors, and their time."""
    settings = stored("accuracy", "accuracy_settings")
    shown = settings[settings.preset.notna() & settings.scene.isin(SCENES.values())]
    columns = {
        "preset": "{preset}",
        "radii": lambda row: radii_words(row["scene"]),
        "numerics": lambda row: row["numerics"].strip("{}").replace('"', "") or "the paper's",
        "error of cycle 1 (%)": _error_of(1),
        "error of cycle 2 (%)": _error_of(2),
        "time": "{relative_time:.2g}",
        "FFT pairs": "{pairs:.0f}",
        "s": "{seconds:.2g}",
    }
    return listed(shown, columns)


def _error_of(cycle: int) -> Form:
    """Write a setting's error and confidence interval, of the rock where it is largest."""
    costs = stored("accuracy", "accuracy_cost").fillna({"value": ""})

    def cell(row: dict) -> str:
        value = "" if pd.isna(row["value"]) else row["value"]
        part = rows_of(costs, scene=row["scene"], knob=row["knob"], value=value, cycle=cycle)
        worst = part.loc[part.mean_error_percent.abs().idxmax()]
        if worst.mean_error_percent == 0.0:
            return "held against"
        return f"{worst.mean_error_percent:+.1f} ({worst.mean_low:+.1f} to {worst.mean_high:+.1f})"

    return cell


def total() -> str:
    """Tabulate the best split of each budget, by response and cycle."""
    table = stored("accuracy", "accuracy_split")
    columns = {
        "of": "{response}, cycle {cycle}",
        "core-minutes": "{budget:g}",
        "by": lambda row: row["method"] + ", control variates" * row["control_variates"],
        "surfaces closed": "{surfaces}",
        "measured": lambda row: row["measured"] or "",
        "bias (%)": "{bias_percent:.1f}",
        "known to ± (%)": "{bias_error_percent:.1f}",
        "sampling (%)": "{sampling_percent:.1f}",
        "total error (%)": "{total_percent:.1f}",
    }
    return listed(table[table.total_percent <= MOST_SHOWN], columns)


def biases() -> str:
    """Tabulate biases of methods, and their cost a surface."""
    table = rows_of(stored("accuracy", "accuracy_methods"), control_variates=False)

    def bias(response: str, cycle: int) -> Callable:
        def cell(part: pd.DataFrame) -> str:
            part = part[(part.response == response) & (part.cycle == cycle)]
            form = "{bias_percent:+.1f} ({bias_low:+.1f} to {bias_high:+.1f})"
            return form.format_map(part.iloc[0]) if len(part) else ""

        return cell

    columns: dict[str, Callable] = {
        f"bias of the {response}, cycle {cycle} (%)": bias(response, cycle)
        for response, cycle in (("mean", 1), ("mean", 2), ("interval", 2))
    }
    columns["s a surface"] = lambda part: f"{part.cost.min():.2g}"
    return grouped(table, {"method": "method", "rock": "rock"}, columns)


def sources() -> str:
    """Tabulate where the error of the paper's setting comes from."""
    table = rows_of(stored("accuracy", "accuracy_sources"), scene="paper_size")
    columns: dict[str, Form] = {name: f"{{{name}}}" for name in ("rock", "cycle", "source")}
    columns |= {"error (%)": _small("error_percent"), "low": _small("low"), "high": _small("high")}
    return listed(table, columns)


def _small(name: str) -> Form:
    """Write a percentage to a tenth, and below that to one digit."""
    return lambda row: f"{row[name]:.1f}" if abs(row[name]) >= 0.1 else f"{row[name]:.1g}"


def orders() -> str:
    """Tabulate observed orders of convergence, or why there is none."""
    table = stored("accuracy", "accuracy_orders")
    table = table[~table.knob.str.contains("tolerance|preset")].round(2)
    columns = ["variant", "rock", "knob", "cycle", "order", "error", "remark"]
    titles = table.rename(columns={"scene": "variant"})
    return listed(titles, {name: f"{{{name}}}" for name in columns})


def joints() -> str:
    """Tabulate what grid spacing and patch size do: other joints, and no errors."""
    table = stored("accuracy", "accuracy_cost")
    table = table[table.knob.isin(["spacing", "patch"])]
    columns = {name: f"{{{name}}}" for name in ("rock", "knob", "value", "cycle")}
    for measure, title in (
        ("mean", "change of mean max. closure (%)"),
        ("net", "net of bulk indentation (%)"),
    ):
        form = "{{{0}_error_percent:+.0f}} ({{{0}_low:+.0f}} to {{{0}_high:+.0f}})"
        columns[title] = form.format(measure)
    return listed(table, columns | {"time / base": "{relative_time:.1f}"})


def variance() -> str:
    """Tabulate what control variates are worth, and how often their intervals cover."""
    table = stored("paper", "variance_reduction")
    table = table[table.response != "slope"]
    draws = table.response.str.cat(table.draws + " draws", sep=", ")
    table = table.assign(response=draws.where(table.response == "difference", table.response))

    def coverage(kind: str) -> Callable:
        return lambda part: _range(100.0 * part[f"{kind}_coverage"].dropna())

    columns = {f"coverage, {kind} (%)": coverage(kind) for kind in ("adjusted", "plain")}
    return grouped(
        table,
        {"response": "response", "cycle": "cycle"},
        columns,
        across="rock",
        cell=lambda part: _range(part.worth),
    )


def _range(values: pd.Series) -> str:
    """Write the least and the largest value, to two digits."""
    if values.empty:
        return ""
    ends = [f"{float(f'{end:.2g}'):g}" for end in (values.min(), values.max())]
    return " to ".join(dict.fromkeys(ends))


def _laws() -> pd.DataFrame:
    """Read constants and errors of the bearing-area law on all kinds of walls."""
    kinds = ("surrogate_roll_off", "surrogate_no_roll_off")
    table = pd.concat([stored(kind, "surrogate") for kind in kinds], ignore_index=True)
    known = "roll-off " + table.roll_off_mm.map("{:g} mm".format)
    return table.assign(walls=known.where(table.roll_off_mm.notna(), "no roll-off"))


def surrogate() -> str:
    """Tabulate errors of the bearing-area law, for kinds of walls, rocks, roughness and stress."""
    table = rows_of(_laws(), constants="all")
    table = table.assign(JRC=table.jrc.map("{:g}".format))
    top = table.stress_MPa.max()

    def at(ratio: float) -> Callable:
        return lambda part: f"{rows_of(part, stress_over_strength=ratio).rms_percent.item():.0f}"

    def last(part: pd.DataFrame) -> str:
        (row,) = part[part.stress_MPa > 0.999 * top].itertuples()
        return f"{row.rms_percent:.0f} ({row.mean_percent:+.0f})"

    columns = {"joints": lambda part: part.joints.max()}
    columns |= {f"{ratio:g} σc": at(ratio) for ratio in (0.01, 0.03, 0.05, 0.1, 0.15)}
    rows = {"walls": "walls", "rock": "rock", "JRC": "JRC"}
    return grouped(table, rows, columns | {f"{top:.0f} MPa": last})


def constants() -> str:
    """Tabulate constants of the law on kinds of walls, of all rocks and of single ones."""
    table = _laws().drop_duplicates(["walls", "constants", "at_strength"]).round(3)
    columns = {
        "walls": "{walls}",
        "fitted to": lambda row: row["rock"] if row["constants"] == "own" else "all four",
        "a": "{at_strength}",
        "b": "{exponent}",
    }
    return listed(table, columns)


def limits() -> str:
    """Tabulate what walls must have for the law to be used on them."""
    titles = {
        "height_over_slope_m": "RMS of the summed heights / RMS slope (m)",
        "slope_ratio": "RMS slope at 0.5 mm / at 0.25 mm",
        "correlation": "correlation of slopes",
    }
    columns = {"walls": "{walls}"}
    columns |= {title: f"{{least_{name}:.3g}} to {{most_{name}:.3g}}"
                for name, title in titles.items()}  # fmt: skip
    return listed(_laws().drop_duplicates("walls"), columns)

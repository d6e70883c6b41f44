"""Tables of docs/speed.md and docs/decisions/0010-resolved-breakage.md, of benchmarks."""

import pandas as pd
from stored import stored

from content.markdown import Form, grouped, listed, written

AXES = {
    "cells": "cells along a square grid",
    "stress_mpa": "maximum normal stress (MPa)",
    "realisations": "realisations of a case",
    "jrc": "JRC",
}


def _spread(name: str) -> str:
    """Form of a median with the extremes behind it."""
    return f"{{{name}!k}} ({{{name} min!k}} to {{{name} max!k}})"


def study() -> str:
    """Tabulate a simulation of the paper's study, by rock."""
    columns = {
        "rock": "{rock}",
        "FFT pairs": _spread("pairs"),
        "ms": _spread("ms"),
        "of it breaking": "{breaking %:.0f} %",
        "equilibrium": "{equilibrium %:.0f} %",
        "breakage steps": lambda row: f"{row['breakage steps'] / 1e6:.1f} million",
        "products with the interaction": "{products!k}",
    }
    return listed(stored("solver_speed", "study"), columns)


def elastic() -> str:
    """Tabulate closure curves without breakage."""
    columns = {
        "walls": "{walls}",
        "cells": "{cells} x {cells}",
        "ms": _spread("ms"),
        "FFT pairs": "{pairs!k}",
        "FFT pairs of its own size": "{pairs of own size!k}",
        "products a stress": "{products per stress!k}",
        "largest memory (MB)": "{peak MB!k}",
    }
    return listed(stored("solver_speed", "elastic"), columns)


def reference() -> str:
    """Tabulate the paper's loop against the fast solver."""
    columns = {
        "scene": "{scene}",
        "cells": "{cells} x {cells}",
        "the paper's loop (s)": _spread("reference s"),
        "fast solver (ms)": _spread("fast ms"),
        "ratio": _spread("ratio"),
        "fast less reference (% of closure)": "{difference %:+.2f} ± {standard error %:.2f}",
    }
    return listed(stored("solver_speed", "reference"), columns)


def growth() -> str:
    """Tabulate exponents of time."""
    table = stored("growth", "growth")
    table = table.assign(axis=table.axis.map(AXES))

    def cell(end: int, form: str):
        return lambda part: written(form, part.iloc[end].to_dict())

    columns = {
        "from": cell(0, "{value:g}: {ms!k} ms"),
        "to": cell(-1, "{value:g}: {ms!k} ms"),
        "exponent": cell(0, "{exponent:.2f} ± {standard error:.2f}"),
    }
    return grouped(table, {"what grows": "axis", "scene": "scene"}, columns)


def peers() -> str:
    """Tabulate other codes on the same walls."""
    columns = {
        "code": lambda row: f"{row['code']} {row['version']}".removesuffix(" -"),
        "solves": "{solves}",
        "error": "{error:.0e}",
        "ms": "{ms!k}",
        "FFT pairs": "{pairs:.0f}",
        "closure at 30 MPa (um)": "{um at 30 MPa:.1f}",
    }
    return listed(stored("peers", "peers"), columns)


def breakage_methods() -> str:
    """Tabulate resolved breakage beside the paper's steps."""
    table = stored("breakage_methods", "breakage_methods")
    columns = _of_two(table, "resolved {}", "fixed_step {}", "resolved over fixed")
    return listed(table, {"rock": "{rock}"} | columns)


def versions() -> str:
    """Tabulate the study's simulations beside those of an earlier version."""
    table = stored("versions", "versions")
    columns = {"rock": "{rock}"} | _of_two(table, "{} now", "{} before", "time over")
    for cycle in (1, 2):
        form = f"{{cycle {cycle} %:+.2f}} ± {{cycle {cycle} +- %:.2f}}"
        columns[f"closure, cycle {cycle} (%)"] = form
    return listed(table, columns)


def _of_two(table: pd.DataFrame, one: str, other: str, over: str) -> dict[str, Form]:
    """Columns of two that were timed in turn: the ratio of times, and what both took.

    ``one`` and ``other`` make the names of their columns; the other's numbers are in brackets.
    """
    columns: dict[str, Form] = {
        "time over that in brackets": f"{{{over}:.2f}} ± {{{over} +-:.2f}}",
        "of single surfaces": "{least of a surface:.2f} to {largest of a surface:.2f}",
    }
    for name in ("pairs", "ms", "states", "equilibria", "products"):
        if one.format(name) in table:
            title = "FFT pairs" if name == "pairs" else name
            columns[title] = f"{{{one.format(name)}:,.0f}} ({{{other.format(name)}:,.0f}})"

    def millions(row: dict) -> str:
        steps, beside = (1e-6 * row[form.format("breakage steps")] for form in (one, other))
        return f"{steps:.1f} ({beside:.1f})"

    return columns | {"breakage steps (million)": millions}

"""Renew what the documents show of the benchmarks.

Run by hand after these, which write to build/benchmarks; with names, such as `idle_interaction`,
for these tables alone:

    python benchmarks/solver_speed.py --output build/benchmarks
    python benchmarks/growth.py --output build/benchmarks
    python benchmarks/peers.py --output build/benchmarks/peers.csv
    python benchmarks/breakage_methods.py --output build/benchmarks
    python benchmarks/idle_interaction.py --output build/benchmarks
    python benchmarks/versions.py --output build/benchmarks
"""

import shutil
import sys

import pandas as pd
from markers import fill
from publish_measured import ROOT, markdown

from jointclosure.storage.text import read_csv

MEASURED = ROOT / "build/benchmarks"
AXES = {
    "cells": "cells along a square grid",
    "stress_mpa": "maximum normal stress (MPa)",
    "realisations": "realisations of a case",
    "jrc": "JRC",
}


def spans(table: pd.DataFrame, name: str) -> list[str]:
    """Medians, and the extremes behind them."""
    columns = (table[each].map(round_to_three) for each in (name, f"{name} min", f"{name} max"))
    return [f"{middle} ({low} to {high})" for middle, low, high in zip(*columns, strict=True)]


def round_to_three(value: float) -> str:
    """A number to three figures, without an exponent."""
    return f"{float(f'{value:.3g}'):,.15g}"


def study() -> str:
    """A simulation of the paper's study, by rock."""
    table = read_csv(MEASURED / "study.csv")
    shown = {
        "rock": table.rock,
        "FFT pairs": spans(table, "pairs"),
        "ms": spans(table, "ms"),
        "of it breaking": [f"{share:.0f} %" for share in table["breaking %"]],
        "equilibrium": [f"{share:.0f} %" for share in table["equilibrium %"]],
        "breakage steps": [f"{steps / 1e6:.1f} million" for steps in table["breakage steps"]],
        "products with the interaction": table.products.map(round_to_three),
    }
    return markdown(pd.DataFrame(shown))


def elastic() -> str:
    """Closure curves without breakage."""
    table = read_csv(MEASURED / "elastic.csv")
    shown = {
        "walls": table.walls,
        "cells": [f"{cells} x {cells}" for cells in table.cells],
        "ms": spans(table, "ms"),
        "FFT pairs": table.pairs.map(round_to_three),
        "FFT pairs of its own size": table["pairs of own size"].map(round_to_three),
        "products a stress": table["products per stress"].map(round_to_three),
        "largest memory (MB)": table["peak MB"].map(round_to_three),
    }
    return markdown(pd.DataFrame(shown))


def reference() -> str:
    """The paper's loop against the fast solver."""
    table = read_csv(MEASURED / "reference.csv")
    shown = {
        "scene": table.scene,
        "cells": [f"{cells} x {cells}" for cells in table.cells],
        "the paper's loop (s)": spans(table, "reference s"),
        "fast solver (ms)": spans(table, "fast ms"),
        "ratio": spans(table, "ratio"),
        "fast less reference (% of closure)": [
            f"{row['difference %']:+.2f} ± {row['standard error %']:.2f}"
            for _, row in table.iterrows()
        ],
    }
    return markdown(pd.DataFrame(shown))


def growth() -> str:
    """Exponents of time."""
    table = read_csv(MEASURED / "growth.csv")
    rows = []
    for (axis, scene), part in table.groupby(["axis", "scene"], sort=False):
        first, last = part.iloc[0], part.iloc[-1]
        rows.append(
            {
                "what grows": AXES[axis],
                "scene": scene,
                "from": f"{first['value']:g}: {round_to_three(first.ms)} ms",
                "to": f"{last['value']:g}: {round_to_three(last.ms)} ms",
                "exponent": f"{first.exponent:.2f} ± {first['standard error']:.2f}",
            }
        )
    return markdown(pd.DataFrame(rows))


def peers() -> str:
    """Other codes on the same walls."""
    table = read_csv(MEASURED / "peers.csv")
    shown = {
        "code": [f"{row.code} {row.version}".removesuffix(" -") for row in table.itertuples()],
        "solves": table.solves,
        "error": [f"{error:.0e}" for error in table.error],
        "ms": table.ms.map(round_to_three),
        "FFT pairs": table.pairs.map("{:.0f}".format),
        "closure at 30 MPa (um)": table["um at 30 MPa"].map("{:.1f}".format),
    }
    return markdown(pd.DataFrame(shown))


def breakage_methods() -> str:
    """Resolved breakage beside the paper's steps."""
    table = read_csv(MEASURED / "breakage_methods.csv")
    shown = {"rock": table.rock}
    shown |= _of_two(table, "resolved {}", "fixed_step {}", "resolved over fixed")
    return markdown(pd.DataFrame(shown))


def _of_two(table: pd.DataFrame, one: str, other: str, over: str) -> dict:
    """Columns of two that were timed in turn: the ratio of times, and what each took.

    ``one`` and ``other`` make the names of their columns; the other's numbers are in brackets.
    """

    def both(name: str, shown: str = "{:,.0f}", scale: float = 1.0) -> list[str]:
        pairs = zip(scale * table[one.format(name)], scale * table[other.format(name)], strict=True)
        return [f"{shown.format(own)} ({shown.format(beside)})" for own, beside in pairs]

    extremes = zip(table["least of a surface"], table["largest of a surface"], strict=True)
    columns = {
        "time over that in brackets": [
            f"{ratio:.2f} ± {error:.2f}"
            for ratio, error in zip(table[over], table[f"{over} +-"], strict=True)
        ],
        "of single surfaces": [f"{least:.2f} to {most:.2f}" for least, most in extremes],
        "FFT pairs": both("pairs"),
    }
    for name in ("ms", "states", "equilibria", "products"):
        if one.format(name) in table:
            columns[name] = both(name)
    steps = both("breakage steps", "{:.1f}", 1e-6)
    return columns | {"breakage steps (million)": steps}


def idle_interaction() -> str:
    """What leaving the idle interaction out saves and moves."""
    table = read_csv(MEASURED / "idle_interaction.csv")
    moved = [name.removesuffix(" +- %") for name in table.columns if name.endswith(" +- %")]
    moved = [name for name in moved if not name.endswith(" saved")]
    shown = {
        "rock": table.rock,
        "tolerance (%)": table["share %"].map("{:g}".format),
        "left out up to (% of 30 MPa)": table["left out up to (% of 30 MPa)"].map("{:.0f}".format),
        "time saved (%)": _saved(table, "time"),
        "products saved (%)": _saved(table, "products"),
    } | {f"closure, {name} (%)": changes(table, name) for name in moved}
    shown["single joints beyond the tolerance (%)"] = table["single closures beyond %"].map(
        "{:.0f}".format
    )
    shown["largest change of one (%)"] = table["largest of single closures %"].map("{:.0f}".format)
    return markdown(pd.DataFrame(shown))


def _saved(table: pd.DataFrame, name: str) -> list[str]:
    pairs = zip(table[f"{name} saved %"], table[f"{name} saved +- %"], strict=True)
    return [f"{saved:.0f} ± {error:.0f}" for saved, error in pairs]


def versions() -> str:
    """The study's simulations beside those of an earlier version."""
    table = read_csv(MEASURED / "versions.csv")
    shown = {"rock": table.rock} | _of_two(table, "{} now", "{} before", "time over")
    shown |= {f"closure, cycle {cycle} (%)": changes(table, f"cycle {cycle}") for cycle in (1, 2)}
    return markdown(pd.DataFrame(shown))


def changes(table: pd.DataFrame, name: str) -> list[str]:
    """Changes in percent with their standard errors."""
    pairs = zip(table[f"{name} %"], table[f"{name} +- %"], strict=True)
    return [f"{change:+.2f} ± {error:.2f}" for change, error in pairs]


SPEED = ROOT / "docs/speed.md"
OF_SPEED = (study, versions, elastic, peers, reference, growth)
PARTS = {part.__name__: (SPEED, part) for part in OF_SPEED} | {
    "breakage_methods": (ROOT / "docs/decisions/0010-resolved-breakage.md", breakage_methods),
    "idle_interaction": (ROOT / "docs/effects.md", idle_interaction),
}


def main(names: list[str]) -> None:
    """Fill the documents, and copy the figure."""
    for name in names or PARTS:
        document, part = PARTS[name]
        fill(document, {name: part()})
        if name == "growth":
            shutil.copy(MEASURED / "growth.png", ROOT / "docs/images/growth.png")


if __name__ == "__main__":
    main(sys.argv[1:])

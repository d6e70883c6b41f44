"""Renew what the documents show of the studies of accuracy and effects.

Run by hand after `make accuracy` or `make effects`: `publish_measured.py accuracy`. The table that
presets come from is copied too (src/jointclosure/config/accuracy_settings.csv).
"""

import shutil
import sys
from pathlib import Path

import pandas as pd
from markers import fill

from jointclosure.config.presets import SCENES, radii_words
from jointclosure.storage.text import read_csv

ROOT = Path(__file__).parents[2]
ACCURACY, EFFECTS = ROOT / "results/accuracy", ROOT / "results/effects"


def markdown(table: pd.DataFrame) -> str:
    """A table whose columns are its headings."""
    cells = [["" if pd.isna(cell) else str(cell) for cell in row] for row in table.to_numpy()]
    rows = [table.columns, ["---"] * table.shape[1], *cells]
    return "".join("| " + " | ".join(row) + " |\n" for row in rows)


def _span(part: pd.DataFrame) -> str:
    """An error, and its confidence interval: that of the rock where it is largest."""
    worst = part.loc[part.mean_error_percent.abs().idxmax()]
    return f"{worst.mean_error_percent:+.1f} ({worst.mean_low:+.1f} to {worst.mean_high:+.1f})"


def presets() -> str:
    """Presets, what they stand for, what they were off by, and their time."""
    settings = read_csv(ACCURACY / "tables/accuracy_settings.csv")
    costs = read_csv(ACCURACY / "tables/accuracy_cost.csv")
    rows = []
    for row in settings[settings.preset.notna()].itertuples():
        if row.scene not in SCENES.values():
            continue
        here = (costs.scene == row.scene) & (costs.knob == row.knob)
        own = costs[here & (costs["value"].fillna("") == ("" if pd.isna(row.value) else row.value))]
        errors = {}
        for cycle in (1, 2):
            part = own[own.cycle == cycle]
            held = (part.mean_error_percent != 0.0).any()
            errors[f"error of cycle {cycle} (%)"] = _span(part) if held else "held against"
        rows.append(
            {
                "preset": row.preset,
                "radii": radii_words(row.scene),
                "numerics": row.numerics.strip("{}").replace('"', "") or "the paper's",
            }
            | errors
            | {
                "time": f"{row.relative_time:.2g}",
                "FFT pairs": f"{row.pairs:.0f}",
                "s": f"{row.seconds:.2g}",
            }
        )
    return markdown(pd.DataFrame(rows))


def sources() -> str:
    """Where the error of the paper's setting comes from."""
    table = read_csv(ACCURACY / "tables/accuracy_sources.csv")
    table = table[table.scene == "paper_size"]
    return markdown(
        pd.DataFrame(
            {
                "rock": table.rock,
                "cycle": table.cycle,
                "source": table.source,
                "error (%)": table.error_percent.round(1),
                "low": table.low.round(1),
                "high": table.high.round(1),
            }
        )
    )


def orders() -> str:
    """Observed orders of convergence, or why there is none."""
    table = read_csv(ACCURACY / "tables/accuracy_orders.csv")
    table = table[~table.knob.str.contains("tolerance")]
    columns = ["variant", "rock", "knob", "cycle", "order", "error", "remark"]
    return markdown(table.rename(columns={"scene": "variant"})[columns].round(2))


def joints() -> str:
    """What grid spacing and patch size do: other joints, not errors."""
    table = read_csv(ACCURACY / "tables/accuracy_cost.csv")
    table = table[table.knob.isin(["spacing", "patch"])]
    shown = table[["rock", "knob", "value", "cycle"]].copy()
    for measure, title in (
        ("mean", "change of mean max. closure (%)"),
        ("net", "net of bulk indentation (%)"),
    ):
        parts = table[[f"{measure}_{part}" for part in ("error_percent", "low", "high")]]
        shown[title] = [
            f"{change:+.0f} ({low:+.0f} to {high:+.0f})"
            for change, low, high in parts.itertuples(index=False)
        ]
    return markdown(shown.assign(**{"time / base": table.relative_time.round(1)}))


def choice() -> str:
    """How the chosen effects held."""
    return markdown(read_csv(EFFECTS / "tables/effects_auto_summary.csv").round(2))


def contributions() -> str:
    """What each effect adds, by stress, as medians over rocks and roughness."""
    table = read_csv(EFFECTS / "tables/effects.csv")
    columns = {
        "max_closure_added_percent": "max. closure (%)",
        "residual_closure_added_percent": "residual closure (%)",
        "hysteresis_added_percent": "hysteresis (% of work)",
        "time_ratio": "time with / without",
    }
    middle = table.groupby(["effect", "cycle", "stress_MPa"], sort=False)[list(columns)].median()
    middle = middle.rename(columns=columns).round({**dict.fromkeys(columns.values(), 1)})
    return markdown(middle.reset_index())


PLACES = {
    "accuracy": (
        ROOT / "docs/accuracy.md",
        {"presets": presets, "sources": sources, "orders": orders, "joints": joints},
    ),
    "effects": (ROOT / "docs/effects.md", {"choice": choice, "contributions": contributions}),
}
FIGURES = {
    "accuracy": {"accuracy_regularised": "accuracy", "accuracy_sources": "accuracy_sources"},
    "effects": {"effects": "effects", "effects_auto": "effects_auto"},
}


def main(study: str) -> None:
    """Fill the document of a study, and copy its figures."""
    path, parts = PLACES[study]
    fill(path, {name: content() for name, content in parts.items()})
    for figure, image in FIGURES[study].items():
        source = ROOT / f"results/{study}/figures/{figure}.png"
        shutil.copy(source, ROOT / f"docs/images/{image}.png")
    if study == "accuracy":
        table = ACCURACY / "tables/accuracy_settings.csv"
        shutil.copy(table, ROOT / "src/jointclosure/config/accuracy_settings.csv")


if __name__ == "__main__":
    main(sys.argv[1])

"""Renew what the documents show of the studies of accuracy and effects, and of the paper's.

Run by hand after `make accuracy`, `make effects`, `make mismatch` or `make study`:
`publish_measured.py accuracy`, `effects`, `mismatch` or `paper`; after
`.venv/bin/snakemake total_error --configfile config/accuracy.yaml`, `total`; or, after
`make study CONFIG=config/no_roll_off.yaml` and
`.venv/bin/snakemake --configfile config/no_roll_off.yaml surrogate`, `no_roll_off`; after
`make study` and `.venv/bin/snakemake surrogate`, `roll_off`. Tables that the package ships are
copied too: those of presets and of the bearing-area law (src/jointclosure/config/).
"""

import math
import shutil
import sys
from pathlib import Path

import pandas as pd
from markers import fill

from jointclosure.config.files import SURROGATES
from jointclosure.config.presets import SCENES, radii_words
from jointclosure.storage.text import read_csv

ROOT = Path(__file__).parents[2]
ACCURACY, EFFECTS = ROOT / "results/accuracy", ROOT / "results/effects"
MISMATCH = ROOT / "results/mismatch"
PAPER = ROOT / "results/paper"


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


def total() -> str:
    """The best split of each budget, by response and cycle."""
    table = read_csv(ACCURACY / "tables/accuracy_split.csv")
    table = table[table.total_percent <= _MOST_SHOWN]
    shown = {
        "of": table.response.str.cat(table.cycle.astype(str), sep=", cycle "),
        "core-minutes": table.budget.map("{:g}".format),
        "by": table.method.where(~table.control_variates, table.method + ", control variates"),
        "surfaces closed": table.surfaces,
        "measured": table.measured.replace(0, pd.NA),
        "bias (%)": table.bias_percent.round(1),
        "known to ± (%)": table.bias_error_percent.round(1),
        "sampling (%)": table.sampling_percent.round(1),
        "total error (%)": table.total_percent.round(1),
    }
    return markdown(pd.DataFrame(shown))


_MOST_SHOWN = 100.0
"""Total errors [%] beyond which a budget is not shown."""


def biases() -> str:
    """What each method is off by, and its cost a surface."""
    table = read_csv(ACCURACY / "tables/accuracy_methods.csv")
    table = table[~table.control_variates]
    rows = []
    for (method, rock), part in table.groupby(["method", "rock"], sort=False):
        row = {"method": method, "rock": rock}
        for response, cycle in (("mean", 1), ("mean", 2), ("interval", 2)):
            own = part[(part.response == response) & (part.cycle == cycle)]
            row[f"bias of the {response}, cycle {cycle} (%)"] = (
                f"{own.bias_percent.item():+.1f} "
                f"({own.bias_low.item():+.1f} to {own.bias_high.item():+.1f})"
                if len(own)
                else ""
            )
        rows.append(row | {"s a surface": f"{part.cost.min():.2g}"})
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
                "error (%)": table.error_percent.map(_small),
                "low": table.low.map(_small),
                "high": table.high.map(_small),
            }
        )
    )


def _small(percent: float) -> str:
    """To a tenth of a percent, and below that to one digit."""
    return f"{percent:.1f}" if abs(percent) >= 0.1 else f"{percent:.1g}"


def orders() -> str:
    """Observed orders of convergence, or why there is none."""
    table = read_csv(ACCURACY / "tables/accuracy_orders.csv")
    table = table[~table.knob.str.contains("tolerance|preset")]
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


def variance() -> str:
    """What control variates are worth, and how often their intervals cover."""
    table = read_csv(PAPER / "tables/variance_reduction.csv")
    table["response"] = table.response.str.cat(table.draws + " draws", sep=", ").where(
        table.response == "difference", table.response
    )
    rows = []
    for (response, cycle), part in table[table.response != "slope"].groupby(
        ["response", "cycle"], sort=False
    ):
        row = {"response": response, "cycle": cycle}
        row |= {rock: _range(own.worth, 2) for rock, own in part.groupby("rock", sort=False)}
        for kind in ("adjusted", "plain"):
            covered = 100.0 * part[f"{kind}_coverage"].dropna()
            row[f"coverage, {kind} (%)"] = _range(covered, 2) if len(covered) else ""
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def _range(values: pd.Series, digits: int) -> str:
    """Least and largest value, to so many digits."""
    ends = [f"{float(f'{end:.{digits}g}'):g}" for end in (values.min(), values.max())]
    return " to ".join(dict.fromkeys(ends))


def _shipped_laws() -> pd.DataFrame:
    """Constants and errors of the bearing-area law on all kinds of walls, as shipped."""
    table = pd.concat([read_csv(path) for path in SURROGATES], ignore_index=True)
    known = "roll-off " + table.roll_off_mm.map("{:g} mm".format)
    return table.assign(walls=known.where(table.roll_off_mm.notna(), "no roll-off"))


def surrogate() -> str:
    """What the bearing-area law is off by, for each kind of walls, rock, roughness and stress."""
    table = _shipped_laws()
    table = table[table.constants == "all"]
    top = table.stress_MPa.max()
    rows = []
    for (walls, rock, jrc), part in table.groupby(["walls", "rock", "jrc"], sort=False):
        row = {"walls": walls, "rock": rock, "JRC": f"{jrc:g}", "joints": part.joints.max()}
        for ratio in (0.01, 0.03, 0.05, 0.1, 0.15):
            row[f"{ratio:g} σc"] = (
                f"{part.rms_percent[part.stress_over_strength == ratio].item():.0f}"
            )
        last = part[part.stress_MPa > 0.999 * top]
        row[f"{top:.0f} MPa"] = f"{last.rms_percent.item():.0f} ({last.mean_percent.item():+.0f})"
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def constants() -> str:
    """Constants of the law on each kind of walls, of all rocks and of each."""
    table = _shipped_laws().drop_duplicates(["walls", "constants", "at_strength"])
    shown = {
        "walls": table.walls,
        "fitted to": table.rock.where(table.constants == "own", "all four"),
        "a": table.at_strength.round(3),
        "b": table.exponent.round(3),
    }
    return markdown(pd.DataFrame(shown))


def limits() -> str:
    """What walls must have for the law to be used on them."""
    titles = {
        "height_over_slope_m": "RMS of the summed heights / RMS slope (m)",
        "slope_ratio": "RMS slope at 0.5 mm / at 0.25 mm",
        "correlation": "correlation of slopes",
    }
    rows = []
    for walls, part in _shipped_laws().groupby("walls", sort=False):
        first, row = part.iloc[0], {"walls": walls}
        for name, title in titles.items():
            row[title] = f"{first[f'least_{name}']:.3g} to {first[f'most_{name}']:.3g}"
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def choice() -> str:
    """How the chosen effects held, a column for each tolerance."""
    table = read_csv(EFFECTS / "tables/effects_auto_summary.csv")
    said = {
        "changed": (
            f"something was left out, of {table.scenes[0]:.0f} conditions",
            "{:.0f}",
        ),
        "held_percent": ("error within the tolerance (% of all)", "{:.0f}"),
        "largest_error_percent": ("largest error (%)", "{:.1f}"),
        "saved_percent": ("time saved, of all conditions together (%)", "{:.1f}"),
        "saved_where_changed_percent": ("where something was left out (%)", "{:.0f}"),
        "saved_where_unchanged_percent": ("where all effects act (%)", "{:.1f}"),
        "pilot_percent": ("time of the pilots, of all (%)", "{:.1f}"),
        "largest_pilot_percent": ("largest, where all effects act (%)", "{:.1f}"),
        "least_saved_percent": ("time saved where it is least (%)", "{:.0f}"),
        "timing_scatter_percent": ("scatter of times where both did the same (%)", "{:.1f}"),
    }
    rows = [
        {"": words}
        | {
            f"tolerance {100.0 * tolerance:g} %": shown.format(value)
            for tolerance, value in zip(table.tolerance, table[name], strict=True)
        }
        for name, (words, shown) in said.items()
    ]
    return markdown(pd.DataFrame(rows))


def contributions() -> str:
    """What each effect adds, by stress: medians over rocks and roughness, and the extremes."""
    table = read_csv(EFFECTS / "tables/effects.csv")
    columns = {
        "max_closure_added_percent": "max. closure (%)",
        "residual_closure_added_percent": "residual closure (%)",
        "hysteresis_added_percent": "hysteresis (% of work)",
        "time_ratio": "time with / without",
    }
    rows = []
    for about, part in table.groupby(["effect", "cycle", "stress_MPa"], sort=False):
        row = dict(zip(("effect", "cycle", "stress (MPa)"), about, strict=True))
        known = part.max_closure_added_percent.notna().sum()
        row["conditions"] = f"{known} of {len(part)}"
        row |= {title: _median_and_extremes(part[name]) for name, title in columns.items()}
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def _median_and_extremes(values: pd.Series) -> str:
    known = values.dropna()
    if known.empty:
        return ""
    return f"{known.median():.1f} ({known.min():.1f} to {known.max():.1f})"


def _with_error(part: pd.Series, error: pd.Series) -> list[str]:
    """Values with their standard errors, to two digits of these."""
    cells = []
    for value, doubt in zip(part, error, strict=True):
        if not math.isfinite(value):
            cells.append("")
            continue
        digits = min(max(1 - math.floor(math.log10(doubt)), 0), 5) if doubt > 0.0 else 5
        value = round(value, digits) + 0.0  # no negative zero
        cells.append(f"{value:.{digits}f} ± {doubt:.{digits}f}")
    return cells


def _mismatch_named(wavelength: float) -> str:
    return {0.0: "0 (mates)", math.inf: "independent"}.get(wavelength, f"{wavelength:g}")


def mismatched() -> str:
    """Closure, stiffness, what stays and hysteresis against mismatch, without a shift."""
    table = read_csv(MISMATCH / "tables/mismatch.csv")
    table = table[table.shift_mm == 0.0]
    columns = {
        "closure_net_since_seating_mm": "net closure since 0.5 MPa (mm)",
        "normal_stiffness_net_MPa_per_mm": "net stiffness above 5 MPa (MPa/mm)",
        "residual_net_at_seating_mm": "residual at seating (mm)",
        "hysteresis": "hysteresis (share of work)",
        "aperture_at_seating_mm": "aperture at seating (mm)",
    }
    shown = {
        "mismatch wavelength (mm)": table.wavelength_mm.map(_mismatch_named),
        "cycle": table.cycle,
    }
    for column, title in columns.items():
        shown[title] = _with_error(table[column], table[f"{column}_error"])
    return markdown(pd.DataFrame(shown))


def unmated() -> str:
    """The shift from which on walls behave as independent ones."""
    table = read_csv(MISMATCH / "tables/mismatch_shifts.csv")
    largest = read_csv(MISMATCH / "tables/mismatch.csv").shift_mm.max()

    def told(value: float) -> str:
        return f"{value:.2g}" if math.isfinite(value) else f"over {largest:g}"

    return markdown(
        pd.DataFrame(
            {
                "mismatch wavelength (mm)": table.wavelength_mm.map(_mismatch_named),
                "shift (mm)": table.shift_mm.map(told),
                "low": table.low.map(told),
                "high": table.high.map(told),
                "in apertures": table.apertures.map(
                    lambda value: f"{value:.1f}" if math.isfinite(value) else ""
                ),
            }
        )
    )


def between() -> str:
    """What natural walls lie between, in a sentence."""
    table = read_csv(MISMATCH / "tables/mismatch.csv")
    first = table[(table.shift_mm == 0.0) & (table.cycle == 1)].set_index("wavelength_mm")
    resolved = first[(first.residual_net_at_seating_mm > 0.0) & (first.index < math.inf)]
    free, near = first.loc[math.inf], resolved.iloc[0]
    return (
        f"From a mismatch wavelength of {near.name:g} mm to independent walls the first cycle's "
        f"net closure since seating goes from {near.closure_net_since_seating_mm:.2g} to "
        f"{free.closure_net_since_seating_mm:.2g} mm, the net stiffness above 5 MPa from "
        f"{near.normal_stiffness_net_MPa_per_mm:.0f} to "
        f"{free.normal_stiffness_net_MPa_per_mm:.0f} MPa/mm, "
        "and the share of it that stays after unloading from "
        f"{100 * near.residual_share_net:.0f} to {100 * free.residual_share_net:.0f} %. The second "
        "cycle hardly depends on the mismatch.\n"
    )


OF_LAWS = {"constants": constants, "surrogate": surrogate, "limits": limits}
PLACES = {
    "accuracy": (
        ROOT / "docs/accuracy.md",
        {"presets": presets, "sources": sources, "orders": orders, "joints": joints},
    ),
    "total": (ROOT / "docs/accuracy.md", {"total": total, "biases": biases}),
    "mismatch": (
        ROOT / "docs/mismatch.md",
        {"between": between, "mismatched": mismatched, "unmated": unmated},
    ),
    "effects": (ROOT / "docs/effects.md", {"choice": choice, "contributions": contributions}),
    "paper": (ROOT / "docs/accuracy.md", {"variance": variance}),
    "no_roll_off": (ROOT / "docs/accuracy.md", OF_LAWS),
    "roll_off": (ROOT / "docs/accuracy.md", OF_LAWS),
}
FOLDERS = {"total": "accuracy", "roll_off": "paper"}
"""Folders of results that are not named as what is published of them."""
FIGURES = {
    "accuracy": {"accuracy_regularised": "accuracy", "accuracy_sources": "accuracy_sources"},
    "total": {"accuracy_total": "accuracy_total"},
    "effects": {"effects": "effects", "effects_auto": "effects_auto"},
    "mismatch": {"mismatch": "mismatch"},
    "paper": {},
    "no_roll_off": {},
    "roll_off": {},
}
SHIPPED = {
    "accuracy": ("accuracy_settings.csv", "accuracy_settings.csv"),
    "total": ("accuracy_methods.csv", "accuracy_methods.csv"),
    "no_roll_off": ("surrogate.csv", "surrogate_no_roll_off.csv"),
    "roll_off": ("surrogate.csv", "surrogate_roll_off.csv"),
}
"""Tables of a study that the package has a copy of, and the copy's name."""


def main(study: str) -> None:
    """Fill the document of a study, and copy its figures."""
    path, parts = PLACES[study]
    folder = ROOT / "results" / FOLDERS.get(study, study)
    if study in SHIPPED:
        table, copy = SHIPPED[study]
        shutil.copy(folder / "tables" / table, ROOT / "src/jointclosure/config" / copy)
    fill(path, {name: content() for name, content in parts.items()})
    for figure, image in FIGURES[study].items():
        shutil.copy(folder / f"figures/{figure}.png", ROOT / f"docs/images/{image}.png")


if __name__ == "__main__":
    main(sys.argv[1])

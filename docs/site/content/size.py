"""Tables and findings of docs/size.md."""

from collections.abc import Callable

import pandas as pd
from stored import ROOT, stored

from content.markdown import MOST, first_row, grouped, listed, rows_of, titled
from jointclosure.config.configuration import configured, merged_study
from jointclosure.experiments.size.table import law_of_size
from jointclosure.statistics.standard_errors import rounded
from jointclosure.storage.text import read_csv

DEFAULT = "roll_off_3mm"
"""The spectrum of the default study."""
BASE = 0.25
"""The spacing [mm] of the joints that others are compared with."""
TITLES = {
    "closure_seated_net": "net closure since seating",
    "closure_net": "net closure from first touch",
    "residual_seated_net": "residual closure",
    "stiffness_net": "net stiffness",
    "kni_net": "k_ni",
    "vm_net": "V_m",
}
COLUMNS = {
    "closure_seated_net_mm": "net closure since 0.5 MPa (mm)",
    "closure_net_mm": "net closure from first touch (mm)",
    "closure_mm": "gross closure from first touch (mm)",
    "residual_closure_mm": "residual closure (mm)",
    "net_stiffness_MPa_per_mm": "net stiffness above 15 MPa (MPa/mm)",
}
SHOWN = {
    (reading, cycle): f"{TITLES[reading]}, cycle {cycle}"
    for reading, cycle in (
        ("closure_seated_net", 1), ("closure_net", 1), ("residual_seated_net", 1),
        ("stiffness_net", 1), ("closure_seated_net", 2), ("closure_net", 2), ("stiffness_net", 2),
    )
}  # fmt: skip
"""Readings that tables of powers and scalings have, and their headings."""
WALL_STRENGTHS = (1.0, 1.2, 1.5, 2.0, 3.0)
"""Strengths of the rock over that of the walls at which the law is evaluated."""


def walls(spectrum: str) -> str:
    """Name a spectrum in words."""
    hurst = "H 0.5" if spectrum.startswith("hurst_05") else "H 0.8"
    length = spectrum.partition("roll_off_")[2].removesuffix("mm")
    free = spectrum in ("no_roll_off", "hurst_05")
    return f"{hurst}, {'no roll-off' if free else f'roll-off {length} mm'}"


def law(reading: str, cycle: int) -> str:
    """Give the ratio of the largest to the smallest patch, and that of Barton and Bandis."""
    table = stored("size", "size_barton_bandis")
    rows = {"spectrum": DEFAULT, "to_mm": MOST, "reading": reading, "cycle": cycle}
    row = first_row(rows_of(table, **rows))
    return f"{rounded(row.ratio, row.error)} ({row.barton_bandis:.2f})"


def patch(end: str) -> str:
    """Give the side [mm] of the smallest ("from") or the largest ("to") patch."""
    return f"{stored('size', 'size_barton_bandis')[f'{end}_mm'].max():g}"


def from_touch(cycle: int) -> str:
    """Give the ratio of net closures from first touch of the largest to the smallest patch."""
    table = rows_of(stored("size", "size"), spectrum=DEFAULT, cycle=cycle, spacing_mm=BASE)
    row = first_row(rows_of(table, patch_mm=MOST))
    return rounded(row.closure_net_mm_ratio, row.closure_net_mm_error)


def best(cycle: int) -> str:
    """State which scaling of net closure since seating is best, and which for the largest patch."""
    table = rows_of(stored("size", "size_collapse"), reading="closure_seated_net", cycle=cycle)
    sizes, together = (
        rows_of(table, between=between).set_index("scaling")
        for between in ("sizes", "sizes and spectra")
    )
    best = first_row(together.sort_values("removed_percent", ascending=False))
    off = {
        row.Index: rounded(row.largest_off_percent, row.largest_off_error)
        for row in sizes.itertuples()
    }
    nearest = sizes.largest_off_percent.idxmin()
    other = f" That patch is told best, to {off[nearest]} %, by {nearest}."
    return (
        f"**Cycle {cycle}**: of the scalings of net closure since seating that by {best.Index} "
        f"({best.exponents.replace('_', ' ')}) removes most of the spread. On realisations that "
        "were not fitted it removes "
        f"{rounded(best.removed_percent, best.removed_error)} % of the mean square spread between "
        f"all sizes and spectra: {best.left_percent:.0f} % rms are left of "
        f"{together.left_percent['none']:.0f} %. The largest patch, not fitted either, is off by "
        f"{off[best.Index]} % rms (without a scaling by {off['none']} %)."
        f"{other if nearest != best.Index else ''}"
    )


def sizes() -> str:
    """Tabulate typical values of the default spectrum, and ratios to the base."""
    table = rows_of(stored("size", "size"), spectrum=DEFAULT)

    def with_ratio(column: str) -> Callable:
        def cell(row: dict) -> str:
            if column.startswith("residual") and row["cycle"] > 1:
                return ""
            ratio = rounded(row[f"{column}_ratio"], row[f"{column}_error"])
            return f"{row[column]:.3g} (x {ratio})"

        return cell

    columns = {"cycle": "{cycle}", "patch (mm)": "{patch_mm:g}", "spacing (mm)": "{spacing_mm:g}"}
    columns |= {title: with_ratio(column) for column, title in COLUMNS.items()}
    return listed(table.sort_values(["cycle", "spacing_mm", "patch_mm"]), columns)


def exponents() -> str:
    """Tabulate exponents of patch length and spacing by spectrum; a star where it is no power."""
    table = stored("size", "size_exponents")
    table = titled(table, {**SHOWN, ("rms_height", 0): "rms height"}, "reading", "cycle")
    table = table.sort_values("of", kind="stable")
    words = {"patch": "patch length", "spacing": "spacing"}
    table = table.assign(of=table.of.map(words), walls=table.spectrum.map(walls))

    def power(part: pd.DataFrame) -> str:
        row = first_row(part)
        return rounded(row.exponent, row.error) + ("*" if row.p < 0.05 else "")

    return grouped(table, {"power of": "of", "walls": "walls"}, across="title", cell=power)


def _by_scaling(between: str, cell: Callable, unit: str = "") -> str:
    """Tabulate scalings in rows, readings in columns."""
    table = rows_of(stored("size", "size_collapse"), between=between)
    titles = {key: title + unit for key, title in SHOWN.items()}
    table = titled(table, titles, "reading", "cycle")
    return grouped(table, {"scaling": "scaling"}, across="title", cell=cell)


def collapse() -> str:
    """Tabulate what each scaling removes of the spread, on realisations that were not fitted."""

    def cell(part: pd.DataFrame) -> str:
        row = first_row(part)
        left = f"{row.left_percent:.0f} % left"
        removed = rounded(row.removed_percent, row.removed_error)
        return left if row.scaling == "none" else f"{removed}; {left}"

    return _by_scaling("sizes and spectra", cell)


def largest() -> str:
    """Tabulate how far the largest patch is off where it was not fitted."""

    def cell(part: pd.DataFrame) -> str:
        row = first_row(part)
        return rounded(row.largest_off_percent, row.largest_off_error)

    return _by_scaling("sizes", cell, " (%)")


def scalings() -> str:
    """Tabulate the exponents of three scalings, of all sizes and spectra."""
    shown = ("patch length, spacing", "rms height, spacing", "depth of 5 %, spacing")
    table = rows_of(stored("size", "size_collapse"), between="sizes and spectra")
    table = titled(table[table.scaling.isin(shown)], SHOWN, "reading", "cycle")
    return grouped(
        table,
        {"scaling": "scaling"},
        across="title",
        cell=lambda part: part.exponents.iloc[0].replace("_", " "),
    )


def barton_bandis() -> str:
    """Tabulate ratios of the largest to the smallest patch, and those of Barton and Bandis."""
    table = rows_of(stored("size", "size_barton_bandis"), to_mm=MOST)
    table = table.assign(
        reading=table.reading.map(TITLES),
        walls=table.spectrum.map(walls),
        law=table.barton_bandis.map("{:.2f}".format),
    )

    def ratio(part: pd.DataFrame) -> str:
        row = first_row(part)
        return rounded(row.ratio, row.error)

    return grouped(
        table,
        {"cycle": "cycle", "of": "reading", "Barton & Bandis": "law"},
        across="walls",
        cell=ratio,
    )


def wall_strengths() -> str:
    """Tabulate what Barton and Bandis say of the largest patch, by the strength of its walls."""
    table = stored("size", "size_barton_bandis")
    times = table.to_mm.max() / table.from_mm.iloc[0]
    typed = configured(merged_study(ROOT / "config/size.yaml"), read_csv).typed
    rock = next(iter(typed.rocks.values()))
    about = rock.jrc, rock.intact.compressive_strength, rock.max_normal_stress
    rows = []
    for ratio in sorted({*WALL_STRENGTHS, typed.output.wall_strength_ratio}):
        for cycle in sorted(table.cycle.unique()):
            changed, small = (law_of_size(factor, about, ratio, cycle) for factor in (times, 1.0))
            row = {TITLES[name]: changed[name] / small[name] for name in changed}
            rows.append({"ratio": ratio, "cycle": cycle} | row)
    columns = {"σc/JCS": "{ratio:g}", "cycle": "{cycle}"}
    laws = (title for title in rows[0] if title in TITLES.values())
    return listed(pd.DataFrame(rows), columns | {title: f"{{{title}:.2f}}" for title in laws})

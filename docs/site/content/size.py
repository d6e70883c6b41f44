"""Tables and numbers of docs/size.md."""

import pandas as pd
from stored import ROOT, stored

from content.markdown import MOST, Form, Group, Table, chosen, markdown, rows_of, titled, value_of
from jointclosure.config.configuration import configured, merged_study
from jointclosure.engine.quantities import HEADINGS, QUANTITIES, titles_of_cycles
from jointclosure.experiments.size.table import law_of_size
from jointclosure.statistics.standard_errors import rounded
from jointclosure.storage.text import read_csv

DEFAULT = "roll_off_3mm"
"""The spectrum of the default study."""
BASE = 0.25
"""The spacing [mm] of the joints that others are compared with."""
COLUMNS = (
    "max_closure_seated_net_mm",
    "max_closure_net_mm",
    "max_closure_mm",
    "residual_closure_seated_net_mm",
    "stiffness_net_MPa_per_mm",
)
SHOWN = titles_of_cycles(
    ("max_closure_seated_net", 1),
    ("max_closure_net", 1),
    ("residual_closure_seated_net", 1),
    ("stiffness_net", 1),
    ("max_closure_seated_net", 2),
    ("max_closure_net", 2),
    ("stiffness_net", 2),
)
"""Readings that tables of powers and scalings have, and their headings."""
SCALINGS = ("patch length, spacing", "rms height, spacing", "depth of 5 %, spacing")
WALL_STRENGTHS = (1.0, 1.2, 1.5, 2.0, 3.0)
"""Strengths of the rock over that of the walls at which the law is evaluated."""


def _walls(group: Group) -> str:
    """Name a spectrum in words."""
    spectrum = group["spectrum"]
    hurst = "H 0.5" if spectrum.startswith("hurst_05") else "H 0.8"
    length = spectrum.partition("roll_off_")[2].removesuffix("mm")
    free = spectrum in ("no_roll_off", "hurst_05")
    return f"{hurst}, {'no roll-off' if free else f'roll-off {length} mm'}"


def _with_ratio(column: str) -> str:
    return f"{{{column}:.3g}} (x {{{column}_ratio±{column}_error}})"


def _sizes(table: pd.DataFrame) -> pd.DataFrame:
    """Choose the default spectrum; residual closures of later cycles are those of the first."""
    table = rows_of(table, spectrum=DEFAULT).sort_values(["cycle", "spacing_mm", "patch_mm"])
    residual = "residual_closure_seated_net_mm"
    return table.assign(**{residual: table[residual].where(table.cycle == 1)})


sizes = Table(
    "size/size",
    {"cycle": "{cycle}", "patch (mm)": "{patch_mm:g}", "spacing (mm)": "{spacing_mm:g}"}
    | {HEADINGS[column]: _with_ratio(column) for column in COLUMNS},
    prepare=_sizes,
)
exponents = Table(
    "size/size_exponents",
    rows={
        "power of": lambda group: group["of"].replace("patch", "patch length"),
        "walls": _walls,
    },
    across="{title}",
    cell=lambda group: group["exponent±error"] + "*" * (group["p"] < 0.05),
    prepare=lambda table: titled(
        table, SHOWN | {("rms_height", 0): "rms height"}, "reading", "cycle"
    ).sort_values("of", kind="stable"),
)


def _of_scalings(between: str, cell: Form, unit: str = "", *only: str) -> Table:
    """Table of scalings in rows, readings in columns."""
    titles = {key: title + unit for key, title in SHOWN.items()}

    def prepare(table: pd.DataFrame) -> pd.DataFrame:
        table = titled(rows_of(table, between=between), titles, "reading", "cycle")
        return table[table.scaling.isin(only)] if only else table

    rows = {"scaling": "{scaling}"}
    return Table("size/size_collapse", {}, rows, "{title}", cell, prepare)


def _removed(group: Group) -> str:
    left = f"{group['left_percent']:.0f} % left"
    fitted = group["scaling"] != "none"
    return f"{group['removed_percent±removed_error']}; {left}" if fitted else left


collapse = _of_scalings("sizes and spectra", _removed)
largest = _of_scalings("sizes", "{largest_off_percent±largest_off_error}", " (%)")
scalings = _of_scalings(
    "sizes and spectra", lambda group: group["exponents"].replace("_", " "), "", *SCALINGS
)
barton_bandis = Table(
    "size/size_barton_bandis",
    rows={
        "cycle": "{cycle}",
        "of": lambda group: QUANTITIES[group["reading"]].title,
        "Barton & Bandis": "{barton_bandis:.2f}",
    },
    across=_walls,
    cell="{ratio±error}",
    prepare=chosen(to_mm=MOST),
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
            row = {QUANTITIES[name].title: f"{changed[name] / small[name]:.2f}" for name in changed}
            rows.append({"σc/JCS": f"{ratio:g}", "cycle": cycle} | row)
    return markdown(pd.DataFrame(rows))


def law(reading: str, cycle: int) -> str:
    """Give the ratio of the largest to the smallest patch, and that of Barton and Bandis."""
    rows = {"spectrum": DEFAULT, "to_mm": MOST, "reading": reading, "cycle": cycle}
    return value_of("size/size_barton_bandis", "{ratio±error} ({barton_bandis:.2f})", **rows)


def power(spectrum: str, cycle: int) -> str:
    """Give the exponent of the patch length in net closure since seating, for a spectrum."""
    rows = {
        "spectrum": spectrum,
        "reading": "max_closure_seated_net",
        "cycle": cycle,
        "of": "patch",
    }
    return value_of("size/size_exponents", "{exponent±error}", **rows)


def patch(end: str) -> str:
    """Give the side [mm] of the smallest ("from") or the largest ("to") patch."""
    return value_of("size/size_barton_bandis", f"{{{end}_mm max:g}}")


def from_touch(cycle: int) -> str:
    """Give the ratio of net closures from first touch of the largest to the smallest patch."""
    rows = {"spectrum": DEFAULT, "cycle": cycle, "spacing_mm": BASE, "patch_mm": MOST}
    return value_of("size/size", "{max_closure_net_mm_ratio±max_closure_net_mm_error}", **rows)


def best(cycle: int) -> str:
    """State which scaling of net closure since seating is best, and which for the largest patch."""
    table = rows_of(stored("size", "size_collapse"), reading="max_closure_seated_net", cycle=cycle)
    alone, together = (
        {row["scaling"]: row for row in rows_of(table, between=between).to_dict("records")}
        for between in ("sizes", "sizes and spectra")
    )
    first = max(together.values(), key=lambda row: row["removed_percent"])
    nearest = min(alone.values(), key=lambda row: row["largest_off_percent"])["scaling"]
    off = {
        name: rounded(row["largest_off_percent"], row["largest_off_error"])
        for name, row in alone.items()
    }
    name = first["scaling"]
    other = (
        f" The best prediction of that patch is by {nearest}, with an error of {off[nearest]} %."
    )
    return (
        f"**Cycle {cycle}**: of the scalings of net closure since seating that by {name} "
        f"({first['exponents'].replace('_', ' ')}) removes most of the spread. On realisations "
        "that were not fitted it removes "
        f"{rounded(first['removed_percent'], first['removed_error'])} % of the mean square spread "
        f"between all sizes and spectra: {first['left_percent']:.0f} % rms are left of "
        f"{together['none']['left_percent']:.0f} %. The largest patch, not fitted either, is off "
        f"by {off[name]} % rms (without a scaling by {off['none']} %)."
        f"{other if nearest != name else ''}"
    )

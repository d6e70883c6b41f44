"""Renew docs/size.md from results/size. Run by hand after `make size`."""

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd
from markers import fill
from publish_measured import markdown

from jointclosure.config.configuration import configured, merged_study
from jointclosure.experiments.size.table import law_of_size
from jointclosure.statistics.standard_errors import rounded
from jointclosure.storage.text import read_csv

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "results/size"
DEFAULT = "roll_off_3mm"
"""The spectrum of the default study."""
BASE = 0.25
"""The spacing [mm] of the joints that others are held against."""
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
WALL_STRENGTHS = (1.0, 1.2, 1.5, 2.0, 3.0)
"""Strengths of the rock over that of the walls at which the law is told."""
SHOWN = (
    ("closure_seated_net", 1),
    ("closure_net", 1),
    ("residual_seated_net", 1),
    ("stiffness_net", 1),
)
SHOWN += (("closure_seated_net", 2), ("closure_net", 2), ("stiffness_net", 2))


def table_of(name: str) -> pd.DataFrame:
    return read_csv(RESULTS / f"tables/{name}.csv")


def said(spectrum: str) -> str:
    """A spectrum in words."""
    hurst = "H 0.5" if spectrum.startswith("hurst_05") else "H 0.8"
    length = spectrum.partition("roll_off_")[2].removesuffix("mm")
    free = spectrum in ("no_roll_off", "hurst_05")
    return f"{hurst}, {'no roll-off' if free else f'roll-off {length} mm'}"


def finding() -> str:
    """What was found, in a few sentences."""
    law = table_of("size_barton_bandis")
    law = law[(law.spectrum == DEFAULT) & (law.to_mm == law.to_mm.max())]
    law = law.set_index(["reading", "cycle"])
    told = {
        which: f"{rounded(own.ratio, own.error)} ({own.barton_bandis:.2f})"
        for which, own in law.iterrows()
    }
    touch = [_from_touch(cycle, law.to_mm.iloc[0]) for cycle in (1, 2)]
    return (
        "**Like for like**, net of the rock's indentation and since seating at 0.5 MPa, as "
        "laboratories count: from a patch of "
        f"{law.from_mm.iloc[0]:g} mm to one of {law.to_mm.iloc[0]:g} mm of the same walls "
        "(those of the default study) closure is multiplied by "
        f"{told['closure_seated_net', 1]} on the first cycle and by "
        f"{told['closure_seated_net', 2]} on the second, net stiffness by "
        f"{told['stiffness_net', 1]} and {told['stiffness_net', 2]}. In brackets: what the scale "
        "corrections of Barton and Bandis say of the same change in size.\n\n"
        f"Net closure *from first touch* is multiplied by {touch[0]} and {touch[1]}: it grows with "
        "the patch because a larger one has higher highest points, on which the walls touch "
        f"before they carry any load that a laboratory would see.\n\n{_best(1)}\n\n{_best(2)}\n"
    )


def _from_touch(cycle: int, patch: float) -> str:
    """Ratio of the net closure from first touch of a patch [mm] to that of the base."""
    table = table_of("size")
    own = table[(table.spectrum == DEFAULT) & (table.cycle == cycle) & (table.spacing_mm == BASE)]
    own = own[own.patch_mm == patch].iloc[0]
    return rounded(own.closure_net_mm_ratio, own.closure_net_mm_error)


def _best(cycle: int) -> str:
    """The scaling that removes most of the spread of a cycle's net closure since seating, and the
    one that predicts the largest patch best, where it is another one."""
    table = table_of("size_collapse")
    own = table[(table.reading == "closure_seated_net") & (table.cycle == cycle)]
    alone, together = (own[own.between == each] for each in ("sizes", "sizes and spectra"))
    best = together.sort_values("removed_percent").iloc[-1]
    plain = together[together.scaling == "none"].iloc[0]
    last = alone[alone.scaling == best.scaling].iloc[0]
    first = alone[alone.scaling == "none"].iloc[0]
    nearest = alone.sort_values("largest_off_percent").iloc[0]
    other = ""
    if nearest.scaling != best.scaling:
        off = rounded(nearest.largest_off_percent, nearest.largest_off_error)
        other = f" That patch is told best, to {off} %, by {nearest.scaling}."
    return (
        f"**Cycle {cycle}**: of the scalings of net closure since seating that by {best.scaling} "
        f"({best.exponents.replace('_', ' ')}) removes most of the spread. On realisations that "
        "were not fitted it removes "
        f"{rounded(best.removed_percent, best.removed_error)} % of the mean square spread between "
        f"all sizes and spectra: {best.left_percent:.0f} % rms are left of "
        f"{plain.left_percent:.0f} %. The largest patch, not fitted either, is off by "
        f"{rounded(last.largest_off_percent, last.largest_off_error)} % rms (without a scaling "
        f"by {rounded(first.largest_off_percent, first.largest_off_error)} %).{other}"
    )


def sizes() -> str:
    """Typical values of the default spectrum, and ratios to the base."""
    table = table_of("size")
    table = table[table.spectrum == DEFAULT]
    rows = []
    for own in table.sort_values(["cycle", "spacing_mm", "patch_mm"]).to_dict("records"):
        row = {
            "cycle": own["cycle"],
            "patch (mm)": f"{own['patch_mm']:g}",
            "spacing (mm)": f"{own['spacing_mm']:g}",
        }
        for column, title in COLUMNS.items():
            ratio = rounded(own[f"{column}_ratio"], own[f"{column}_error"])
            again = column.startswith("residual") and own["cycle"] > 1
            row[title] = "" if again else f"{own[column]:.3g} (x {ratio})"
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def exponents() -> str:
    """Exponents of patch length and spacing by spectrum; a star where it is no power."""
    table = table_of("size_exponents")
    rows = []
    for of, word in (("patch", "patch length"), ("spacing", "spacing")):
        for spectrum in dict.fromkeys(table.spectrum):
            row = {"power of": word, "walls": said(spectrum)}
            for reading, cycle in (*SHOWN, ("rms_height", 0)):
                own = table[
                    (table.of == of) & (table.spectrum == spectrum)
                    & (table.reading == reading) & (table.cycle == cycle)
                ].iloc[0]  # fmt: skip
                title = TITLES.get(reading, "rms height") + (f", cycle {cycle}" if cycle else "")
                star = "*" if own.p < 0.05 else ""
                row[title] = rounded(own.exponent, own.error) + star
            rows.append(row)
    return markdown(pd.DataFrame(rows))


def _by_scaling(between: str, cell: Callable, unit: str = "", only: Sequence[str] = ()) -> str:
    """A row a scaling and a column a reading; ``cell`` makes a row of the table into words."""
    table = table_of("size_collapse")
    table = table[table.between == between]
    rows = []
    for scaling in only or dict.fromkeys(table.scaling):
        row = {"scaling": scaling}
        for reading, cycle in SHOWN:
            own = table[
                (table.scaling == scaling) & (table.reading == reading) & (table.cycle == cycle)
            ].iloc[0]  # fmt: skip
            row[f"{TITLES[reading]}, cycle {cycle}{unit}"] = cell(own)
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def collapse() -> str:
    """What each scaling removes of the spread, on realisations that were not fitted."""

    def cell(own) -> str:
        left = f"{own.left_percent:.0f} % left"
        removed = rounded(own.removed_percent, own.removed_error)
        return left if own.scaling == "none" else f"{removed}; {left}"

    return _by_scaling("sizes and spectra", cell)


def largest() -> str:
    """How far the largest patch is off where it was not fitted."""
    return _by_scaling(
        "sizes", lambda own: rounded(own.largest_off_percent, own.largest_off_error), " (%)"
    )


def scalings() -> str:
    """The exponents of three scalings, of all sizes and spectra."""
    return _by_scaling(
        "sizes and spectra",
        lambda own: own.exponents.replace("_", " "),
        only=("patch length, spacing", "rms height, spacing", "depth of 5 %, spacing"),
    )


def barton_bandis() -> str:
    """Ratios of the largest to the smallest patch, and those of Barton and Bandis."""
    table = table_of("size_barton_bandis")
    table = table[table.to_mm == table.to_mm.max()]
    rows = []
    for (cycle, reading), own in table.groupby(["cycle", "reading"], sort=False):
        row = {"cycle": cycle, "of": TITLES[reading]}
        row["Barton & Bandis"] = f"{own.barton_bandis.iloc[0]:.2f}"
        for each in own.itertuples():
            row[said(each.spectrum)] = rounded(each.ratio, each.error)
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def wall_strengths() -> str:
    """What Barton and Bandis say of the largest patch, by the strength of its walls."""
    table = table_of("size_barton_bandis")
    times = table.to_mm.max() / table.from_mm.iloc[0]
    typed = configured(merged_study(ROOT / "config/size.yaml"), read_csv).typed
    rock = next(iter(typed.rocks.values()))
    about = rock.jrc, rock.intact.compressive_strength, rock.max_normal_stress
    rows = []
    for ratio in sorted({*WALL_STRENGTHS, typed.output.wall_strength_ratio}):
        for cycle in sorted(table.cycle.unique()):
            changed, small = (law_of_size(each, about, ratio, cycle) for each in (times, 1.0))
            rows.append(
                {"σc/JCS": f"{ratio:g}", "cycle": cycle}
                | {TITLES[of]: f"{changed[of] / small[of]:.2f}" for of in changed}
            )
    return markdown(pd.DataFrame(rows))


def main() -> None:
    """Fill the document, and copy its figure."""
    parts = {
        "finding": finding(),
        "sizes": sizes(),
        "exponents": exponents(),
        "collapse": collapse(),
        "largest": largest(),
        "scalings": scalings(),
        "barton bandis": barton_bandis(),
        "wall strengths": wall_strengths(),
    }
    fill(ROOT / "docs/size.md", parts)
    shutil.copy(RESULTS / "figures/size.png", ROOT / "docs/images/size.png")


if __name__ == "__main__":
    main()

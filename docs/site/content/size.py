"""Tables and numbers of docs/size.md."""

from content.markdown import MOST, Group, Table, chosen, titled, value_of
from jointclosure.engine.quantities import QUANTITIES, titles_of_cycles

DEFAULT = "roll_off_3mm"
"""The spectrum of the default study."""
BASE = 0.25
"""The spacing [mm] of the joints that others are compared with."""
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


SCALINGS = ("none", "longest wave, spacing", "rms height", "rms height, rms slope", "depth of 5 %")
"""Scalings whose predictions are shown."""


def _walls(group: Group) -> str:
    """Name a spectrum in words."""
    spectrum = group["spectrum"]
    hurst = "H 0.5" if spectrum.startswith("hurst_05") else "H 0.8"
    length = spectrum.partition("roll_off_")[2].removesuffix("mm")
    free = spectrum in ("no_roll_off", "hurst_05")
    return f"{hurst}, {'no roll-off' if free else f'roll-off {length} mm'}"


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


largest = Table(
    "size/size_collapse",
    rows={"scaling": "{scaling}"},
    across="{title}",
    cell="{largest_off_percent±largest_off_error}",
    prepare=lambda table: titled(
        table[(table.between == "sizes") & table.scaling.isin(SCALINGS)], SHOWN, "reading", "cycle"
    ),
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

"""Tables of docs/speed.md, of benchmarks."""

from stored import origin, stored

from content.markdown import Table, rows_of

AXES = {
    "cells": "cells along a square grid",
    "stress_mpa": "maximum normal stress (MPa)",
    "realisations": "realisations of a case",
    "jrc": "JRC",
}
RATE = "{{{0}!k}} ({{{0} min!k}} to {{{0} max!k}})"
"""A median with the extremes behind it."""


SIMULATIONS = 36 * (20 + 60)
"""Simulations of the default study: cases, each on the study's surfaces and on the pool's."""


def simulation() -> str:
    """Give the time of a simulation of the paper's study [s], least and most of the rocks."""
    seconds = 1e-3 * stored("versions", "versions")["ms now"]
    return f"{seconds.min():.2f} to {seconds.max():.2f}"


def _closing() -> float:
    """Return the processor time [s] of a simulation in a study, walls and jobs included."""
    seconds = rows_of(stored("start_up", "start_up"), part="closing").now.iloc[0]
    return float(seconds) / SIMULATIONS


def closing() -> str:
    """Give the processor time [s] of a simulation in a study, with making its walls."""
    return f"{_closing():.2f}"


def million() -> str:
    """Give the core-hours of a million simulations of the paper's study, with their walls."""
    return f"{float(f'{1e6 * _closing() / 3600.0:.2g}'):.0f}"


def default_study() -> str:
    """Give the processor time [minutes] of the default study: as benchmarked, and as stored."""
    benchmarked = rows_of(stored("start_up", "start_up"), part="study").now.iloc[0] / 60.0
    low, high = sorted((benchmarked, origin("paper")["cpu_minutes"]))
    return f"{low:.0f} to {high:.0f}"


def minutes(run: str, cores: int = 1) -> str:
    """Give the time [minutes] of a stored run, by its processor time, on some free cores."""
    return f"{origin(run)['cpu_minutes'] / cores:.0f}"


study = Table(
    "solver_speed/study",
    {
        "rock": "{rock}",
        "FFT pairs": RATE.format("pairs"),
        "ms": RATE.format("ms"),
        "of it breaking": "{breaking %:.0f} %",
        "equilibrium": "{equilibrium %:.0f} %",
        "breakage steps": lambda group: f"{group['breakage steps'] / 1e6:.1f} million",
        "products with the interaction": "{products!k}",
    },
)
PARTS = {
    "study": "whole study",
    "closing": "of it walls and closures",
    "analysing": "of it tables and figures",
    "start": "of it start of jobs, imports and scheduling",
    "again": "a run with nothing to do",
}


parts_of_study = Table(
    "start_up/start_up",
    {
        "processor time (s)": lambda group: PARTS[group["part"]],
        "commit 6d90d14": "{before!k}",
        "now": "{now!k}",
        "now over before": "{now over before:.2f}",
    },
    prepare=lambda table: table.set_index("part").loc[list(PARTS)].reset_index(),
)
elastic = Table(
    "solver_speed/elastic",
    {
        "walls": "{walls}",
        "cells": "{cells} x {cells}",
        "ms": RATE.format("ms"),
        "FFT pairs": "{pairs!k}",
        "FFT pairs of its own size": "{pairs of own size!k}",
        "products a stress": "{products per stress!k}",
        "largest memory (MB)": "{peak MB!k}",
    },
)
reference = Table(
    "solver_speed/reference",
    {
        "scene": "{scene}",
        "cells": "{cells} x {cells}",
        "the paper's loop (s)": RATE.format("reference s"),
        "fast solver (ms)": RATE.format("fast ms"),
        "ratio": RATE.format("ratio"),
        "fast less reference (% of closure)": "{difference %:+.2f} ± {standard error %:.2f}",
    },
)
growth = Table(
    "growth/growth",
    {
        "from": "{value:g}: {ms!k} ms, {MB:.0f} MB",
        "to": "{last value:g}: {last ms!k} ms, {last MB:.0f} MB",
        "exponent at the first": "{exponent:.2f} ± {standard error:.2f}",
        "at the last": "{last exponent:.2f} ± {last standard error:.2f}",
    },
    rows={"what grows": lambda group: AXES[group["axis"]], "scene": "{scene}"},
    prepare=lambda table: table.join(
        table.groupby(["axis", "scene"])[["value", "ms", "MB", "exponent", "standard error"]]
        .transform("last")
        .add_prefix("last ")
    ),
)
growth_beyond = Table(
    "growth/growth_beyond",
    {
        "scene": "{scene}",
        "cells": "{cells} x {cells}",
        "time (s)": "{fitted s!k} ({low s!k} to {high s!k})",
        "exponent there": "{exponent:.2f} ± {standard error:.2f}",
    },
    prepare=lambda table: table.assign(
        **{f"{name} s": 1e-3 * table[f"{name} ms"] for name in ("fitted", "low", "high")}
    ),
)
growth_once = Table(
    "growth_once/growth_once",
    {
        "scene": "{scene}",
        "roll-off (mm)": lambda row: f"{row['roll-off mm']:g}".replace("nan", "none"),
        "time (s)": "{s!k}",
        "memory (MB)": "{MB!k}",
        "maximum closure (mm)": "{closure mm:.2f}",
    },
)
peers = Table(
    "peers/peers",
    {
        "code": lambda group: f"{group['code']} {group['version']}".removesuffix(" -"),
        "solves": "{solves}",
        "error": "{error:.0e}",
        "ms": "{ms!k}",
        "FFT pairs": "{pairs:.0f}",
        "closure at 30 MPa (um)": "{um at 30 MPa:.1f}",
    },
)
versions = Table(
    "versions/versions",
    {
        "rock": "{rock}",
        "time over that in brackets": "{time over:.2f} ± {time over +-:.2f}",
        "median of single surfaces": "{median ratio:.2f} ({from:.2f} to {to:.2f})",
        "ms": "{ms now:,.0f} ({ms before:,.0f})",
        "FFT pairs": "{pairs now:,.0f} ({pairs before:,.0f})",
        "products": "{products now:,.0f} ({products before:,.0f})",
        "surfaces": "{surfaces}",
    }
    | {
        f"closure, cycle {cycle} (%)": f"{{cycle {cycle} %:+.2f}} ± {{cycle {cycle} +- %:.2f}}"
        for cycle in (1, 2)
    },
)

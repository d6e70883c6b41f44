"""Times of benchmarks: tables and numbers of docs/accuracy.md and docs/size.md."""

from stored import origin, stored

from content.markdown import Table, rows_of

RATE = "{{{0}!k}} ({{{0} min!k}} to {{{0} max!k}})"
"""A median with the extremes behind it."""


def simulation() -> str:
    """Give the time of a simulation of the paper's study [s], least and most of the rocks."""
    seconds = 1e-3 * stored("versions", "versions")["ms now"]
    return f"{seconds.min():.2f} to {seconds.max():.2f}"


def default_study() -> str:
    """Give the processor time [minutes] of the default study: as benchmarked, and as stored."""
    benchmarked = rows_of(stored("start_up", "start_up"), part="study").now.iloc[0] / 60.0
    low, high = sorted((benchmarked, origin("paper")["cpu_minutes"]))
    return f"{low:.0f} to {high:.0f}"


def minutes(run: str, cores: int = 1) -> str:
    """Give the time [minutes] of a stored run, by its processor time, on some free cores."""
    return f"{origin(run)['cpu_minutes'] / cores:.0f}"


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
        "ms": "{ms now:,.0f}",
        "FFT pairs": "{pairs now:,.0f}",
        "products with the interaction": "{products now:,.0f}",
    },
)

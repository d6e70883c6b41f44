"""Tables of the page on the run of a study: checks, failures, errors, timing and provenance."""

import json

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.cli.page import Sheet, given, sheet
from jointclosure.engine.aggregation import succeeded
from jointclosure.joint.protocol import FAILURE
from jointclosure.parameters import PROPERTIES
from studies.frame.config.presets import (
    SCENES,
    anything_breaks,
    numerics_in_full,
    radii_words,
    radius_of,
)

MOST_FAILURES = 500
"""Largest number of failed simulations that are listed."""


def check_sheet(checks: pd.DataFrame) -> Sheet:
    """Tabulate the checks of the results."""
    verdict = np.where(checks.passed, "passed", "FAILED")
    verdict = np.where(checks.required == "reported only", "reported only", verdict)
    columns = {name: name.capitalize() for name in ("ensemble", "check", "required", "found")}
    columns["verdict"] = "Verdict"
    return sheet("checks", "Checks of the results", checks.assign(verdict=verdict), columns)


def accuracy_sheet(costs: pd.DataFrame) -> Sheet:
    """Tabulate error and time of each setting of `make accuracy`."""
    columns = {
        "scene": "Variant of the model",
        "rock": "Rock",
        "knob": "Setting",
        "value": "Value",
        "cycle": "Cycle",
        "mean_error_percent": "Error of the mean closure (%)",
        "mean_low": "From",
        "mean_high": "To",
        "relative_time": "Time over the variant's base",
    }
    return sheet("accuracy-cost", "Error and time of every setting that was tried", costs, columns)


def preset_sheet(measured: pd.DataFrame, configuration: dict, default: dict) -> Sheet:
    """Tabulate errors of the presets of the numerics, and mark the preset of the study.

    Parameters
    ----------
    measured : DataFrame
        As from `studies.accuracy.cost.setting_table`.
    configuration, default : dict
        Configuration of the study, and that of the paper.
    """
    mine = numerics_in_full(configuration)
    changed = {key: value for key, value in mine.items() if value != default["numerics"][key]}
    breaks = anything_breaks(configuration)
    rows = measured[measured.scene.isin(SCENES.values()) & measured.preset.fillna("").ne("")]
    radius = configuration["choices"]["largest_radius_mm"]
    bounded = np.array([radius_of(scene) == radius for scene in rows.scene], dtype=bool)
    same = rows.numerics.map(json.loads).map(lambda numerics: numerics == changed)
    errors = ["error_percent", "bound_percent", "relative_time"]
    columns = {
        "scene": "Radii",
        "preset": "Preset",
        "error_percent": "Error of the mean closure (%)",
        "bound_percent": "At most, by its confidence interval (%)",
        "relative_time": "Time over the paper's steps",
        "mine": "This study's",
    }
    return sheet(
        "presets",
        "Presets of the numerics, with their errors from the study of accuracy",
        rows.assign(
            scene=rows.scene.map(radii_words),
            mine=np.where(bounded & same & breaks, "yes", ""),
            **{name: rows[name].map(lambda value: given(float(f"{value:.2g}"))) for name in errors},
        ),
        columns,
    )


_IN_WORDS = {
    "target_jumped": "Jumped over the target",
    "outside_model_range": "Outside of the model's range",
    "not_converged": "Not converged",
    "breakage_not_at_rest": "Breakage did not come to rest",
    "rigid_contact": "Contact without compliance",
    "stress_not_reached": "Stress not reached",
    "too_many_steps": "Too many steps",
}


def in_words(name: str) -> str:
    """Return the text of a status (docs/reference.md)."""
    return _IN_WORDS.get(name, name.replace("_", " ").capitalize())


def flag_names(study: xr.Dataset) -> dict[int, str]:
    """Return the names of the bits of a status."""
    about = study.status.attrs
    return dict(zip(map(int, about["flag_masks"]), about["flag_meanings"].split(), strict=True))


def status_sheet(study: xr.Dataset, titles: dict[str, str]) -> Sheet:
    """Tabulate the statuses of the simulations of each case."""
    good = succeeded(study)
    frame = pd.DataFrame(
        {
            "rock": [titles[rock] for rock in study.rock.values],
            "parameter": [
                PROPERTIES[p].title if p in PROPERTIES else "as it is"
                for p in study.parameter.values
            ],
            "level": study.level.values,
            "scene": study.scene.values,
            "simulations": study.sizes["realization"],
            "used": good.sum("realization").values,
            "failed": (~good).sum("realization").values,
        }
    )
    columns = {"rock": "Rock", "parameter": "Changed", "level": "Level"}
    columns |= {"simulations": "Simulations", "used": "Used (n)", "failed": "Failed"}
    for mask, name in flag_names(study).items():
        frame[name] = ((study.status & mask) > 0).sum("realization").values
        if mask < FAILURE or frame[name].any():
            columns[name] = in_words(name)
    columns["scene"] = "Effects that act"
    return sheet("statuses", "Statuses by case", frame, columns)


def failure_sheet(study: xr.Dataset) -> Sheet:
    """Tabulate every failed simulation, with the seed of its walls."""
    flags = flag_names(study)
    rows = []
    statuses = study.status.transpose("case", "realization").values
    seeds = study.seed.transpose("case", "realization").values
    failed = np.argwhere(statuses >= FAILURE)
    for i, j in failed[:MOST_FAILURES]:
        status = int(statuses[i, j])
        rows.append(
            {
                "case": study.case.values[i],
                "realization": int(study.realization.values[j]),
                "status": ", ".join(
                    in_words(name) for mask, name in flags.items() if status & mask
                ),
                "seed": str(seeds[i, j]),
            }
        )
    columns = {"case": "Case", "realization": "Realisation", "status": "Status"}
    columns["seed"] = "Seed of its walls"
    caption = "Failed simulations"
    if len(failed) > MOST_FAILURES:
        caption += f", the first {MOST_FAILURES} of {len(failed)}"
    return sheet("failures", caption, pd.DataFrame(rows, columns=list(columns)), columns)


def simulation_time_sheet(study: xr.Dataset, titles: dict[str, str]) -> Sheet:
    """Tabulate the wall-clock time of the simulations of each rock."""
    rows = []
    for rock, title in titles.items():
        seconds = study.timing_simulation.values[study.rock.values == rock].ravel()
        least, low, middle, high, most = np.quantile(seconds, (0.0, 0.05, 0.5, 0.95, 1.0))
        rows.append(
            {"rock": title, "count": seconds.size, "median": middle, "least": least, "low": low}
            | {"high": high, "most": most, "total": seconds.sum()}
        )
    columns = {"rock": "Rock", "count": "Simulations", "median": "Median (s)"}
    columns |= {"least": "Least (s)", "low": "5 % (s)", "high": "95 % (s)", "most": "Most (s)"}
    columns["total"] = "In all (s)"
    return sheet("simulation-times", "Time of a simulation", pd.DataFrame(rows), columns)


def job_time_sheet(benchmarks: pd.DataFrame) -> Sheet:
    """Tabulate time and memory of the workflow's jobs, by rule.

    Parameters
    ----------
    benchmarks : DataFrame
        As from `jointclosure.storage.text.read_benchmarks`.
    """
    seconds = benchmarks.groupby("rule", sort=False).s.agg(["size", "median", "max", "sum"])
    memory = benchmarks.groupby("rule", sort=False).max_rss.max()
    columns = {"rule": "Rule", "size": "Jobs", "median": "Median (s)", "max": "Longest (s)"}
    columns |= {"sum": "In all (s)", "memory": "Largest memory (MB)"}
    return sheet("jobs", "Time of the jobs", seconds.assign(memory=memory).reset_index(), columns)

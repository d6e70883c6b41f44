"""Experiment on global sensitivity: variance indices of properties and of open choices."""

from collections.abc import Mapping
from textwrap import fill
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from jointclosure.ensembles.quantities import titles_of_cycles
from jointclosure.plotting.style import styled, subplots
from studies.frame.configuration import Configuration
from studies.frame.experiments import Experiment, Jobs, Tables
from studies.frame.panels import PanelColumn, Row, legend_below, legend_keys, panels, point_key
from studies.frame.settings import Point
from studies.global_sensitivity.design import (
    check_sampling,
    sampling_of,
    settings_of_rock,
)
from studies.global_sensitivity.tables import (
    RESPONSES_AND_LOOP,
    conclusion_tables,
    datasets_by_rock,
    global_elasticity_table,
    index_table,
)
from studies.paper.tables_1_to_3 import figure_text


def global_sensitivity_jobs(study: Configuration) -> Jobs:
    """Make a job for each rock and block of rows; added rows change no complete block."""
    sampling = sampling_of(study)
    jobs = {}
    for rock in sampling.rocks:
        settings = settings_of_rock(sampling, study, rock)
        for rows in sampling.blocks():
            jobs[f"{rock}.{rows.start}"] = [
                Point({"rock": rock, "row": row, "point": place}, settings(row, point))
                for row in rows
                for place, point in enumerate(sampling.points()[row])
            ]
    return jobs


def tabulate_indices(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Compute first and total indices and Shapley effects of every input."""
    return index_table(settings["sampling"], datasets_by_rock(joints))


def tabulate_elasticities(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Fit the elasticities of closures with respect to the inputs."""
    return global_elasticity_table(settings["sampling"], datasets_by_rock(joints))


def tabulate_conclusions(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Compute the share of the open choices for which each conclusion holds."""
    return conclusion_tables(settings["sampling"], datasets_by_rock(joints))[0]


def tabulate_margins(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Compute the shares of inputs in the variance of the margins of conclusions."""
    return conclusion_tables(settings["sampling"], datasets_by_rock(joints))[1]


_SURFACES = "surfaces"
"""Value of the column ``input`` in rows of a table of indices that are of the surfaces."""
SHOWN = titles_of_cycles(
    ("max_closure", 1),
    ("max_closure", 2),
    ("max_closure_net", 2),
    ("residual_closure_seated_net", 1),
    ("compliance_net", 1),
    ("compliance_net", 2),
)
"""Title of each panel, by response and cycle."""
_WIDTH = 1.96
_LEAST_INDEX = 0.02
"""Total index below which an input is not drawn."""
_ROWS = "rows of the design"


@styled
def index_figure(table: pd.DataFrame, titles: dict[str, str]) -> Figure:
    """Draw first-order (hollow) and total indices of inputs by response, with 95 % intervals.

    Inputs are left out whose total indices are all below `_LEAST_INDEX`. ``titles`` are those of
    the rocks by name.
    """
    most = table.groupby(["rock", "response", "cycle"]).rows.transform("max")
    whole = table[(table.rows == most) & (table.input != _SURFACES)]
    shown = whole[[entry in SHOWN for entry in zip(whole.response, whole.cycle, strict=True)]]
    largest = shown.groupby("input").total.max()
    known = list(dict.fromkeys(whole.input))
    names = [name for name in known if largest.get(name, 0.0) >= _LEAST_INDEX] or known
    labels = [figure_text(whole.title[whole.input == name].iloc[0]) for name in names]
    rocks = list(dict.fromkeys(whole.rock))
    height = 2.0 + 1.5 * len(names)
    figure, grid = subplots(3, 2, figsize=(7.4, height), sharex=True, sharey=True)
    places = np.arange(len(names))[::-1]
    for axes, ((response, cycle), title) in zip(grid.flat, SHOWN.items(), strict=True):
        for number, rock in enumerate(rocks):
            part = whole[(whole.rock == rock) & (whole.response == response)]
            part = part[part.cycle == cycle].set_index("input").reindex(names)
            at = places + 0.2 * ((len(rocks) - 1) / 2.0 - number)
            for kind, face in (("total", f"C{number}"), ("first", "white")):
                axes.errorbar(
                    part[kind], at, xerr=_WIDTH * part[f"{kind}_error"], fmt=_mark(number),
                    ms=5.0, color=f"C{number}", markerfacecolor=face, lw=0.8,
                    zorder=3 if kind == "first" else 2,
                )  # fmt: skip
        axes.axvline(0.0, color="0.6", lw=0.8, zorder=0)
        axes.set_title(fill(title, 34), fontsize=11)
        axes.set_yticks(places, [fill(label, 21) for label in labels])
        axes.grid(axis="y", lw=0.3)
    for axes in grid[-1]:
        axes.set_xlabel("share of the variance of the mean")
    keys = [
        point_key(figure_text(titles[rock]), _mark(number), color=f"C{number}")
        for number, rock in enumerate(rocks)
    ]
    keys.append(point_key("total index", color="0.3"))
    keys.append(point_key("first-order index", color="0.3", markerfacecolor="white"))
    legend_below(figure, keys, columns=3)
    return figure


def _mark(number: int) -> str:
    """Return the marker of a rock by its number."""
    return "osD^vP"[number % 6]


def convergence_figure(table: pd.DataFrame, titles: dict[str, str]) -> Figure:
    """Draw total indices of both cycles over the number of rows, with 95 % intervals."""
    table = table[(table.response == "max_closure") & (table.input != _SURFACES)]
    table = table.assign(input=table.title.map(figure_text), **{_ROWS: table.rows + table.left_out})
    rows = [
        Row(f"total index, cycle {cycle}", table[table.cycle == cycle], "total", "total_error")
        for cycle in (1, 2)
    ]
    columns = [
        PanelColumn(_ROWS, "input", {"rock": rock}, "log", titles.get(rock, ""))
        for rock in dict.fromkeys(table.rock) or [""]  # axes alone without any rock
    ]
    return panels(rows, columns, {}, bars=_WIDTH, reference=0.0, sharey=True)


@styled
def conclusion_figure(table: pd.DataFrame, titles: dict[str, str]) -> Figure:
    """Draw the share of the open choices for which each conclusion holds, with 95 % intervals."""
    if table.empty:
        figure, axes = subplots(figsize=(6.0, 2.0), layout=None)
        axes.set_axis_off()
        axes.text(0.5, 0.5, "not all four properties vary", ha="center")
        return figure
    rocks = [*(rock for rock in dict.fromkeys(table.rock) if rock != "all"), "all"]
    colours = {rock: f"C{number}" for number, rock in enumerate(rocks)} | {"all": "0.15"}
    unique = table[["number", "conclusion"]].drop_duplicates().sort_values("number")
    rows = list(unique.itertuples(index=False))
    height = 2.0 + 1.1 * len(rows)
    figure, grid = subplots(2, 2, figsize=(7.4, height), sharex=True, sharey=True)
    places = np.arange(len(rows))[::-1]
    cases = [
        (response, cycle) for cycle in (1, 2) for response in ("max_closure", "max_closure_net")
    ]
    for axes, (response, cycle) in zip(grid.flat, cases, strict=True):
        here = table[(table.response == response) & (table.cycle == cycle)]
        for number, rock in enumerate(rocks):
            part = here[here.rock == rock].set_index("number").reindex([row[0] for row in rows])
            axes.errorbar(
                100.0 * part.share, places + 0.14 * ((len(rocks) - 1) / 2.0 - number),
                xerr=100.0 * np.array([part.share - part.share_low, part.share_high - part.share]),
                fmt="X" if rock == "all" else _mark(number), ms=5.0, color=colours[rock], lw=0.8,
                label=titles.get(rock, "in all rocks at once"),
            )  # fmt: skip
        for place, row in zip(places, rows, strict=True):
            if row.number not in set(here.number):
                word = {"ha": "center", "va": "center", "color": "0.4", "fontsize": 9}
                axes.text(50.0, place, "not judged", **word)
        net = ", net of bulk\nindentation" if response == "max_closure_net" else ""
        axes.set_title(f"cycle {cycle}{net}", fontsize=11)
        axes.set_yticks(
            places,
            [fill(f"{row.number}: {row.conclusion}".replace("sigma_c", "σc"), 27) for row in rows],
            fontsize=9,
        )
        axes.set_xlim(-4.0, 104.0)
        axes.grid(axis="y", lw=0.3)
    for axes in grid[-1]:
        axes.set_xlabel("share of combinations (%)")
    legend_below(figure, legend_keys(grid.flat[:1]))
    return figure


def draw_indices(tables: Tables, settings: Mapping[str, Any]) -> Figure:
    """Draw the indices of every input."""
    return index_figure(tables["global_sensitivity_indices"], settings["titles"])


def draw_convergence(tables: Tables, settings: Mapping[str, Any]) -> Figure:
    """Draw the convergence of the indices with the rows."""
    return convergence_figure(tables["global_sensitivity_indices"], settings["titles"])


def draw_conclusions(tables: Tables, settings: Mapping[str, Any]) -> Figure:
    """Draw the shares of choices for which conclusions hold."""
    return conclusion_figure(tables["global_sensitivity_conclusions"], settings["titles"])


EXPERIMENT = Experiment(
    title="global sensitivity to properties and open choices that vary together",
    quantities=RESPONSES_AND_LOOP,
    jobs=global_sensitivity_jobs,
    tables={
        "global_sensitivity_indices.csv": tabulate_indices,
        "global_sensitivity_elasticities.csv": tabulate_elasticities,
        "global_sensitivity_conclusions.csv": tabulate_conclusions,
        "global_sensitivity_margins.csv": tabulate_margins,
    },
    figures={
        "global_sensitivity_indices": draw_indices,
        "global_sensitivity_convergence": draw_convergence,
        "global_sensitivity_conclusions": draw_conclusions,
    },
    settings=lambda study: {
        "sampling": sampling_of(study),
        "titles": study.titles,
    },
    check=check_sampling,
)

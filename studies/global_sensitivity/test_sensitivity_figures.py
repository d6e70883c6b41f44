"""Figures of the sensitivity study show what they are given; people look at the rest."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from studies.global_sensitivity.figures import convergence
from studies.global_sensitivity.table import INDEX_COLUMNS
from studies.paper.sensitivity_figures import predictive_figure
from tests.studied import study_of

ROCKS = study_of({"study": {"rocks": ["dolerite", "slate"]}}).rocks


@pytest.fixture
def drawn():
    keys = [(rock, "jrc", cycle) for rock in ROCKS for cycle in (1, 2)]
    random = np.random.default_rng(1)
    percent = 20.0 * random.lognormal(0.0, 0.3, size=(4, 400))
    percent[1, :100] = np.inf  # dolerite, cycle 2
    coordinates = {
        name: ("entry", np.array(column, dtype=object))
        for name, column in zip(
            ("rock", "parameter", "cycle"), zip(*keys, strict=True), strict=True
        )
    }
    variables = {"percent": percent, "null_percent": 3.0 * percent}
    return xr.Dataset(
        {name: (("entry", "repetition"), values) for name, values in variables.items()},
        coords=coordinates,
    )


PAPER = pd.DataFrame(
    {"rock": ["dolerite", "dolerite"], "parameter": ["jrc"] * 2, "cycle": [1, 2],
     "paper_length": [0.9, np.nan], "paper_percent": [11.0, np.nan]}
)  # fmt: skip


def test_the_papers_entries_are_marked_and_its_dashes_stand_in_the_column_of_dashes(drawn):
    figure = predictive_figure(drawn, PAPER, ROCKS, 20)
    first, second = figure.axes
    (entry,) = [line for line in first.lines if line.get_marker() == "D"]
    assert float(entry.get_xdata()[0]) == 11.0
    (dash,) = [line for line in second.lines if line.get_marker() == "D"]
    assert float(dash.get_xdata()[0]) > 500.0
    assert [text.get_text() for text in second.texts] == ["25 %", "0 %"]
    assert [text.get_text() for text in first.get_yticklabels()] == ["Dolerite", "Slate"]
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "the paper" in labels
    assert "studies of 20 draws, unpaired t test" in labels


def test_no_two_inputs_look_alike_where_colours_repeat():
    inputs = [f"input {number}" for number in range(12)]
    rows = [
        {"rock": "slate", "response": "max_closure", "cycle": cycle, "rows": count, "left_out": 0}
        | {"input": name, "title": name, "total": 0.1, "total_error": 0.01}
        for cycle in (1, 2)
        for count in (64, 128)
        for name in inputs
    ]
    figure = convergence(pd.DataFrame(rows), {"slate": "Slate"})
    lines = [container[0] for container in figure.axes[0].containers]
    looks = {(line.get_color(), line.get_marker()) for line in lines}
    assert len(looks) == len(lines) == 12


def test_ticks_of_convergence_are_the_rows_of_the_response_that_is_drawn():
    row = {"rock": "slate", "input": "jrc", "title": "JRC", "total": 0.1, "total_error": 0.01}
    rows = [
        row | {"cycle": cycle, "response": response, "rows": count, "left_out": 0}
        for cycle in (1, 2)
        for response, count in (("max_closure", 64), ("compliance_net", 63))
    ]
    axes = convergence(pd.DataFrame(rows), {"slate": "Slate"}).axes[-1]
    assert axes.get_xticks().tolist() == [64.0]
    assert axes.get_xlabel() == "rows of the design"


def test_without_any_index_convergence_has_axes_alone():
    """All rows of a design may have failed."""
    figure = convergence(pd.DataFrame(columns=list(INDEX_COLUMNS)), {})
    assert [axes.containers for axes in figure.axes] == [[], []]

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


def test_without_any_index_convergence_has_axes_alone():
    """All rows of a design may have failed."""
    figure = convergence(pd.DataFrame(columns=list(INDEX_COLUMNS)), {})
    assert [axes.containers for axes in figure.axes] == [[], []]

"""Figures of the study of accuracy show what they are given; people look at the rest."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from matplotlib.transforms import Bbox

from jointclosure.ensemble.cases import BASE
from jointclosure.plotting.accuracy import KNOB_TITLES, error_sources, work_precision

PAPER = "the paper's steps"
FRONT = "none is faster and more exact; hollow marks count as equal"


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")


def row(rock, cycle, knob, value, error, low, high, time, other=False):
    return {
        "rock": rock, "cycle": cycle, "knob": knob, "value": value, "mean_error_percent": error,
        "mean_low": low, "mean_high": high, "relative_time": time, "other_joints": other,
    }  # fmt: skip


@pytest.fixture
def costs():
    rows = []
    for rock in ("dolerite", "soft_tuff"):
        for cycle in (1, 2):
            rows += [
                row(rock, cycle, BASE, "", 8.0, 7.0, 9.0, 1.0),
                row(rock, cycle, "steps", 2.0, 15.0, 13.0, 17.0, 0.5),
                row(rock, cycle, "steps", 0.25, -0.5, -1.0, 0.2, 4.0),  # not told from none
                row(rock, cycle, "steps", 0.125, 0.001, -0.1, 0.1, 8.0),  # below the floor
                row(rock, cycle, "resolved", 0.005, 0.0, 0.0, 0.0, 6.0),  # the finest
                row(rock, cycle, "shift", 3.0, 40.0, 30.0, 50.0, 1.0, other=True),
            ]
    rows.append(row("soft_tuff", 2, "resolved", 0.02, 1.0, 0.5, 1.5, 2.0))
    return pd.DataFrame(rows)


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_there_is_a_panel_for_each_rock_and_cycle_with_both_axes_named(costs):
    figure = work_precision(costs, "the model as stated", PAPER)
    titles = [axes.get_title() for axes in figure.axes]
    assert titles == [
        "Dolerite, cycle 1", "Soft tuff, cycle 1", "Dolerite, cycle 2", "Soft tuff, cycle 2",
    ]  # fmt: skip
    assert [axes.get_ylabel() for axes in figure.axes[::2]] == [
        "error of mean max. closure (%)"
    ] * 2
    for axes in figure.axes[2:]:
        assert axes.get_xlabel() == "time a simulation / that of the marked setting"
    assert {axes.get_xscale() + axes.get_yscale() for axes in figure.axes} == {"loglog"}
    assert figure.get_suptitle() == "the model as stated"


def test_every_knob_that_is_drawn_in_some_panel_is_in_the_legend_and_other_joints_are_not(costs):
    names = legend(work_precision(costs, "", PAPER))
    assert set(names) == {
        KNOB_TITLES["steps"], KNOB_TITLES["resolved"], PAPER, FRONT,
        "not significantly different from zero",
    }  # fmt: skip
    assert len(names) == len(set(names))


def test_a_mark_is_hollow_where_its_interval_includes_zero_and_stands_at_the_floor(costs):
    axes = work_precision(costs, "", PAPER).axes[0]
    marks = {line.get_markerfacecolor() == "w": line for line in axes.lines
             if line.get_marker() == "o"}  # fmt: skip
    np.testing.assert_array_equal(marks[True].get_xydata(), [[4.0, 0.5], [8.0, 0.01]])
    np.testing.assert_array_equal(marks[False].get_xydata(), [[0.5, 15.0]])
    assert [text.get_text() for text in axes.texts] == ["2", "0.25", "0.125"]
    (star,) = [line for line in axes.lines if line.get_marker() == "*"]
    np.testing.assert_array_equal(star.get_xydata(), [[1.0, 8.0]])


def test_what_no_setting_beats_in_both_ends_at_the_first_hollow_mark(costs):
    """It leaves out the finest, and gives no order to errors that are not told from none."""
    axes = work_precision(costs, "", PAPER).axes[0]
    (best,) = [line for line in axes.lines if line.get_label() == FRONT]
    np.testing.assert_array_equal(best.get_xdata(), [0.5, 1.0, 4.0])


def test_the_star_too_is_hollow_where_its_error_is_not_told_from_none(costs):
    unsure = costs.assign(mean_low=costs.mean_low.where(costs.knob != BASE, -1.0))
    for table, hollow in ((costs, False), (unsure, True)):
        figure = work_precision(table, "", PAPER)
        (star,) = [line for line in figure.axes[0].lines if line.get_marker() == "*"]
        assert (star.get_markerfacecolor() == "w") is hollow
        # the key has it as it is where its error is known
        (entry,) = [line for line in figure.legends[0].get_lines() if line.get_marker() == "*"]
        assert entry.get_markerfacecolor() != "w"


def boxes(axes):
    return [text.get_window_extent() for text in axes.texts]


def collisions(found, others=()):
    pairs = [(a, b) for i, a in enumerate(found) for b in found[:i]]
    pairs += [(a, b) for a in found for b in others]
    return sum(a.overlaps(b) for a, b in pairs)


def test_values_beside_marks_cover_neither_each_other_nor_a_mark(costs):
    """Marks at nearly one place, as those of knobs that hardly matter."""
    near = [
        row("dolerite", 1, knob, value, 8.0 + 0.1 * i, 7.0, 9.0, 0.9 + 0.02 * i)
        for i, (knob, value) in enumerate(
            (knob, value)
            for knob in ("force_tolerance", "displacement_step")
            for value in (0.0001, 0.001, 2.0)
        )
    ]
    figure = work_precision(pd.concat([costs, pd.DataFrame(near)]), "", PAPER)
    figure.canvas.draw()
    axes = figure.axes[0]
    marks = [
        Bbox.from_bounds(x - 3, y - 3, 6, 6)
        for line in axes.lines
        if line.get_marker() in ("o", "*")
        for x, y in axes.transData.transform(line.get_xydata())
    ]
    assert len(axes.texts) >= 4
    assert collisions(boxes(axes), marks) == 0


def test_small_bars_bear_values_that_do_not_meet():
    table = pd.DataFrame(
        [
            ("siltstone", 2, "steps", -2.9, -5.8, 0.5),
            ("siltstone", 2, "tolerances", -0.42, np.nan, np.nan),
            ("siltstone", 2, "sampling", 0.94, np.nan, np.nan),
            ("siltstone", 2, "surface rule (hurst 0.6)", 0.83, -2.0, 4.2),
            *(("dolerite", cycle, "sampling", 0.002, 0.001, 0.003) for cycle in (1, 2, 3)),
        ],
        columns=["rock", "cycle", "source", "error_percent", "low", "high"],
    )
    figure = error_sources(table, "")
    figure.canvas.draw()
    (axes,) = figure.axes
    assert [text.get_text() for text in axes.texts] == ["0.4", "0.9", *["0.002"] * 3, "0.8"]
    assert collisions(boxes(axes)) == 0


def test_each_source_of_error_is_a_bar_of_its_size_with_its_interval_and_in_the_legend():
    table = pd.DataFrame(
        [
            ("dolerite", 1, "steps (12.5 um)", -8.0, -9.0, -7.0),
            ("dolerite", 1, "tolerances", 0.2, np.nan, np.nan),
            ("slate", 1, "steps (12.5 um)", 3.0, -1.0, 7.0),
            ("slate", 1, "sampling", 5.0, np.nan, np.nan),  # of one rock only
        ],
        columns=["rock", "cycle", "source", "error_percent", "low", "high"],
    )
    figure = error_sources(table, "where it comes from")
    (axes,) = figure.axes
    assert sorted(bar.get_height() for bar in axes.patches) == [0.2, 3.0, 5.0, 8.0]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [
        "steps", "tolerances", "sampling",
    ]  # fmt: skip
    key = [handle.patches[0].get_facecolor() for handle in axes.get_legend_handles_labels()[0]]
    assert len(set(key)) == 3
    assert {bar.get_facecolor() for bar in axes.patches} == set(key)
    shown = [patch.get_facecolor() for patch in axes.get_legend().get_patches()]
    assert shown == key
    assert [label.get_text() for label in axes.get_xticklabels()] == [
        "Dolerite\ncycle 1", "Slate\ncycle 1",
    ]  # fmt: skip
    spans = [tuple(line.get_ydata()) for line in axes.lines]
    assert spans == [(7.0, 9.0), (0.0, 7.0)]  # of either sign; from 0 where it includes none
    assert [text.get_text() for text in axes.texts] == ["0.2"]  # hardly seen, so named
    assert axes.get_ylabel() == "error, either sign (% of the mean)"
    assert axes.get_title() == "where it comes from"

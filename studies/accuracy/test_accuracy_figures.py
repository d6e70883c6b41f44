"""Figures of the study of accuracy show what they are given; people look at the rest."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.engine.settings import BASE
from jointclosure.plotting.style import StyledFigure
from studies.accuracy.figures import work_precision
from studies.accuracy.labels import Label, label_marks

PAPER = "the paper's steps"
FRONT = "none is faster and more exact; hollow marks count as equal"


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


def test_labels_of_marks_do_not_meet():
    figure = StyledFigure(figsize=(3.0, 3.0))
    axes = figure.add_subplot()
    axes.plot([1.0], [1.0], "*", ms=13)
    axes.plot([1.02, 0.98], [1.0, 1.0], "o", ms=5)
    axes.set(xlim=(0.5, 1.5), ylim=(0.5, 1.5))
    label_marks(axes, [Label("0.5", 1.02, 1.0, "C0"), Label("1", 0.98, 1.0, "C1")])
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == 2
    assert not boxes[0].padded(2.0).overlaps(boxes[1])

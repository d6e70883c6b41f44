"""Panels of tables: lines, bars, ends of axes, names and levels."""

import itertools

import numpy as np
import pandas as pd
import pytest

from studies.frame.panels import Column, Row, panels

FREE = {"wavelength_mm": np.inf}
NAMES = {"wavelength_mm": {0.0: "mated", 1.0: "waves beyond 1 mm mate", np.inf: "independent"}}


def table():
    """Values that say where they belong: a hundred wavelengths and ten shifts and the cycle."""
    rows = [
        (wavelength, shift, cycle, 100.0 * min(wavelength, 9.0) + 10.0 * shift + cycle, 0.5)
        for wavelength, shift, cycle in itertools.product([np.inf, 0.0, 1.0, 2.0], [0, 1], [1, 2])
        if np.isfinite(wavelength) or shift == 0
    ]
    return pd.DataFrame(rows, columns=["wavelength_mm", "shift_mm", "cycle", "value", "error"])


@pytest.fixture
def figure():
    columns = [
        Column("wavelength_mm", "cycle", {"shift_mm": 0}, "log"),
        Column("shift_mm", "wavelength_mm", {"cycle": 1}, "symlog", level=FREE),
    ]
    return panels([Row("closure (mm)", table(), "value", "error")], columns, NAMES, bars=2.0)


def test_lines_have_the_values_of_their_rows_in_order_of_the_coordinate(figure):
    over_wavelength, over_shift = figure.axes
    lines = [container[0] for container in over_wavelength.containers]
    assert [line.get_ydata().tolist() for line in lines] == [[1, 101, 201, 901], [2, 102, 202, 902]]
    shifted = [container[0].get_ydata().tolist() for container in over_shift.containers]
    assert shifted == [[1, 11], [101, 111], [201, 211]]
    (bars,) = over_shift.containers[1][2]
    assert np.ptp(bars.get_segments()[0][:, 1]) == 2.0

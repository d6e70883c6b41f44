"""The figure of numerical stability, from made-up numbers."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from studies.verification.numerics_figure import CEILING, FLOOR, numerics_figure


def test_no_error_is_drawn_on_the_floor_and_no_number_on_the_ceiling():
    rows = [
        (subject, series, at, error)
        for subject in ("cubic", "far field", "quartic")
        for series, error in (("as printed", np.inf), ("jointclosure", 0.0))
        for at in (1.0, 2.0)
    ]
    rows += [
        ("convergence", "jointclosure", 10, 1e-3),
        ("convergence", "contact by contact", 1, 1.0),
    ]
    figure = numerics_figure(pd.DataFrame(rows, columns=["subject", "series", "at", "error"]))
    for axes in figure.axes[:3]:
        lines = {line.get_label(): line.get_ydata() for line in axes.lines}
        assert np.all(lines["as printed"] == CEILING)
        assert np.all(lines["jointclosure"] == FLOOR)
        low, high = axes.get_ylim()
        assert low < FLOOR < CEILING < high
    plt.close(figure)

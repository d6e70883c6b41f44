"""Figures of hard cases and of numerical stability show what they are given."""

import numpy as np
import pandas as pd

from studies.verification.figures import CEILING, COLUMNS, FLOOR, hard_case_page, numerics_figure

CASES = (
    ("flat_on_flat", "success", True),
    ("flat_on_flat_resolved", "target_jumped", True),
    ("mated_walls_of_a_very_long_name_indeed", "refused", True),
    ("spikes", "not_converged", False),
)


def test_a_case_with_both_ways_of_breakage_is_one_panel_and_no_panel_is_empty():
    table = pd.DataFrame(CASES, columns=["name", "status", "holds"])
    curves = {
        "case": ["flat_on_flat"] * 3 + ["flat_on_flat_resolved"] * 3 + ["spikes"],
        "closure_m": [0.0, 1e-6, 2e-6, 0.0, 1e-6, 3e-6, 0.0],
        "normal_stress_Pa": [0.0, 1e6, 4e6, 0.0, 1e6, 5e6, 0.0],
    }
    page = hard_case_page(table, pd.DataFrame(curves))
    titles = [axes.get_title() for axes in page.axes if axes.get_visible()]
    assert titles == ["flat on flat", "mated walls of a very long\nname indeed", "spikes"]
    assert len(page.axes) == COLUMNS


def test_no_error_is_drawn_on_the_floor_and_no_number_on_the_ceiling():
    rows = [
        (subject, series, at, error)
        for subject in ("cubic", "far field", "quartic")
        for series, error in (("as printed", np.inf), ("jointclosure", 0.0))
        for at in (1.0, 2.0)
    ]
    rows += [("convergence", name, 10, 1e-3) for name in ("jointclosure", "contact by contact")]
    figure = numerics_figure(pd.DataFrame(rows, columns=["subject", "series", "at", "error"]))
    for axes in figure.axes[:3]:
        lines = {line.get_label(): line.get_ydata() for line in axes.lines}
        assert np.all(lines["as printed"] == CEILING)
        assert np.all(lines["jointclosure"] == FLOOR)
        low, high = axes.get_ylim()
        assert low < FLOOR < CEILING < high

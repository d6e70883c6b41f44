"""The page of hard cases shows what it is given; people look at the rest."""

import pandas as pd
import pytest

from studies.verification.figures import COLUMNS, hard_case_page

CASES = (
    ("flat_on_flat", "success", True),
    ("flat_on_flat_resolved", "target_jumped", True),
    ("mated_walls_of_a_very_long_name_indeed", "refused", True),
    ("spikes", "not_converged", False),
)


@pytest.fixture
def page():
    table = pd.DataFrame(CASES, columns=["name", "status", "holds"])
    curves = pd.DataFrame(
        {
            "case": ["flat_on_flat"] * 3 + ["flat_on_flat_resolved"] * 3 + ["spikes"],
            "closure_m": [0.0, 1e-6, 2e-6, 0.0, 1e-6, 3e-6, 0.0],
            "normal_stress_Pa": [0.0, 1e6, 4e6, 0.0, 1e6, 5e6, 0.0],
        }
    )
    return hard_case_page(table, curves)


def shown(page):
    return [axes for axes in page.axes if axes.get_visible()]


def test_a_case_with_both_ways_of_breakage_is_one_panel_and_no_panel_is_empty(page):
    titles = [axes.get_title() for axes in shown(page)]
    assert titles == ["flat on flat", "mated walls of a very long\nname indeed", "spikes"]
    assert len(page.axes) == COLUMNS


# fmt: skip

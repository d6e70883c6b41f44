"""Tables 1 to 3 in the paper's layout."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.joint.status import FAILURE
from jointclosure.parameters import PROPERTIES
from studies.paper import figures as plotting
from studies.paper.closure_tables import max_closure_table
from studies.paper.tables_1_to_3 import (
    case_table,
    interval_text,
    property_heading,
    rock_table,
    table_3,
    table_3_markdown,
    with_paper,
)
from tests.studied import study_of
from tests.world import world


@pytest.fixture(scope="module")
def equal_lengths():
    """Table 3 of two rocks, all of whose lengths are the same."""
    same = {"length": 1.5, "percent": 15.0, "length_net": 1.0, "percent_net": 10.0, "samples": 20}
    columns = [(rock, name, cycle) for rock in "ab" for name in PROPERTIES for cycle in (1, 2)]
    return pd.DataFrame(columns, columns=["rock", "parameter", "cycle"]).assign(**same)


TITLES = {"a": "Rock A", "b": r"\input{/etc/passwd} 50 % & $x_1^2$"}


def test_table_3_runs_no_command_of_a_title(equal_lengths):
    markdown = table_3_markdown(equal_lengths, TITLES)
    assert r"| \\input\{/etc/passwd\} 50 % \& \$x\_1^2\$, cycle 1 |" in markdown


def test_table_3_marks_its_lengths(equal_lengths):
    markdown = table_3_markdown(equal_lengths, TITLES)
    assert markdown.count("1.50 (15%)") == len(equal_lengths)
    assert markdown.count("1.00 (10%)") == len(equal_lengths)
    endless = equal_lengths.assign(length_high=float("inf"), extrapolated=True)
    assert "1.50*‡ (15%)" in table_3_markdown(endless, TITLES)


@pytest.fixture(scope="module")
def with_a_curve():
    """The default rocks, of which one has a measured curve."""
    measured = {"file": "a.csv", "stress_unit": "MPa"}
    return study_of({"rocks": {"slate": {"measured": measured}}}).rocks


def test_table_1_names_the_file_of_a_measured_curve(with_a_curve):
    table = rock_table(with_a_curve).set_index("rock")
    assert table.measured["slate"] == "a.csv"
    assert table.measured.isna().sum() == 3
    assert table.youngs_modulus_GPa["siltstone"] == 28.5


def test_table_2_has_every_level(with_a_curve):
    table = case_table(with_a_curve)
    assert len(table) == 4 * 4 * 3
    own = table[(table.rock == "siltstone") & (table.parameter == "youngs_modulus")]
    assert own.value.tolist() == [25, 28.5, 32]
    assert own.level.tolist() == ["low", "base", "high"]
    assert set(own.unit) == {"GPa"}


@pytest.mark.parametrize("title", ['=HYPERLINK("a")', "\t=1"])
def test_a_title_in_table_1_is_no_formula_of_a_spreadsheet(with_a_curve, title):
    slate = with_a_curve["slate"]._replace(title=title)
    assert rock_table({"slate": slate}).title.tolist() == ["'" + title]


def test_a_study_of_other_rocks_has_no_columns_of_the_paper():
    own = pd.DataFrame([{"rock": "slate", "parameter": "jrc", "cycle": 1, "length": 1.5}])
    paper = own.drop(columns="length").assign(paper_length=0.726, paper_percent=11)
    assert with_paper(own, paper).paper_length.item() == 0.726
    other = own.assign(rock="granite")
    pd.testing.assert_frame_equal(with_paper(other, paper), other)


def test_means_on_common_surfaces_are_drawn_with_the_errors_of_their_changes():
    for draws, smaller in (("common", True), ("independent", False)):
        study = study_of({"study": {"draws": draws, "rocks": ["slate"], "pool": None}})
        closed = world(study)
        table = max_closure_table(closed)
        figure = plotting.trend_figure(table, closed, study.rocks)
        for axes, cycle in zip(
            figure.axes[:: len(study.rocks["slate"].levels)], (1, 2), strict=True
        ):
            (bars,) = (one.lines[2][0].get_segments() for one in axes.containers)
            halves = [0.5 * (bar[1, 1] - bar[0, 1]) for bar in bars]
            here = table[(table.cycle == cycle) & table.parameter.isin(["base", "poisson_ratio"])]
            scatter = here.max_closure_mean_mm_standard_error
            if not smaller:
                np.testing.assert_allclose(sorted(halves), sorted(scatter))
                continue
            low, high = (
                closed.max_closure.sel(case=f"slate-poisson_ratio-{level}", cycle=cycle)
                - closed.max_closure.sel(case="slate-base", cycle=cycle)
                for level in ("low", "high")
            )
            errors = [1e3 * float(one.std(ddof=1)) / np.sqrt(one.size) for one in (low, high)]
            np.testing.assert_allclose(sorted(halves), sorted([0.0, *errors]), atol=1e-12)
            assert max(halves) < 0.1 * scatter.min()


def test_a_failed_joint_takes_its_surface_out_of_the_change_on_common_surfaces():
    study = study_of({"study": {"draws": "common", "rocks": ["slate"], "pool": None}})
    closed = world(study)
    at = {"case": "slate-jrc-low", "cycle": 1}
    changes = closed.max_closure.sel(at) - closed.max_closure.sel(at | {"case": "slate-base"})
    closed["status"] = closed.status.broadcast_like(closed.max_closure[..., 0]).copy()
    closed.status.loc[{"case": "slate-base", "realization": 3}] = FAILURE
    row = max_closure_table(closed).set_index(["case", "cycle"]).loc["slate-jrc-low", 1]
    left = 1e3 * float(changes.where(changes.realization != 3).mean())
    assert row.max_closure_change_mm == pytest.approx(left)


def test_lengths_have_the_digits_that_are_not_doubtful():
    assert interval_text(1.2345, 12.3, "*") == "1.23* (12%)"
    assert interval_text(1.2345, 12.3, "", 0.2) == "1.23 ± 0.20 (12%)"
    assert interval_text(1.2345, 12.3, "", np.inf) == "1.2 (12%)"
    assert interval_text(np.nan, np.nan) == "–"


@pytest.mark.parametrize(
    ("status", "text"),
    [({}, "1.50* (15%)"), ({"status": "negative deviation at the root"}, "1.50*† (15%)")],
)
def test_lengths_are_marked_by_what_is_doubtful_of_them(status, text):
    same = {"rock": "a", "length": 1.5, "percent": 15.0, "extrapolated": True} | status
    columns = [(name, cycle) for name in PROPERTIES for cycle in (1, 2)]
    table = pd.DataFrame(columns, columns=["parameter", "cycle"]).assign(**same)
    assert set(table_3(table, {"a": "A"}).to_numpy().ravel()) == {text}


def test_the_heading_of_a_property_has_its_symbol_and_unit():
    assert property_heading("compressive_strength") == "Compressive strength σc (MPa)"


def test_the_heading_of_the_roughness_has_its_name_in_full():
    assert property_heading("jrc") == "Joint roughness coefficient (JRC)"

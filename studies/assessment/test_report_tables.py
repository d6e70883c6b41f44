"""Tables and panels of the assessment in a report, of made-up joints."""

import json
import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.assessment.assessed_results import CLOSURE, STIFFNESS
from jointclosure.assessment.verdicts import GIVEN_UP, NEEDED_AS_FAILS
from jointclosure.cli.report import Picture, render
from jointclosure.joint.status import BREAKAGE_NOT_AT_REST
from studies.assessment.report_panels import WORST, accuracy_panel, effects_panel, hardness_panel
from studies.assessment.report_plan import RESIDUAL, AssessmentPlan
from studies.assessment.report_tables import (
    ALL_ROCKS,
    GROSS,
    KEPT,
    LEFT_OUT,
    NEEDED,
    NOT_TESTED,
    OFF,
    assessed_table,
    cost_table,
    hardness_table,
    judged_setting,
)
from studies.paper.report.content import assessed, numerical_bias, prices
from studies.paper.report.page_tables import with_limits
from studies.paper.report.verdicts import JUMPS, TOO_FEW, verdict_of_cycles
from tests.studied import study_of

ROCKS, LADDER = ("slate", "dolerite"), ("the paper's steps", "tolerance 0.1", "tolerance 0.02")
CHANGED = {"tolerance 0.1": 0.9, "tolerance 0.02": 0.8, "without interaction": 1.1}
"""Closure of each variant over that of the study."""
TIMES = {"tolerance 0.1": 9.0, "tolerance 0.02": 11.0, "without interaction": 0.5}
PLAN = AssessmentPlan(
    LADDER[0], LADDER, ("tolerance 0.004", "without gouge"), 2, {}, 40.0, 500.0, 0.1
)
EFFECTS = dict.fromkeys(ROCKS, jc.Effects())
CLOSURES = {"slate": 1e-4 * np.array([[1.0, 0.2], [1.2, 0.3], [9.0, 9.0]]),
            "dolerite": 2e-4 * np.array([[1.0, 0.2], [1.4, 0.3], [9.0, 9.0]])}  # fmt: skip
WITHIN = 0.05
STAYS, REMAINS = 0.6, 0.5
"""Share of the closure that remains: of the study, and of all variants."""
OWN_SECONDS = np.array([5.0, 1.0, 3.0])  # the first one loaded the kernels


def dataset():
    """Return the base cases of two rocks with three joints; variants have the first two."""
    order = ("case", "realization")
    locked = np.array([[[0.02, 0.01], [0.3, 0.1], [0.0, 0.0]], [[0.05, 0.0], [0.0, 0.0], [0.2, 0]]])
    return xr.Dataset(
        {
            "status": (order, [[0, 2, 1], [0, 32, 2]]),
            "seed": (order, np.array([["a", "b", "c"], ["d", "e", "f"]])),
            CLOSURE: ((*order, "cycle"), [CLOSURES[rock] for rock in ROCKS]),
            RESIDUAL: ((*order, "cycle"), [STAYS * CLOSURES[rock] for rock in ROCKS]),
            GROSS: ((*order, "cycle"), [2.0 * CLOSURES[rock] for rock in ROCKS]),
            STIFFNESS: ((*order, "cycle"), [1e7 / CLOSURES[rock] for rock in ROCKS]),
            "timing_simulation": (order, [OWN_SECONDS, 2.0 * OWN_SECONDS]),
            "locked_share": ((*order, "cycle"), locked),
            "flat_share": ((*order, "cycle"), 0.0 * locked),
            "largest_jump": (order, [[0.08, 0.02, 0.2], [0.04, 0.06, 0.12]]),
            "largest_residual": (order, np.full((2, 3), 5e-5)),
            "breakage_steps": (order, [[10, 20, 30], [20, 20, 60]]),
        },
        coords={"realization": [0, 1, 2], "cycle": [1, 2], "rock": ("case", list(ROCKS)),
                "parameter": ("case", ["base", "base"]), "level": ("case", ["base", "base"]),
                "case": list(ROCKS),
                "value": ("case", [np.nan, np.nan])},
    )  # fmt: skip


def joints_of(rock, scale=1.0):
    """Return joints of a rock by all variants, each with a known change."""
    closures = CLOSURES[rock][:2]
    values = np.concatenate([factor * closures for factor in CHANGED.values()])
    seconds = np.repeat([2.0 * scale * time for time in TIMES.values()], 2)
    return xr.Dataset(
        {
            "status": ("joint", np.zeros(len(values), dtype=int)),
            CLOSURE: (("joint", "cycle"), values),
            RESIDUAL: (("joint", "cycle"), REMAINS * values),
            GROSS: (("joint", "cycle"), 2.0 * values),
            STIFFNESS: (("joint", "cycle"), 1e7 / values),
            "timing_simulation": ("joint", seconds),
        },
        coords={"variant": ("joint", np.repeat(np.array(list(CHANGED), object), 2))},
    )


@pytest.fixture
def joints():
    return {"slate": joints_of("slate"), "dolerite": joints_of("dolerite", 2.0)}


@pytest.fixture
def study():
    """Return a made-up study whose joints all succeeded."""
    return dataset().assign(status=(("case", "realization"), np.zeros((2, 3), dtype=int)))


@pytest.fixture
def table(study, joints):
    return assessed_table(study, joints, PLAN, EFFECTS, 0.05)


def row_of(table, rock, variant, cycle=1):
    (row,) = table[
        (table.rock == rock) & (table.variant == variant) & (table.cycle == cycle)
    ].itertuples()
    return row


@pytest.mark.parametrize("rock", [*ROCKS, ALL_ROCKS])
def test_changes_are_means_over_joints_with_their_standard_errors(table, rock):
    rocks = ROCKS if rock == ALL_ROCKS else [rock]
    for variant, reference in (
        ("the paper's steps", "tolerance 0.02"),
        ("tolerance 0.1", "tolerance 0.02"),
        ("without interaction", "the paper's steps"),
    ):
        factors = CHANGED | {"the paper's steps": 1.0}
        for cycle in (1, 2):
            row = row_of(table, rock, variant, cycle)
            parts = [CLOSURES[one][:2, cycle - 1] for one in rocks]
            one = factors[variant] / factors[reference] - 1.0
            samples = 100.0 * one * np.concatenate([part / part.mean() for part in parts])
            assert row.joints == samples.size
            assert row.change_percent == pytest.approx(samples.mean())
            error = samples.std(ddof=1) / np.sqrt(samples.size)
            assert row.change_percent_standard_error == pytest.approx(error)


def test_times_are_against_joints_of_the_study_that_did_not_load_the_kernels(table):
    for rock in (*ROCKS, ALL_ROCKS):
        row = row_of(table, rock, "without interaction")
        assert row.time_percent == pytest.approx(-50.0)
        assert row.time_percent_standard_error == pytest.approx(
            50.0 * np.std([1.0, 3.0], ddof=1) / np.sqrt(2.0) / 2.0
            / (np.sqrt(2.0) if rock == ALL_ROCKS else 1.0)
        )  # fmt: skip
    assert row_of(table, "slate", "the paper's steps").seconds == pytest.approx(2.0)


def test_effects_that_are_not_tested_or_left_out_have_a_reason(study, joints):
    reason = "without interaction the mean closure changes by 0.5 %, at most 1 %: left out"
    chosen = {"effects": EFFECTS["slate"]._replace(interaction=False)._asdict()}
    chosen["cases"] = {"slate-base": {"reasons": [reason]}}
    study.attrs["effects_chosen"] = json.dumps({"slate": chosen})
    effects = EFFECTS | {"dolerite": jc.Effects(soft_peaks=False)}
    table = assessed_table(study, joints, PLAN, effects, 0.05)
    states = table.drop_duplicates(["rock", "variant"]).set_index(["rock", "variant"])
    assert states.state[("slate", "without interaction")] == LEFT_OUT
    assert "changes by 0.5 %, at most 1 %" in states.reason[("slate", "without interaction")]
    assert states.state[("dolerite", "without interaction")] == ""
    assert states.state[("dolerite", "without soft peaks")] == OFF
    assert states.reason[(ALL_ROCKS, "without soft peaks")].startswith("dolerite: ")
    for rock in (*ROCKS, ALL_ROCKS):
        assert states.state[(rock, "without gouge")] == NOT_TESTED
        assert states.state[(rock, "without substrate")] == NEEDED


def test_a_joint_that_failed_is_in_no_mean(study, joints):
    joints["slate"].status[0] = 32
    row = row_of(assessed_table(study, joints, PLAN, EFFECTS, 0.05), "slate", "tolerance 0.1")
    assert (row.joints, row.failed) == (1, 1)
    assert np.isnan(row.change_percent_standard_error)


@pytest.fixture
def failing_table(study, joints):
    """The table of a rock whose joints fail without interaction."""
    failed = joints["slate"].variant == "without interaction"
    joints["slate"]["status"] = joints["slate"].status.where(~failed, 128)
    return assessed_table(study, {"slate": joints["slate"]}, PLAN, {"slate": jc.Effects()}, 0.05)


def test_an_effect_without_which_joints_fail_is_needed(failing_table):
    row = row_of(failing_table, "slate", "without interaction")
    assert (row.state, row.reason) == (NEEDED, "2 of 2 joints fail without it")
    assert row.verdict == NEEDED_AS_FAILS


def test_an_effect_without_which_a_joint_is_given_up_is_kept(study, joints):
    part = joints["slate"]
    lacks = np.flatnonzero(part.variant == "without interaction")
    part.status[lacks[0]] = BREAKAGE_NOT_AT_REST
    table = assessed_table(study, {"slate": part}, PLAN, {"slate": jc.Effects()}, 0.05)
    row = row_of(table, "slate", "without interaction")
    assert (row.state, row.verdict) == (KEPT, GIVEN_UP)
    assert row.reason == (
        "the joint takes longer without it, and the change was not tested (given up after 20,000 "
        "breakage steps a cell: 1 of 2 joints)"
    )
    # the other joint alone has no interval: a mark would look exact
    left, right = effects_panel(table, WITHIN).axes
    assert left.containers == []
    assert left.texts[0].get_text() == "kept"
    assert [one.lines[0].get_xdata().tolist() for one in right.containers] == [[]]
    assert with_limits(pd.Series(row._asdict()), "change_percent") == TOO_FEW


def test_joints_that_were_not_simulated_after_one_was_given_up_are_not_counted(study, joints):
    part = joints["slate"]
    first, last = np.flatnonzero(part.variant == "without interaction")
    part.status[first] = BREAKAGE_NOT_AT_REST
    fewer = part.isel(joint=np.delete(np.arange(part.sizes["joint"]), last))
    table = assessed_table(study, {"slate": fewer}, PLAN, {"slate": jc.Effects()}, 0.05)
    row = row_of(table, "slate", "without interaction")
    assert (row.joints, row.failed, row.verdict) == (0, 1, GIVEN_UP)
    assert "1 of 1 joints" in row.reason


def test_a_setting_of_one_joint_has_no_mark(study, joints):
    """But that of the reference, from which others differ, has."""
    plan = PLAN._replace(joints=1)
    one = joints["slate"].isel(joint=[0, 2, 4])
    table = assessed_table(study, {"slate": one}, plan, {"slate": jc.Effects()}, 0.05)
    axes = accuracy_panel(table, WITHIN).axes[0]
    assert len(axes.containers) == 4  # net and gross closure of two cycles


def test_settings_have_their_times_and_verdicts_beside_the_first_panel(table):
    settings = table[(table.rock == ALL_ROCKS) & (table.kind == "setting")]
    first, *_, last = prices(settings, "5 %")
    assert first == "3.0 s by the paper's steps (its error is beyond 5 %)"
    assert last.endswith("by tolerance 0.02 (the finest setting, with which others are compared)")


def test_joints_that_fail_have_no_time(failing_table):
    row = row_of(failing_table, "slate", "without interaction")
    assert np.isnan([row.seconds, row.time_percent]).all()


@pytest.mark.parametrize(
    ("net", "gross", "verdict", "needed_by"),
    [
        (1.01, 1.02, "can be left out", ""),
        (1.01, 1.2, "needed", "gross closure (cycles 1, 2)"),
        (1.2, 1.01, "needed", "net closure (cycles 1, 2)"),
    ],
)
def test_effects_are_judged_by_net_and_gross_closure(study, joints, net, gross, verdict, needed_by):
    part = joints["slate"]
    lacks = (part.variant == "without interaction").values
    for name, factor in ((CLOSURE, net), (GROSS, gross)):
        values = part[name].values.copy()
        own = study[name].values[0, :2]
        values[lacks] = own + (factor - 1.0) * own.mean(axis=0)
        part[name] = part[name].dims, values
    table = assessed_table(study, {"slate": part}, PLAN, {"slate": jc.Effects()}, 0.05)
    for cycle in (1, 2):
        row = row_of(table, "slate", "without interaction", cycle)
        assert (row.verdict, row.needed_by) == (verdict, needed_by)
        assert row.gross_percent == pytest.approx(100.0 * (gross - 1.0))


def test_an_effect_without_which_joints_fail_is_shown_by_a_word(failing_table):
    left = effects_panel(failing_table, WITHIN).axes[0]
    assert [text.get_text() for text in left.texts] == ["needed", "needed", "not tested"]


def test_the_cost_is_the_share_of_the_time_of_all_joints(study, joints):
    cost = cost_table([study, study], joints, PLAN).iloc[0]
    assert cost.closed == 12
    assert cost.share_percent == pytest.approx(100.0 * cost.seconds / (2.0 * 27.0))
    assert (cost.expected_percent, cost.allowed_percent) == (8.0, 10.0)


def test_joints_are_ranked_by_status_then_by_the_measure_that_is_farthest_beyond_its_limit():
    table = hardness_table(dataset(), WITHIN, jumps=True)
    assert table.verdict.tolist() == [
        "not stable: failed",
        "jumped over the maximum stress",
        "hard: outside of the model's range",
        "hard: outside of the model's range",
        JUMPS,
        "",
    ]
    assert table.unbreakable_percent.tolist() == pytest.approx([0.0, 0.0, 30.0, 20.0, 2.0, 5.0])
    assert table.unbreakable_over_limit.tolist() == pytest.approx([0.0, 0.0, 3.0, 2.0, 0.2, 0.5])
    assert table.jump_percent.tolist() == pytest.approx([6.0, 20.0, 2.0, 12.0, 8.0, 4.0])
    assert table.jump_over_limit.tolist() == pytest.approx([1.2, 4.0, 0.4, 2.4, 1.6, 0.8])
    assert table.reason[4] == (
        "2 % of the force on contacts that cannot break (limit 10 %); largest jump 8 % of the "
        "closure (limit 5 %); 0.5 times the median number of breakage steps"
    )
    assert table.reason[0] == "Breakage did not come to rest"
    assert table.reason[2].startswith(
        "30 % of the force on contacts that cannot break (limit 10 %)"
    )
    assert table.effort.tolist() == pytest.approx([1.0, 1.5, 1.0, 3.0, 0.5, 1.0])
    assert set(table.ranked) == {6}
    assert table.verdict_joints.tolist() == [1, 1, 2, 2, 1, 1]


def test_jumps_of_fixed_steps_are_not_judged():
    table = hardness_table(dataset(), WITHIN, jumps=False)
    assert JUMPS not in set(table.verdict)
    assert table.jump_percent.isna().all()
    assert not table.reason.str.contains("largest jump").any()
    axes = hardness_panel(table, {"slate": "Slate", "dolerite": "Dolerite"}).axes[0]
    assert not [line for line in axes.lines if line.get_marker() == "D"]


@pytest.fixture
def accuracy_axes(table):
    """Axes of the accuracy panel, and the rows of settings that it shows."""
    rows = table[(table.rock == ALL_ROCKS) & (table.kind == "setting")]
    return accuracy_panel(table, WITHIN).axes[0], rows


def test_the_accuracy_panel_shows_every_setting(accuracy_axes):
    axes, rows = accuracy_axes
    drawn = sorted((one.lines[0].get_ydata()[0], *bar_of(one)[:, 1]) for one in axes.containers)
    expected = [
        row
        for name in ("change_percent", "gross_percent")
        for row in rows[[name, f"{name}_low", f"{name}_high"]].to_numpy().tolist()
    ]
    np.testing.assert_allclose(drawn, sorted(expected), atol=1e-9)
    assert "logarithmic" in axes.get_xlabel()


def test_the_accuracy_panel_has_a_verdict_on_each_setting(table):
    (legend,) = accuracy_panel(table, WITHIN).legends
    words = [text.get_text() for text in legend.get_texts()]
    assert words[:3] == [
        "the paper's steps: beyond",
        "tolerance 0.1: beyond",
        "tolerance 0.02: reference",
    ]
    assert legend.get_title().get_text().startswith("By 4 joints, within ±5 % (grey)")


@pytest.mark.parametrize(
    ("factors", "within", "verdict"),
    [
        ((1.02, 1.021), 0.05, "within"),
        ((1.2, 1.21), 0.05, "beyond"),
        # 20 ± 1 %, twenty standard errors, but Student's t of two joints is 12.7
        ((1.19, 1.21), 0.1, "not determined"),
        ((1.02, 1.03), 0.05, "not determined"),
    ],
)
def test_two_joints_determine_an_error_by_students_t(study, joints, factors, within, verdict):
    part = joints["slate"]
    closed = (part.variant == "tolerance 0.1").values
    finest = (part.variant == "tolerance 0.02").values
    values = part[CLOSURE].values.copy()
    values[finest] = 1e-4
    values[closed] = 1e-4 * np.array(factors)[:, None]
    for name in (CLOSURE, GROSS):
        part[name] = part[name].dims, values
    table = assessed_table(study, {"slate": part}, PLAN, {"slate": jc.Effects()}, within)
    rows = table[(table.rock == "slate") & (table.variant == "tolerance 0.1")]
    assert set(rows.verdict) == {verdict} == {verdict_of_cycles(rows)}
    half = 12.706 * np.ptp(factors) / 2.0
    assert rows.change_percent_high.iloc[0] == pytest.approx(
        100.0 * (np.mean(factors) - 1.0 + half), abs=0.01
    )


def test_a_setting_is_within_the_request_only_by_net_and_gross_closure(table):
    row = row_of(table, "slate", "tolerance 0.1")._asdict()
    for net, gross, verdict in ((1.0, 1.0, "within"), (1.0, 9.0, "beyond"), (9.0, 1.0, "beyond")):
        for name, value in (("change", net), ("gross", gross)):
            row |= {f"{name}_percent{end}": value for end in ("", "_low", "_high")}
        assert judged_setting(row, WITHIN) == verdict
    unknown = row | {"gross_percent_low": -9.0, "gross_percent_high": 9.0}
    assert judged_setting(unknown, WITHIN) == "beyond"  # by the net closure
    small = {f"change_percent{end}": 1.0 for end in ("", "_low", "_high")}
    assert judged_setting(unknown | small, WITHIN) == "not determined"


def test_the_stiffness_is_compared_by_its_harmonic_mean(table):
    row = row_of(table, "slate", "tolerance 0.1")  # stiffness is inverse to closure here
    factor = CHANGED["tolerance 0.1"] / CHANGED["tolerance 0.02"]
    assert row.stiffness_percent == pytest.approx(100.0 * (1.0 / factor - 1.0))


def test_the_share_that_remains_is_compared_too(table):
    row = row_of(table, "slate", "the paper's steps")
    assert row.remains_points == pytest.approx(100.0 * (STAYS - REMAINS))
    assert row.remains_points_low == pytest.approx(row.remains_points_high)  # it has no scatter


@pytest.mark.parametrize(
    ("verdicts", "verdict"),
    [
        (["within", "within"], "within"),
        (["within", "not determined"], "not determined"),
        (["beyond", "not determined"], "beyond"),
    ],
)
def test_the_verdict_on_a_setting_is_that_of_its_worst_cycle(verdicts, verdict):
    assert verdict_of_cycles(pd.DataFrame({"verdict": verdicts})) == verdict


def test_the_accuracy_panel_rings_the_setting_of_the_study(accuracy_axes):
    axes, rows = accuracy_axes
    rings = [line for line in axes.lines if line.get_markersize() == 12]
    of_study = rows[rows.of_study.astype(bool)]
    expected = of_study[["change_percent", "gross_percent"]].to_numpy().ravel()
    assert [line.get_ydata()[0] for line in rings] == pytest.approx(expected.tolist())


def bar_of(container):
    (bar,) = container.lines[2]
    return bar.get_segments()[0]


@pytest.fixture
def effects_axes(table):
    return effects_panel(table, WITHIN).axes


def test_the_effects_panel_shows_changes_without_an_effect_as_the_table_does(effects_axes, table):
    left, right = effects_axes
    rows = table[(table.rock == ALL_ROCKS) & (table.variant == "without interaction")]
    points = [one.lines[0].get_xdata()[0] for one in left.containers]
    both = rows[["change_percent", "gross_percent"]].to_numpy()
    assert points == pytest.approx(both.ravel().tolist())
    assert min(points) > 0.0  # closure is larger without it
    assert [one.lines[0].get_xdata()[0] for one in right.containers] == pytest.approx([-50.0])


@pytest.fixture
def scattered_table(study, joints):
    """The table of a rock, of which one joint closes ten times as far without interaction."""
    part = joints["slate"]
    values = part[CLOSURE].values.copy()
    values[np.flatnonzero(part.variant == "without interaction")[0]] *= 10.0
    part[CLOSURE] = part[CLOSURE].dims, values
    return assessed_table(study, {"slate": part}, PLAN, {"slate": jc.Effects()}, 0.05)


def test_changes_of_too_few_joints_are_no_numbers_in_the_report(scattered_table):
    row = row_of(scattered_table, "slate", "without interaction")
    assert row.change_percent_high > 1000.0
    assert with_limits(pd.Series(row._asdict()), "change_percent") == TOO_FEW
    known = row_of(scattered_table, "slate", "tolerance 0.1")
    assert with_limits(pd.Series(known._asdict()), "change_percent") == "13 (-2 to 27)"


def test_a_wide_interval_without_zero_is_a_number_in_the_report():
    row = pd.Series({"change": 1200.0, "change_low": 900.0, "change_high": 1500.0})
    assert with_limits(row, "change") == "1200 (900 to 1500)"
    assert with_limits(row - 1200.0, "change") == TOO_FEW


def test_changes_of_too_few_joints_have_no_bars(scattered_table):
    figure = effects_panel(scattered_table, WITHIN)
    net = figure.axes[0].containers[0]
    assert net.lines[0].get_alpha() < 0.5
    assert np.ptp(bar_of(net)[:, 0]) == 0.0
    assert any(text.get_text().startswith(TOO_FEW) for text in figure.legends[0].get_texts())


def test_the_effects_panel_says_what_was_not_tested(effects_axes):
    left = effects_axes[0]
    names = [label.get_text() for label in left.get_yticklabels()]
    assert names == ["interaction:\nneeded", "substrate", "gouge"]
    assert [text.get_text() for text in left.texts] == ["needed", "not tested"]


def test_the_hardness_panel_shows_the_worst_joints_first_with_verdicts():
    table = hardness_table(dataset(), WITHIN, jumps=True)
    titles = {"slate": "Slate of Wales", "dolerite": "Dolerite"}
    axes = hardness_panel(table, titles).axes[0]
    lengths = [bar.get_width() for bar in axes.patches]
    assert lengths == pytest.approx(table.unbreakable_over_limit[:WORST].tolist())
    (jumps,) = (line.get_xdata() for line in axes.lines if line.get_marker() == "D")
    assert jumps == pytest.approx(table.jump_over_limit[:WORST].to_numpy())
    words = [text.get_text().replace("\n", " ") for text in axes.texts]
    assert words[:2] == ["not stable: failed", "jumped over the maximum stress"]
    assert words[-1] == "no remark"
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert labels[0] == "Dolerite, joint 1"
    assert labels[1] == "Slate of Wales, joint 2"


def test_a_pair_of_walls_that_cases_share_has_one_bar_with_the_range_over_its_cases():
    table = hardness_table(dataset(), WITHIN, jumps=True)
    slate = table[table.rock == "slate"]
    soft = slate.assign(changed="Young's modulus 22 GPa")
    soft["unbreakable_over_limit"] += 4.0
    both = pd.concat([soft, slate], ignore_index=True)
    axes = hardness_panel(both, {"slate": "Slate"}).axes[0]
    assert len(axes.patches) == slate.walls.nunique() == 3
    shares = slate.unbreakable_over_limit.to_numpy()
    lines = [line.get_xdata() for line in axes.lines if line.get_marker() == "|"]
    np.testing.assert_allclose(lines, np.column_stack([shares, shares + 4.0]))
    assert axes.get_xlim()[1] > 1.5 * (shares.max() + 4.0)
    assert (
        axes.get_yticklabels()[0].get_text() == "Slate, joint 2\nworst of 2: Young's modulus 22 GPa"
    )


def test_words_of_the_hardness_panel_are_not_cut():
    table = hardness_table(dataset(), WITHIN, jumps=True)
    titles = {"slate": "Slate of a long name that takes half", "dolerite": "Dolerite"}
    figure = hardness_panel(table, titles)
    figure.draw_without_rendering()
    ends = [text.get_window_extent().x1 for text in figure.axes[0].texts]
    assert max(ends) <= figure.bbox.width


@pytest.mark.parametrize("closed", [True, False])
def test_the_report_says_what_was_reached_or_why_nothing_is_known(closed, study, joints, table):
    configuration = study_of({"study": {"rocks": list(ROCKS)}})
    parts = joints if closed else {}
    known = {"study_assessment": table, "study_assessment_cost": cost_table([study], parts, PLAN)}
    about = assessed(known, configuration, configuration.titles)
    assert about["state"] == ("done" if closed else "too long")
    if closed:
        row = row_of(table, ALL_ROCKS, "the paper's steps")
        ends = f"{row.change_percent_low:.0f} to {row.change_percent_high:.0f}"
        change = f"{row.change_percent:.0f} ({ends}) %"
        assert about["errors"][0] == f"net {change}, gross {change} on cycle 1: beyond"
        assert about["verdicts"]["tolerance 0.02"] == "reference"
        assert about["rocks"] == ["Slate", "Dolerite"]
        assert about["samples"] == 4
        assert set(about["reasons"]) == {"substrate", "gouge"}
    assert assessed({}, configuration, configuration.titles) == {"state": "missing"}
    off = study_of({"assessment": None})
    assert assessed(known, off, off.titles) == {"state": "off"}


def bias_of(known):
    configuration = study_of({"study": {"rocks": list(ROCKS)}})
    return numerical_bias(assessed(known, configuration, configuration.titles))


def test_the_headline_has_the_error_of_the_numerics_of_the_study(study, joints, table):
    cost = cost_table([study], joints, PLAN)
    row = row_of(table, ALL_ROCKS, "the paper's steps")
    words = bias_of({"study_assessment": table, "study_assessment_cost": cost})
    ends = f"{row.change_percent_low:.0f} to {row.change_percent_high:.0f}"
    assert "numerics of this study (the paper's steps) have errors against tolerance 0.02" in words
    assert f"net closure since seating 25 ({ends}) % on cycle 1 and" in words
    assert f"; gross closure 25 ({ends}) % on cycle 1 and" in words
    assert f"; net chord stiffness {row.stiffness_percent:.0f} (" in words
    assert "no ± contains them" in words
    assert "share that remains is off by 10 (10 to 10) percentage points" in words
    assert "4 joints of Slate, Dolerite" in words


def test_the_headline_says_that_joints_are_too_few_for_an_error(study, joints, table):
    cost = cost_table([study], joints, PLAN)
    wide = table.assign(
        **{f"{name}_percent_low": -500.0 for name in ("change", "gross", "stiffness")},
        **{f"{name}_percent_high": 360.0 for name in ("change", "gross", "stiffness")},
    )
    words = bias_of({"study_assessment": wide, "study_assessment_cost": cost})
    assert "not known, because 4 joints of Slate, Dolerite are too few. make assess" in words
    assert "360" not in words


def test_the_headline_names_the_cycles_for_which_joints_are_too_few(study, joints, table):
    cost = cost_table([study], joints, PLAN)
    one = table.assign(change_percent_low=table.change_percent_low.where(table.cycle == 1, -500.0))
    words = bias_of({"study_assessment": one, "study_assessment_cost": cost})
    assert re.search(r"net closure since seating [^;]*on cycle 1; gross closure", words)
    assert "Of other results and cycles: too few joints. make assess" in words


def test_the_headline_says_why_the_error_of_the_numerics_is_not_known(study, joints, table):
    assert bias_of({}).endswith("the study was not assessed; make report does so.")
    cost = cost_table([study], {}, PLAN)
    words = bias_of({"study_assessment": table, "study_assessment_cost": cost})
    assert "would take more than assessment.share allows" in words
    finest = table.assign(of_study=table.variant == PLAN.ladder[-1])
    cost = cost_table([study], joints, PLAN._replace(stated=PLAN.ladder[-1]))
    words = bias_of({"study_assessment": finest, "study_assessment_cost": cost})
    assert "no finer numerics than the study's (tolerance 0.02) are compared" in words


def test_a_table_in_a_file_is_drawn_as_the_table(table, tmp_path):
    table.to_csv(tmp_path / "table.csv", index=False)
    again = pd.read_csv(tmp_path / "table.csv")
    for draw in (effects_panel, accuracy_panel):
        drawn = draw(table, WITHIN).axes[0]
        same = draw(again, WITHIN).axes[0]
        assert len(drawn.containers) == len(same.containers)


def first_screen(about, **names):
    """Return text and number of pictures of the report's first screen."""
    counts = {"joints": 3, "cases": 2}
    content = {
        "assessed": about,
        "pictures": {f"study_{name}": Picture(PNG) for name in ("accuracy", "hardness", "effects")},
        "outcome": {
            "simulations": 60,
            "failed": 1,
            "remarks": {"outside_model_range": counts, "target_jumped": {"joints": 0, "cases": 0}},
        },
        "frames": {"remarks": None},
        "cases": 9,
        "chosen_effects": {"Slate": ["without interaction the mean closure changes"]},
        "jumping": 7,
    }
    page = render(content | names, "first.html.j2", "studies.paper.report")
    return " ".join(re.sub(r"<[^>]*>", " ", page).split()), page.count("<img")


PNG = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\2\x9c\0\0\2\x1c"
"""Beginning of a picture, which states its size."""


def test_the_first_screen_says_how_sure_its_panels_are(study, joints, table):
    configuration = study_of({"study": {"rocks": list(ROCKS)}})
    known = {"study_assessment": table, "study_assessment_cost": cost_table([study], joints, PLAN)}
    text, pictures = first_screen(assessed(known, configuration, configuration.titles))
    assert pictures == 3
    assert "2 joints of the base case of Slate, Dolerite" in text
    assert "3 lie outside of the model's range, in 2 of 9 cases" in text
    assert "Of the others 7 are hard because their closure jumps." in text
    assert "Substrate is needed: joints that break have no equilibrium without it." in text
    assert "8 % was expected, and 10 % is allowed." in text
    assert "Effects of Slate were chosen before the study" in text
    assert "without interaction the mean closure changes." in text
    assert "Bars of closure are 95 % intervals of 4 joints by Student's t" in text
    assert "its error is beyond 5 %" in text


@pytest.mark.parametrize(
    ("about", "words"),
    [
        ({"state": "off"}, "because its configuration has assessment: null ."),
        ({"state": "missing"}, "make report with its configuration does so."),
    ],
)
def test_the_first_screen_says_why_a_study_was_not_assessed(about, words):
    text, pictures = first_screen(about)
    assert words in text
    assert pictures == 1  # the joints by hardness are known anyway


def test_effects_are_not_left_out_together_where_one_is_off_and_the_other_was_kept(study, joints):
    reason = "without breakage and gouge the mean closure changes by 30 %, at most 40 %: kept"
    acting = EFFECTS["slate"]._replace(gouge=False)
    chosen = {"effects": acting._asdict(), "cases": {"slate-base": {"reasons": [reason]}}}
    study.attrs["effects_chosen"] = json.dumps({"slate": chosen})
    table = assessed_table(study, joints, PLAN, EFFECTS | {"slate": acting}, 0.05)
    assert LEFT_OUT not in set(table.state)

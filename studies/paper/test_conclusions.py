"""What is left of a claim: its verdict, unless what the paper leaves open turns it."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.statistics.verdicts import FALLS, NO_DIFFERENCE, STANDS, UNDECIDED
from jointclosure.storage.text import read_csv
from studies.paper import conclusions
from studies.paper.claims import CLAIMS
from studies.paper.conclusions import (
    COUNTS,
    DEPENDS,
    JUDGED_ELSEWHERE,
    ONLY_CONFIGURED,
    conclusion_table,
)
from tests.studied import ROOT

ALL, ONE = "a; b; c; d", "a"


def stated(
    verdict,
    readings=None,
    share=None,
    number="5a",
    response="max_closure",
    cycle=2,
    other_cycle=None,
) -> pd.Series:
    """The row of a claim with such a verdict, readings (verdict, rocks, allowed), and share."""
    claims = pd.DataFrame(
        {
            "number": [number], "claim": ["it rises"], "verdict": [verdict],
            "found_share": [0.9], "found_error": [0.01],
            "found_low": [0.88], "found_high": [0.92],
        }
    )  # fmt: skip
    half_widths = pd.DataFrame(
        {
            "number": [number] * 3, "half_width": [0.0, 2.0, 1.0], "found_share": [0.9, 0.7, 0.8],
            "found_error": [0.01, 0.03, 0.02],
            "found_low": [0.88, 0.64, 0.76], "found_high": [0.92, 0.76, 0.84],
        }
    )  # fmt: skip
    given = {}
    if readings is not None:
        given["readings"] = pd.DataFrame(readings, columns=[f"claim {number}", "rocks", "allowed"])
        given["readings"]["title"] = [f"reading {i}" for i in range(len(readings))]
    if share is not None:
        rows = [(number.split(",")[0], response, cycle, "all", *share)]
        rows.append((number.split(",")[0], "other", cycle, "all", *[np.nan] * 3))
        if other_cycle is not None:
            rows.append((number, response, 3 - cycle, "all", *other_cycle))
        given["choices"] = pd.DataFrame(
            rows,
            columns=["number", "response", "cycle", "rock", "share", "share_low", "share_high"],
        ).assign(share_error=0.01)
    (row,) = conclusion_table(claims, half_widths, **given).itertuples()
    return row


@pytest.mark.parametrize("readings", [None, [(STANDS, ONE, True)] * 2])
def test_what_nothing_tried_in_all_rocks_is_known_as_configured_only(readings):
    row = stated(STANDS, readings and [(STANDS, ALL, False), *readings])
    assert row.conclusion == ONLY_CONFIGURED[STANDS]


def test_what_was_not_studied_is_left_empty():
    row = stated(STANDS)
    assert (row.jrc_half_width, row.jrc_found_share, row.jrc_found_error) == (2.0, 0.7, 0.03)
    assert (row.jrc_found_low, row.jrc_found_high) == (0.64, 0.76)
    assert np.isnan(row.readings_stand)
    assert np.isnan(row.choices_share)


@pytest.mark.parametrize(
    ("verdict", "readings", "expected"),
    [
        (STANDS, [(STANDS, ALL, True), (UNDECIDED, ALL, True)], STANDS),
        (STANDS, [(STANDS, ALL, True), (FALLS, ONE, True)], DEPENDS),
        (STANDS, [(STANDS, ALL, True), (FALLS, ONE, False)], STANDS),
        (FALLS, [(FALLS, ALL, True), (STANDS, ALL, True)], DEPENDS),
        (FALLS, [(FALLS, ALL, True), (STANDS, ONE, True)], FALLS),
        (STANDS, [(NO_DIFFERENCE, ONE, True)], DEPENDS),
        (UNDECIDED, [(STANDS, ALL, True)], UNDECIDED),
    ],
)
def test_a_reading_of_the_other_verdict_turns_a_conclusion(verdict, readings, expected):
    """A reading that the text rules out does not; nor does one rock where all are asked for."""
    row = stated(verdict, readings)
    assert row.conclusion == expected
    assert (row.opposed_by != "") == (expected == DEPENDS)
    allowed = sum(each[2] for each in readings)
    counts = [getattr(row, f"{kind}_{name}") for kind in ("readings", "partial") for name in COUNTS]
    assert sum(counts) == allowed


def test_readings_of_one_rock_are_counted_by_themselves():
    readings = [(STANDS, ALL, True), (STANDS, ONE, True), (UNDECIDED, ONE, True)]
    row = stated(STANDS, readings)
    assert (row.readings_stand, row.readings_fall, row.readings_open) == (1, 0, 0)
    assert (row.partial_stand, row.partial_fall, row.partial_open) == (1, 0, 1)
    assert row.opened_by == "reading 2"


@pytest.mark.parametrize(
    ("verdict", "share", "expected"),
    [
        (STANDS, (1.0, 0.94, 1.0), STANDS),
        (STANDS, (0.95, 0.91, 0.99), STANDS),
        (STANDS, (0.8, 0.6, 1.0), UNDECIDED),
        (STANDS, (0.5, 0.3, 0.7), DEPENDS),
        (FALLS, (0.0, 0.0, 0.2), UNDECIDED),
        (FALLS, (0.5, 0.3, 0.7), DEPENDS),
    ],
)
def test_choices_turn_a_conclusion_where_fewer_than_nine_tenths_agree(verdict, share, expected):
    """By the whole interval of the share: (value, low, high)."""
    row = stated(verdict, share=share)
    assert row.conclusion == expected
    assert (row.choices_share, row.choices_share_low, row.choices_share_high) == share


def test_a_claim_net_of_bulk_indentation_is_held_against_net_closures():
    row = stated(STANDS, share=(0.3, 0.2, 0.4), number="5a, net", response="max_closure_net")
    assert (row.choices_share, row.conclusion) == (0.3, DEPENDS)


def test_a_negated_claim_holds_where_its_statement_does_not(monkeypatch):
    """5d is that 5c is not true on the second cycle."""
    negated = next(claim for claim in CLAIMS if claim.number == "5d")
    monkeypatch.setattr(conclusions, "CLAIMS", [negated._replace(number="5c")])
    row = stated(STANDS, share=(0.3, 0.2, 0.5), number="5c")
    assert (row.choices_share, row.choices_share_low, row.choices_share_high) == (0.7, 0.5, 0.8)
    assert row.conclusion == DEPENDS


def test_a_claim_on_both_cycles_has_the_share_of_the_cycle_where_it_is_least_true():
    row = stated(FALLS, share=(0.0, 0.0, 0.05), other_cycle=(1.0, 0.9, 1.0), number="6a")
    assert (row.choices_share, row.choices_share_high, row.conclusion) == (0.0, 0.05, FALLS)


def test_what_a_sensitivity_study_has_nothing_on_is_judged_elsewhere():
    assert stated(UNDECIDED, number="8").conclusion == JUDGED_ELSEWHERE
    assert stated(UNDECIDED, number="5d").conclusion == UNDECIDED


def test_stored_evidence_gives_the_published_conclusions_and_none_leaves_them_empty():
    """Readings and the range of JRC are finished inquiries: their stored tables are the input."""
    stored = ROOT / "studies"
    claims = read_csv(stored / "paper/results/paper/claims.csv")
    evidence = [
        read_csv(stored / name)
        for name in (
            "paper/results/jrc_range/jrc_range_claims.csv",
            "paper/results/conclusions/earlier_readings.csv",
            "global_sensitivity/results/global_sensitivity/global_sensitivity_conclusions.csv",
            "global_sensitivity/results/global_sensitivity/global_sensitivity_margins.csv",
        )
    ]
    published = read_csv(stored / "paper/results/paper/conclusions.csv").set_index("number")
    found = conclusion_table(claims, *evidence).set_index("number").loc[published.index]
    assert found.conclusion.tolist() == published.conclusion.tolist()
    columns = [name for name in published if name.startswith(("jrc_", "choices_"))]
    pd.testing.assert_frame_equal(found[columns], published[columns])
    alone = conclusion_table(claims)
    assert alone.columns.tolist() == found.reset_index().columns.tolist()
    assert alone.filter(like="jrc_").isna().all(axis=None)

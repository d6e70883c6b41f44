"""What is left of a claim: its verdict, unless what the paper leaves open turns it."""

import numpy as np
import pandas as pd
import pytest

from jointclosure.statistics.verdicts import FALLS, NO_DIFFERENCE, STANDS, UNDECIDED
from jointclosure.storage.files import read_csv
from studies.paper import conclusions
from studies.paper.claims import CLAIMS
from studies.paper.conclusions import (
    COUNTS,
    DEPENDS,
    FOUND,
    NOT_JUDGED,
    ONLY_CONFIGURED,
    conclusion_table,
)
from tests.studied import ROOT

ALL, ONE = "a; b; c; d", "a"


def stated(verdict, readings=None, shares=(), number="5a") -> pd.Series:
    """Return the conclusion on a claim with readings (verdict, rocks, allowed) and ``shares``.

    ``shares`` of choices are rows of response, cycle, share, and its low and high end.
    """
    about = {"number": number, "claim": "it rises", "verdict": verdict}
    claims = pd.DataFrame([about | dict(zip(FOUND, (0.9, 0.01, 0.88, 0.92), strict=True))])
    known = pd.DataFrame(
        [(0.0, 0.9, 0.01, 0.88, 0.92), (2.0, 0.7, 0.03, 0.64, 0.76), (1.0, 0.8, 0.02, 0.76, 0.84)],
        columns=["half_width", *FOUND],
    ).assign(number=number)
    given = {}
    if readings is not None:
        given["readings"] = pd.DataFrame(readings, columns=[f"claim {number}", "rocks", "allowed"])
        given["readings"]["title"] = [f"reading {i}" for i in range(len(readings))]
    if shares:
        columns = ["response", "cycle", "share", "share_low", "share_high"]
        given["choices"] = pd.DataFrame([*shares, ("other", 2, *[np.nan] * 3)], columns=columns)
        given["choices"] = given["choices"].assign(
            number=number.split(",")[0], rock="all", share_error=0.01
        )
    (row,) = conclusion_table(claims, known, **given).itertuples()
    return row


def test_what_was_not_studied_is_left_empty():
    row = stated(STANDS)
    assert row.jrc_half_width == 2.0
    assert [getattr(row, f"jrc_{name}") for name in FOUND] == [0.7, 0.03, 0.64, 0.76]
    assert np.isnan([row.readings_stand, row.choices_share]).all()
    assert row.conclusion == ONLY_CONFIGURED[STANDS]


@pytest.mark.parametrize(
    ("verdict", "readings", "expected"),
    [
        (STANDS, [(STANDS, ALL, False), *[(STANDS, ONE, True)] * 2], ONLY_CONFIGURED[STANDS]),
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
    counts = [getattr(row, f"{kind}_{name}") for kind in ("readings", "partial") for name in COUNTS]
    assert sum(counts) == sum(reading[2] for reading in readings)


GROSS, NET = "max_closure", "max_closure_net"


@pytest.mark.parametrize(
    ("verdict", "number", "shares", "expected"),
    [
        (STANDS, "5a", [(GROSS, 2, 1.0, 0.94, 1.0)], STANDS),
        (STANDS, "5a", [(GROSS, 2, 0.95, 0.91, 0.99)], STANDS),
        (STANDS, "5a", [(GROSS, 2, 0.8, 0.6, 1.0)], UNDECIDED),
        (STANDS, "5a", [(GROSS, 2, 0.5, 0.3, 0.7)], DEPENDS),
        (FALLS, "5a", [(GROSS, 2, 0.0, 0.0, 0.2)], UNDECIDED),
        (FALLS, "5a", [(GROSS, 2, 0.5, 0.3, 0.7)], DEPENDS),
        (STANDS, "5a, net", [(NET, 2, 0.3, 0.2, 0.4), (GROSS, 2, 1.0, 1.0, 1.0)], DEPENDS),
        # on both cycles: that of the cycle where it is least true
        (FALLS, "6a", [(GROSS, 2, 0.0, 0.0, 0.05), (GROSS, 1, 1.0, 0.9, 1.0)], FALLS),
        (UNDECIDED, "8", [], NOT_JUDGED),
        (UNDECIDED, "5d", [], UNDECIDED),
    ],
)
def test_choices_turn_a_conclusion_where_fewer_than_nine_tenths_agree(
    verdict, number, shares, expected
):
    """By the whole interval of the share: (value, low, high)."""
    row = stated(verdict, shares=shares, number=number)
    assert row.conclusion == expected
    if shares:
        assert (row.choices_share, row.choices_share_low, row.choices_share_high) == shares[0][2:]


def test_a_negated_claim_holds_where_its_statement_does_not(monkeypatch):
    """5d is that 5c is not true on the second cycle."""
    negated = next(claim for claim in CLAIMS if claim.number == "5d")
    monkeypatch.setattr(conclusions, "CLAIMS", [negated._replace(number="5c")])
    row = stated(STANDS, shares=[(GROSS, 2, 0.3, 0.2, 0.5)], number="5c")
    assert (row.choices_share, row.choices_share_low, row.choices_share_high) == (0.7, 0.5, 0.8)
    assert row.conclusion == DEPENDS


STORED = ROOT / "studies/paper/published"


@pytest.fixture(scope="module")
def published_claims():
    return read_csv(STORED / "paper/claims.csv")


@pytest.fixture(scope="module")
def concluded(published_claims):
    """Readings and the range of JRC are finished inquiries: their stored tables are the input."""
    sampled = ROOT / "studies/global_sensitivity/published/global_sensitivity"
    files = [STORED / "jrc_range/jrc_range_claims.csv", STORED / "conclusions/earlier_readings.csv"]
    files += [sampled / f"global_sensitivity_{name}.csv" for name in ("conclusions", "margins")]
    return conclusion_table(published_claims, *map(read_csv, files))


def test_stored_evidence_gives_the_published_conclusions(concluded):
    published = read_csv(STORED / "paper/conclusions.csv").set_index("number")
    found = concluded.set_index("number").loc[published.index]
    assert found.conclusion.tolist() == published.conclusion.tolist()
    columns = [name for name in published if name.startswith(("jrc_", "choices_"))]
    pd.testing.assert_frame_equal(found[columns], published[columns])


def test_conclusions_without_evidence_are_empty(published_claims, concluded):
    alone = conclusion_table(published_claims)
    assert alone.columns.tolist() == concluded.columns.tolist()
    assert alone.filter(like="jrc_").isna().all(axis=None)

"""Conclusions on the paper's claims: they stand, fall, or depend on what the paper leaves open.

A reading is an interpretation of the paper's text, and a choice is a value that the text leaves
open. Both were varied in other studies, whose verdicts are combined here with that of this study.
"""

import numpy as np
import pandas as pd

from jointclosure.statistics.verdicts import FALLS, NO_DIFFERENCE, STANDS, UNDECIDED
from studies.paper.claims import CLAIMS, FOUND, Claim

DEPENDS = "depends on what is unstated"
"""Conclusion on a claim that is true under some readings or choices, and false under others."""
ONLY_CONFIGURED = {
    verdict: f"{verdict} as configured" for verdict in (STANDS, FALLS, NO_DIFFERENCE)
}
"""Conclusions by verdict if no reading of all rocks and no choices have been tried."""
NOT_JUDGED = "not judged"
"""Conclusion on a claim that a sensitivity study cannot judge."""
UNJUDGED = frozenset(claim.number for claim in CLAIMS if not claim.cycles)
"""Numbers of claims that a sensitivity study cannot judge."""

NEARLY_ALL = 0.9
"""Share of the open choices that must agree with a verdict for it to be independent of them."""

SHARES = ("share", "share_error", "share_low", "share_high")
"""Columns of the share of choices for which a claim is true, with its error and 95 % interval. In
the table of conclusions they have the prefix ``choices_``."""
COUNTS = {"stand": STANDS, "fall": FALLS, "equal": NO_DIFFERENCE, "open": UNDECIDED}
"""Verdicts that are counted, by the end of the name of the column of their number."""
_RANKS = {FALLS: 0, NO_DIFFERENCE: 1, STANDS: 2}
"""Order of verdicts on a claim: with more rocks, the rank of the verdict never rises."""

_MOST_NAMED = 3
"""Largest number of readings whose titles are listed."""


def conclusion_table(
    claims: pd.DataFrame,
    jrc_range: pd.DataFrame | None = None,
    readings: pd.DataFrame | None = None,
    choices: pd.DataFrame | None = None,
    margins: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Tabulate the evidence for each of the paper's claims, and the conclusion on it.

    Readings that contradict the paper's text do not count. A reading that was tried for only some
    rocks can refute a claim about all rocks, but not confirm it.

    The conclusion is `NOT_JUDGED` or undecided if the claim's verdict is so. It is `DEPENDS` if a
    reading opposes the verdict, or if the 95 % interval of the share of choices that agree with the
    verdict lies below `NEARLY_ALL`. It is the verdict if no reading opposes it and this interval
    lies above `NEARLY_ALL`, and undecided if the interval contains `NEARLY_ALL`. Without choices it
    is the verdict, or that of `ONLY_CONFIGURED` if no reading of all rocks was tried either.

    Parameters
    ----------
    claims : DataFrame
        Table of claims that `judge_claims` returns.
    jrc_range : DataFrame, optional
        Shares of studies that confirm each claim, for ranges of JRC with a ``half_width``. The row
        with the largest one counts.
    readings : DataFrame, optional
        Verdicts on the claims for readings of the paper, one reading in each row.
    choices, margins : DataFrame, optional
        Tables of `studies.global_sensitivity.tables.conclusion_tables`.
    """
    rows = []
    for claim in claims.itertuples():
        row = {"number": claim.number, "claim": claim.claim, "verdict": claim.verdict}
        row["section"] = getattr(claim, "section", "")
        row |= {name: getattr(claim, name) for name in FOUND}
        row |= _of_jrc(claim.number, jrc_range) | _of_readings(claim, readings)
        row |= _of_choices(claim.number, choices, margins)
        rows.append(row | {"conclusion": _conclusion(row)})
    return pd.DataFrame(rows)


def _of_jrc(number: str, jrc_range: pd.DataFrame | None) -> dict:
    names = ["half_width", *FOUND]
    widest = pd.Series(np.nan, names)
    if jrc_range is not None:
        rows = jrc_range[(jrc_range.number == number) & (jrc_range.half_width > 0.0)]
        widest = next((row for _, row in rows.nlargest(1, "half_width").iterrows()), widest)
    return {f"jrc_{name}": widest[name] for name in names}


def _of_readings(claim, readings: pd.DataFrame | None) -> dict:
    """Return columns on the readings that the paper allows, for a claim.

    They count verdicts for readings of all rocks ("readings") and of some rocks ("partial"), and
    name the readings that oppose the verdict on the claim, or that leave it undecided.
    """
    column = f"claim {claim.number}"
    if readings is None or column not in readings:
        counts = [f"{kind}_{name}" for kind in ("readings", "partial") for name in COUNTS]
        return dict.fromkeys(counts, np.nan) | {"opposed_by": "", "opened_by": ""}
    allowed = readings[readings.allowed]
    verdicts = allowed[column]
    whole = allowed.rocks.str.len() == readings.rocks.str.len().max()
    here = _RANKS.get(claim.verdict, np.nan)
    there = verdicts.map(_RANKS)
    opposed = (there < here) | (whole & (there > here))
    opened = (verdicts == UNDECIDED) & (claim.verdict != UNDECIDED)
    return {
        f"{kind}_{name}": int((verdicts[selected] == verdict).sum())
        for kind, selected in (("readings", whole), ("partial", ~whole))
        for name, verdict in COUNTS.items()
    } | {
        "opposed_by": _named(allowed.title[opposed].tolist()),
        "opened_by": _named(allowed.title[opened].tolist()),
    }


def _named(titles: list[str]) -> str:
    rest = [f"{len(titles) - _MOST_NAMED} more"] if len(titles) > _MOST_NAMED else []
    return "; ".join([*titles[:_MOST_NAMED], *rest])


def _of_choices(number: str, choices: pd.DataFrame | None, margins: pd.DataFrame | None) -> dict:
    """Return columns on the open choices: the share for which a claim is true in all rocks.

    The share is that of the cycle in which the claim's statement is true least often; for a negated
    claim it is the rest. ``moved_by`` is the open input that contributes most to the variance of
    the statement's margin in this cycle.
    """
    claim = next(claim for claim in CLAIMS if claim.number == number)
    rows = _rows_of(choices, claim)
    answer: dict = {f"choices_{name}": np.nan for name in SHARES} | {"moved_by": ""}
    together = rows[rows.rock == "all"]
    if together.empty:
        return answer
    least = together.loc[together.share.idxmin()]
    share, error, low, high = least[list(SHARES)]
    shares = (1.0 - share, error, 1.0 - high, 1.0 - low) if claim.negated else least[list(SHARES)]
    answer |= {f"choices_{name}": x for name, x in zip(SHARES, shares, strict=True)}
    moved = _rows_of(margins, claim).dropna(subset="share")
    moved = moved[moved.cycle == least.cycle]
    if len(moved):
        most = moved.groupby("title", sort=False).share.mean().idxmax()
        shares = 100.0 * moved.share[moved.title == most]
        answer["moved_by"] = f"{most} ({shares.min():.0f} to {shares.max():.0f} %)"
    return answer


def _rows_of(table: pd.DataFrame | None, claim: Claim) -> pd.DataFrame:
    """Return the rows on a claim in a table of the study of global sensitivity, if there is one."""
    if table is None:
        return pd.DataFrame(columns=["rock", "cycle", "title", *SHARES])
    here = (table.number == claim.statement.number) & (table.response == claim.variable)
    return table[here & table.cycle.isin(claim.cycles)]


def _conclusion(row: dict) -> str:
    verdict = row["verdict"]
    if row["number"] in UNJUDGED:
        return NOT_JUDGED
    if verdict == UNDECIDED:
        return UNDECIDED
    if row["opposed_by"]:
        return DEPENDS
    low = row["choices_share_low"]
    high = row["choices_share_high"]
    if np.isnan(low):
        tried = sum(row[f"readings_{name}"] for name in COUNTS) > 0
        return verdict if tried else ONLY_CONFIGURED[verdict]
    low, high = (low, high) if verdict == STANDS else (1.0 - high, 1.0 - low)
    if high < NEARLY_ALL:
        return DEPENDS
    return verdict if low >= NEARLY_ALL else UNDECIDED

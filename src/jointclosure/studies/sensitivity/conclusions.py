"""Which of the paper's conclusions stand, which fall, and which hang on what it leaves open."""

import numpy as np
import pandas as pd

from jointclosure.statistics.verdicts import CANNOT_BE_TOLD, FALLS, STANDS

DEPENDS = "depends on what is unstated"
"""Said of a conclusion that is true under some readings or choices, and false under others."""

NEARLY_ALL = 0.9
"""Share of the open choices for which a verdict must hold to be said without them."""

OF_CHOICES = {
    "1a, cycle 1": ("1a", "closure", 1),
    "1a, cycle 2": ("1a", "closure", 2),
    "2a": ("2a", "closure", 2),
    "2a, net": ("2a", "closure_net", 2),
    "3": ("3", "closure", 2),
    "5a": ("5a", "closure", 2),
    "5a, net": ("5a", "closure_net", 2),
    "5b": ("5b", "closure", 2),
    "5c": ("5c", "closure", 1),
}
"""Number, response and cycle under which the study of global sensitivity has a claim."""

FOUND = ("found_share", "found_error", "found_low", "found_high")
"""Columns on how often studies find a claim: share, standard error, 95 % interval."""

_MOST_NAMED = 3


def conclusion_table(
    claims: pd.DataFrame,
    jrc_range: pd.DataFrame,
    readings: pd.DataFrame | None = None,
    choices: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """What each claim rests on, and what is left of it.

    Parameters
    ----------
    claims : DataFrame
        The study's, as from `jointclosure.studies.sensitivity.claims`.
    jrc_range : DataFrame
        How often studies find each claim where a JRC is known to a range (`jrc_range_tables`).
    readings : DataFrame, optional
        Table of `make readings`. Those that the paper's text rules out do not count, and a claim
        about all rocks stands only in a reading that closed all of them.
    choices : DataFrame, optional
        Shares of the open choices of `make global-sensitivity`.

    Returns
    -------
    DataFrame
        A row a claim: ``number``, ``claim``, ``verdict`` as configured, `FOUND` of studies by the
        paper's protocol, ``jrc_half_width`` and the same at the largest one, ``readings_stand``,
        ``readings_fall`` and ``readings_open`` (numbers), ``opposed_by`` (titles of readings of
        the opposite verdict), ``choices_share`` and ``choices_error`` (in all rocks at once), and
        the ``conclusion``: the verdict, where no reading is opposed and at least `NEARLY_ALL` of
        the choices agree; `DEPENDS`, where one is opposed or fewer agree; "cannot be told" where
        the verdict is that, or the share of choices is not known well enough (two standard
        errors). What was not studied does not count.
    """
    rows = []
    for claim in claims.itertuples():
        row = {"number": claim.number, "claim": claim.claim, "verdict": claim.verdict}
        row |= {name: getattr(claim, name) for name in FOUND}
        row |= _of_jrc(claim.number, jrc_range) | _of_readings(claim, readings)
        row |= _of_choices(claim.number, choices)
        rows.append(row | {"conclusion": _conclusion(row)})
    return pd.DataFrame(rows)


def _of_jrc(number: str, jrc_range: pd.DataFrame) -> dict:
    own = jrc_range[(jrc_range.number == number) & (jrc_range.half_width > 0.0)]
    widest = own.sort_values("half_width").reindex(columns=["half_width", *FOUND])
    found = widest.iloc[-1] if len(widest) else pd.Series(np.nan, widest.columns)
    return {f"jrc_{name}": found[name] for name in widest.columns}


def _of_readings(claim, readings: pd.DataFrame | None) -> dict:
    """Verdicts of the readings that the paper allows."""
    column = f"claim {claim.number}"
    if readings is None or column not in readings:
        return dict.fromkeys(("readings_stand", "readings_fall", "readings_open"), np.nan) | {
            "opposed_by": ""
        }
    allowed = readings[readings.allowed]
    verdicts = allowed[column].copy()
    whole = allowed.rocks.str.len() == allowed.rocks.str.len().max()
    verdicts[(verdicts == STANDS) & ~whole & (claim.verdict == FALLS)] = CANNOT_BE_TOLD
    opposite = {STANDS: FALLS, FALLS: STANDS}.get(claim.verdict)
    opposed = allowed[verdicts == opposite].title.tolist()
    named = "; ".join(opposed[:_MOST_NAMED])
    rest = len(opposed) - _MOST_NAMED
    return {
        "readings_stand": int((verdicts == STANDS).sum()),
        "readings_fall": int((verdicts == FALLS).sum()),
        "readings_open": int((verdicts == CANNOT_BE_TOLD).sum()),
        "opposed_by": f"{named}; {rest} more" if rest > 0 else named,
    }


def _of_choices(number: str, choices: pd.DataFrame | None) -> dict:
    """Share of the choices for which a claim is true in all rocks at once."""
    if choices is None or number not in OF_CHOICES:
        return {"choices_share": np.nan, "choices_error": np.nan}
    name, response, cycle = OF_CHOICES[number]
    here = (choices.number == name) & (choices.response == response) & (choices.cycle == cycle)
    (own,) = choices[here & (choices.rock == "all")].itertuples()
    return {"choices_share": own.share, "choices_error": own.share_error}


def _conclusion(row: dict) -> str:
    verdict = row["verdict"]
    if verdict == CANNOT_BE_TOLD:
        return CANNOT_BE_TOLD
    if row["opposed_by"]:
        return DEPENDS
    if np.isnan(row["choices_share"]):
        return verdict
    agree = row["choices_share"] if verdict == STANDS else 1.0 - row["choices_share"]
    if agree + 2.0 * row["choices_error"] < NEARLY_ALL:
        return DEPENDS
    return verdict if agree - 2.0 * row["choices_error"] >= NEARLY_ALL else CANNOT_BE_TOLD

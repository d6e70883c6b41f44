"""What a report says of the numerical stability of joints, and what was not tested."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from jointclosure.assessment.hardness import MEANINGS

NOT_STABLE, HARD = list(MEANINGS)[:2]
UNTESTED = (
    "Whether the others are easy or not stable is not known. It takes copies of a joint that "
    "should be equal, finer numerics, and a comparison with an independent implementation. "
)
"""What a verdict on joints without a remark takes."""


def stability(known: Mapping[str, pd.DataFrame], about: Mapping[str, Any]) -> list[str]:
    """Say which joints of a study are numerically stable, as far as this is known.

    Parameters
    ----------
    known : mapping
        Tables of the study by name. Used are ``study_hardness``, ``study_assessment`` and that of
        `make assess`, ``hardness``; each may be missing.
    about : mapping
        What the report shows of the assessment (`studies.paper.report.content.assessed`).
    """
    sentences = list[str]()
    if "study_hardness" in known and len(known["study_hardness"]):
        sentences.append(_of_study(known["study_hardness"]))
    if about["state"] == "done" and "study_assessment" in known:
        sentences += _of_settings(known["study_assessment"])
    if not sentences:
        return []
    if "hardness" in known and len(known["hardness"]):
        return [*sentences, _by_copies(known["hardness"])]
    further = "make assess tests this for joints of the base case."
    return [*sentences, UNTESTED + further]


def _of_study(hardness: pd.DataFrame) -> str:
    """Count the joints of the study by what makes them not stable or hard."""
    total = int(hardness.ranked.iloc[0])
    counts = hardness.dropna(subset="verdict").groupby("verdict", sort=False).verdict_joints.first()
    failed = counts.get(f"{NOT_STABLE}: failed", 0)
    found = [f"{failed} failed and so are not numerically stable"] if failed else ["none failed"]
    found += [
        f"{count} are {verdict}" if verdict.startswith(HARD) else f"{count} {verdict}"
        for verdict, count in counts.items()
        if verdict and not str(verdict).startswith(NOT_STABLE)
    ]
    return f"Of {total} joints of this study, by its own numerics, {'; '.join(found)}."


def _of_settings(table: pd.DataFrame) -> list[str]:
    """Say how many of the joints by which settings are compared failed by each of these."""
    settings = table[(table.kind == "setting") & (table.cycle == 1)]
    counts = settings.groupby("variant", sort=False)[["joints", "failed"]].max()
    if not len(counts):
        return []
    failed = counts[counts.failed > 0]
    total = int((counts.joints + counts.failed).max())
    settings_text = " and by ".join(counts.index)
    if not len(failed):
        return [f"None of {total} joints failed that were simulated by {settings_text}."]
    each = "; ".join(f"by {name} {row.failed:.0f} failed" for name, row in failed.iterrows())
    return [
        f"Of {total} joints that were simulated by {settings_text}: {each}. They are not stable."
    ]


def _by_copies(hardness: pd.DataFrame) -> str:
    """Count the verdicts of `make assess` on joints of base cases."""
    counts = hardness.verdict.value_counts()
    found = ", ".join(f"{counts.get(verdict, 0)} {verdict}" for verdict in MEANINGS)
    return f"By copies and finer numerics (make assess) {len(hardness)} joints are: {found}."

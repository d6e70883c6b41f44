"""Tables of the page: results of a study, and how its simulations ended.

Captions, columns and headings are in the page's templates.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.assessment.assessed_results import ASSESSED, JUDGED
from jointclosure.assessment.effect_names import effects_title
from jointclosure.joint.status import FAILURE, FLAGS
from jointclosure.parameters import PROPERTIES, scene_of
from jointclosure.statistics.number_texts import (
    ABSENT,
    percent,
    rounded,
    with_equal_decimals,
)
from studies.frame.joint_tables import changes_of_cases, in_words, succeeded
from studies.paper.checks import change_in_words, remarked_joints
from studies.paper.claims import CLAIMS, FOUND
from studies.paper.conclusions import COUNTS
from studies.paper.report.verdicts import TOO_FEW, is_unknown
from studies.paper.requirements import REPORTED
from studies.paper.tables_1_to_3 import table_3

NOT_TRIED = "not tried"
"""Entry for a claim without readings or choices."""
LEAST_SHOWN = 0.001
"""Smallest probability that is shown as a number."""
MOST_FAILURES = 500
"""Largest number of failed simulations that are listed."""
MOST_HARD = 200
"""Largest number of joints that are listed by hardness."""
_PROPERTY = {name: about.title for name, about in PROPERTIES.items()}
_WITH_UNITS = {name: about.title + about.in_brackets for name, about in PROPERTIES.items()}


class About(NamedTuple):
    """Titles of a study's rocks by name, in order, and the names of those that the paper has."""

    titles: dict[str, str]
    of_paper: set[str]

    def titled(self, table: pd.DataFrame, parameters: Mapping = _PROPERTY) -> pd.DataFrame:
        """Replace names of rocks, and of properties, by their titles."""
        names = {"rock": self.titles, "parameter": parameters}
        return table.assign(
            **{column: table[column].map(names[column]) for column in names if column in table}
        )


def flow(table: pd.DataFrame) -> pd.DataFrame:
    """Select apertures of each base case at the largest stress that the most joints reach."""
    loading = table[(table.parameter == "base") & (table.branch == "loading")]
    by = ["rock", "cycle", "direction"]
    most = loading.groupby(by, sort=False).samples.transform("max")
    reached = loading[loading.samples == most]
    return reached.loc[reached.groupby(by, sort=False).stress_MPa.idxmax()]


def layout(intervals: pd.DataFrame, about: About) -> pd.DataFrame:
    """Arrange Table 3 by parameter, cycle and rock, with the paper's lengths below the study's."""
    ours = table_3(intervals, about.titles)
    theirs = table_3(intervals, about.titles, "paper_") if about.of_paper else None
    rows = []
    for parameter in ours.index:
        for cycle in dict.fromkeys(cycle for cycle, _ in ours.columns):
            cells = [_WITH_UNITS[parameter], str(cycle)]
            for rock, title in about.titles.items():
                text = ours.loc[parameter, [(cycle, title)]].iloc[0]
                if theirs is not None and rock in about.of_paper:
                    text += f"\npaper {theirs.loc[parameter, [(cycle, title)]].iloc[0]}"
                cells.append(text)
            rows.append(cells)
    return pd.DataFrame(rows, columns=["Parameter", "Cycle", *about.titles.values()])


def judged(claims: pd.DataFrame) -> pd.DataFrame:
    """Add the share of studies that confirm a claim as text, and remarks to the verdicts."""
    remarks = {claim.number: f" ({claim.remark})" for claim in CLAIMS if claim.remark}
    found = [percent_text(*row) for row in claims[list(FOUND)].to_numpy(dtype=float).tolist()]
    verdict = claims.verdict + claims.number.map(remarks).fillna("")
    return claims.assign(found=found, verdict=verdict)


def evidence(claims: pd.DataFrame, margins: pd.DataFrame, about: About) -> pd.DataFrame:
    """Tabulate the numbers that decide claims: of the model by rock, and of the paper."""
    rows = []
    for claim in claims.itertuples():
        here = {"number": claim.number, "verdict": claim.verdict}
        for row in margins[(margins.number == claim.number) & margins.decides].itertuples():
            value = rounded(row.value, row.standard_error)
            of = {"by": "the model", "where": about.titles[row.rock], "cycle": row.cycle}
            rows.append(here | of | {"quantity": row.quantity, "value": value})
        if about.of_paper and isinstance(getattr(claim, "paper", None), str):
            paper = {"by": "the paper", "where": "", "cycle": "", "value": claim.paper}
            rows.append(here | paper)  # an empty cycle, as NaN would make the others fractions
    columns = ["number", "by", "where", "cycle", "quantity", "value", "verdict"]
    return pd.DataFrame(rows, columns=columns)


def concluded(conclusions: pd.DataFrame) -> pd.DataFrame:
    """Tabulate the evidence for each claim, and the conclusion (`make conclusions`)."""
    shown = judged(conclusions)
    for kind in ("readings", "partial"):
        counts = conclusions[[f"{kind}_{name}" for name in COUNTS]]
        shown[kind] = [_tried(row) for row in counts.to_numpy(dtype=float).tolist()]
    shares = conclusions[[f"choices_share{end}" for end in ("", "_low", "_high")]]
    shown["choices"] = [
        NOT_TRIED if np.isnan(row[0]) else "{} ({} to {})".format(*map(percent, row))
        for row in shares.to_numpy(dtype=float).tolist()
    ]
    return shown


def _tried(counts: list[float]) -> str:
    if np.isnan(counts[0]):
        return NOT_TRIED
    return ", ".join(f"{count:.0f}" for count in counts) if sum(counts) else "none"


def probability(value: float, error: float) -> str:
    """Format a probability with its standard error; "< 0.001" if it is smaller with its error."""
    if pd.isna(value):
        return ABSENT
    small = value < LEAST_SHOWN and not error >= LEAST_SHOWN
    return f"< {LEAST_SHOWN:g}" if small else rounded(value, error)


def percent_text(share: float, error: float, low: float = np.nan, high: float = np.nan) -> str:
    """Format a share in percent with its 95 % interval, such as "98 % (91 to 100)".

    An interval that is not given is two standard errors to each side, and ends at 0 and 100 %.
    """
    if pd.isna(share):
        return ""
    if pd.isna(low):
        low, high = max(share - 2.0 * error, 0.0), min(share + 2.0 * error, 1.0)
    if pd.isna(low) or low == high:
        return percent(share)
    return f"{percent(share)} ({100.0 * low:.3g} to {100.0 * high:.3g})"


def predicted(predictive: pd.DataFrame) -> pd.DataFrame:
    """Add texts of shares and probabilities to the table of predicted entries of Table 3."""
    shares = zip(predictive.share_without_root, predictive.share_error, strict=True)
    none = [percent_text(share, error) for share, error in shares]
    known = predictive.get("share_zero", pd.Series(np.nan, predictive.index))  # not in older tables
    zero = [ABSENT if pd.isna(share) else percent(share) for share in known]
    return _with_errors(predictive.assign(none=none, zero=zero), probability, "p", "null_p")


def _with_errors(table: pd.DataFrame, shown: Callable, *names: str) -> pd.DataFrame:
    """Replace columns by cells of their numbers and errors (columns with the suffix _error)."""
    cells = {
        name: list(map(shown, table[name], table[f"{name}_error"]))
        for name in names
        if name in table
    }
    return table.assign(**cells)


def with_errors_of_joint_tests(joint: pd.DataFrame) -> pd.DataFrame:
    """Add texts of numbers with their errors to the table of joint tests."""
    table = _with_errors(joint, probability, "p", "null_p")
    likelihoods = ("log_likelihood", "null_log_likelihood")
    return _with_errors(table, rounded, *likelihoods)


def base_closures(table: pd.DataFrame) -> pd.DataFrame:
    """Select the closures of base cases; adjusted means only where their errors are smaller."""
    base = table[table.parameter == "base"].copy()
    mean, adjusted = "max_closure_mean_mm", "max_closure_adjusted_mean_mm"
    if adjusted in base:
        worse = base[f"{adjusted}_standard_error"] >= base[f"{mean}_standard_error"]
        base.loc[worse, [adjusted, f"{adjusted}_standard_error"]] = np.nan
    return base


def checked(checks: pd.DataFrame) -> pd.DataFrame:
    """Add verdicts to the table of checks."""
    verdict = np.where(checks.passed, "passed", "FAILED")
    return checks.assign(verdict=np.where(checks.required == REPORTED, REPORTED, verdict))


def differing(table: pd.DataFrame) -> pd.DataFrame:
    """Select the differences of closures of variants from their reference."""
    shown = table[(table.variant != table.reference) & table.quantity.isin(JUDGED)]
    by = shown.get("needed_by", pd.Series("", shown.index))  # not in older tables
    return shown.assign(quantity=shown.quantity.map(ASSESSED), needed_by=by)


def assessed(table: pd.DataFrame, about: About) -> dict[str, pd.DataFrame]:
    """Return the tables of settings and of effects from that of the study's assessment.

    Rocks have their titles, and all rocks together are named "all". An empty table is left out.
    """
    shown = table.assign(
        rock=table.rock.map(about.titles).fillna("all"),
        reason=[
            ": ".join(words for words in row if isinstance(words, str) and words)
            for row in zip(table.state, table.reason, strict=True)
        ],
    )
    for name in ("cycle", "joints"):
        shown[name] = [
            ABSENT if pd.isna(x) else f"{x:.0f}" for x in shown.get(name, [np.nan] * len(shown))
        ]
    shown["needed_by"] = shown.get("needed_by", pd.Series("", shown.index))  # not in older tables
    columns = {"change": "change_percent", "gross": "gross_percent", "remains": "remains_points"}
    for name, column in columns.items():
        shown[name] = [with_limits(row, column) for _, row in shown.iterrows()]
    return {f"study_{kind}": part for kind, part in shown.groupby("kind", sort=False)}


def with_limits(row: pd.Series, name: str) -> str:
    """Format a number with its 95 % interval, such as "-3.1 (-9.2 to 3.0)".

    Where one joint has no interval, or the interval is so wide that nothing is known, the text is
    `TOO_FEW`.
    """
    value, low, high = (row.get(f"{name}{end}", np.nan) for end in ("", "_low", "_high"))
    if pd.isna(value):
        return ABSENT
    if is_unknown(row, name):
        return TOO_FEW
    shown = with_equal_decimals([value, low, high])
    return f"{shown[0]} ({shown[1]} to {shown[2]})"


def hardest(table: pd.DataFrame, study: xr.Dataset, about: About) -> pd.DataFrame:
    """Tabulate the hardest joints of a study, the worst first, at most `MOST_HARD`."""
    names = ("rock", "parameter", "level")
    cases = zip(*(study[name].values.tolist() for name in names), strict=True)
    changes = dict(zip(cases, changes_of_cases(study).values(), strict=True))
    return pd.DataFrame(
        {
            "Rock": table.rock.map(about.titles),
            "Changed": [
                changes[case] or "as it is"
                for case in table[list(names)].itertuples(index=False, name=None)
            ],
            "Joint": table.joint,
            "Verdict": [
                words if isinstance(words, str) and words else "no remark"
                for words in table.verdict
            ],
            "Reason": table.reason,
        }
    ).head(MOST_HARD)


def statuses(study: xr.Dataset, about: About) -> pd.DataFrame:
    """Count the simulations of each case by status."""
    good = succeeded(study)
    frame = pd.DataFrame(
        {
            "Rock": [about.titles[rock] for rock in study.rock.values],
            "Changed": [text or "as it is" for text in changes_of_cases(study).values()],
            "Simulations": study.sizes["realization"],
            "Used (n)": good.sum("realization").values,
            "Failed": (~good).sum("realization").values,
        }
    )
    for mask, name in FLAGS.items():
        counts = ((study.status & mask) > 0).sum("realization").values
        if mask < FAILURE or counts.any():
            frame[in_words(name)] = counts
    scenes = map(scene_of, study.scene.values.tolist())
    return frame.assign(**{"Effects that act": list(map(effects_title, scenes))})


def remarks(study: xr.Dataset, about: About) -> pd.DataFrame:
    """Tabulate joints with a remark by case, and the change of means without them."""
    rows = []
    changes = changes_of_cases(study)
    for (remark, _), part in remarked_joints(study).groupby(["remark", "case"], sort=False):
        first = part.iloc[0]
        row: dict[str, object] = {
            "Rock": about.titles[first.rock],
            "Changed": changes[first.case] or "as it is",
            "Remark": in_words(str(remark)),
            "Joints": first.joints,
            "Of used (n)": first.samples,
        }
        for line in part.itertuples():
            row[f"Change of mean net closure without them, cycle {line.cycle}"] = change_in_words(
                line
            )
        rows.append(row)
    return pd.DataFrame(rows)


def failures(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate failed simulations with the seeds of their walls, at most `MOST_FAILURES`."""
    rows = []
    statuses = study.status.transpose("case", "realization").values
    seeds = study.seed.transpose("case", "realization").values
    for i, j in np.argwhere(statuses >= FAILURE)[:MOST_FAILURES]:
        words = [in_words(name) for mask, name in FLAGS.items() if int(statuses[i, j]) & mask]
        place = study.case.values[i], int(study.realization.values[j])
        rows.append((*place, ", ".join(words), str(seeds[i, j])))
    return pd.DataFrame(rows, columns=["case", "realization", "status", "seed"])


_PREPARED: dict[str, Callable[[pd.DataFrame], pd.DataFrame]] = {
    "max_closure": base_closures,
    "checks": checked,
    "claims": judged,
    "conclusions": concluded,
    "hydraulic_aperture": flow,
    "measured_fit": pd.DataFrame,
    "table_3_joint_tests": with_errors_of_joint_tests,
    "elasticities": pd.DataFrame,
    "accuracy_reached": lambda table: table.assign(
        quantity=[ASSESSED.get(name, name.replace("_", " ")) for name in table.quantity]
    ),
}
"""Functions that prepare tables by name; rocks and properties then get their titles."""


def frames_of(
    study: xr.Dataset, known: Mapping[str, pd.DataFrame], about: About
) -> dict[str, pd.DataFrame]:
    """Return the tables of the page by name, as far as the study has what they are made of."""
    known = {name: table for name, table in known.items() if len(table)}
    frames = {"statuses": statuses(study, about), "failures": failures(study)}
    if len(with_remarks := remarks(study, about)):
        frames["remarks"] = with_remarks
    if "claim_margins" in known:
        frames["evidence"] = evidence(known["claims"], known["claim_margins"], about)
    if "percent" in known.get("table_3_indifference", ()):
        frames["table_3"] = layout(known["table_3_indifference"], about)
    if "table_3_predictive" in known:
        predictive = predicted(known["table_3_predictive"])
        frames["table_3_predictive"] = about.titled(predictive, _WITH_UNITS)
    for name, prepared in (("assessment", differing), ("hardness", pd.DataFrame)):
        if name in known:
            frames[name] = about.titled(prepared(known[name]))
    if "study_assessment" in known:
        frames |= assessed(known["study_assessment"], about)
    if "study_hardness" in known:
        frames["study_hardness"] = hardest(known["study_hardness"], study, about)
    return frames | {
        name: about.titled(prepared(known[name]))
        for name, prepared in _PREPARED.items()
        if name in known
    }

"""Results of `make assess` in the report of a study, in place of those of its own, fewer joints."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from jointclosure.assessment.effect_names import lacks_effects
from jointclosure.assessment.verdicts import GIVEN_UP, NEEDED_AS_FAILS
from jointclosure.compilation.code_digests import code_digest
from jointclosure.statistics.standard_errors import Estimate
from jointclosure.storage.files import digest
from studies.assessment.report_tables import (
    ALL_ROCKS,
    EFFECTS,
    ENDS,
    LEFT_OUT,
    SETTING,
    SHOWN_COLUMNS,
    judged_effects,
    judged_setting,
    relative_change,
    together,
    with_failures,
)
from studies.frame.cases import base_case
from studies.frame.configuration import Configuration
from studies.frame.experiments import settings_of
from studies.paper.closure_tables import estimate_columns


class BaseCondition(NamedTuple):
    """Condition of the base case of a rock in a study."""

    jrc: float  # NaN for scanned walls
    stress_MPa: float  # maximum stress
    key: str  # digest of all on which the joints of the base case depend

    def is_at(self, at: Mapping[str, Any]) -> bool:
        """Return whether the condition ``at`` of an assessment has this JRC and stress."""
        return bool(
            np.isclose([at["jrc"], at["stress_MPa"]], self[:2], rtol=1e-9, equal_nan=True).all()
        )


def base_conditions(study: Configuration) -> dict[str, BaseCondition]:
    """Return the condition of the base case of each rock of a study."""
    code = code_digest("jointclosure.ensembles.simulation:simulate_row")
    conditions = {}
    for rock in study.rocks:
        case = base_case(study, rock)
        key = digest(settings_of(study, case)._replace(realizations=0), code)
        conditions[rock] = BaseCondition(case.jrc, 1e-6 * case.max_normal_stress, key)
    return conditions


def with_larger(
    table: pd.DataFrame,
    larger: pd.DataFrame,
    conditions: Mapping[str, BaseCondition],
    stated: str,
    within: float,
) -> tuple[pd.DataFrame, int]:
    """Return the table of the assessment in a report, from more joints if `make assess` had more.

    Parameters
    ----------
    table : DataFrame
        Table of the assessment in the report (`assessed_table`).
    larger : DataFrame
        Table ``assessment.csv`` of `make assess`.
    conditions : mapping
        Those of the study's base cases (`base_conditions`).
    stated : str
        Name of the variant with the settings of the study.
    within : float
        Request [1].

    Returns
    -------
    DataFrame, int
        The table in the columns of ``table``, and the fewest joints of a rock in it. It is
        ``table``, with 0 joints, unless ``larger`` has more joints of every rock of the study, and
        they were simulated with the same settings. Intervals of all rocks together combine those of
        the rocks as independent ones. They use Student's t of one rock, and so are rather too wide.
        The share of closure that remains at seating is not known, nor are errors of times if
        ``larger`` does not have them.
    """
    keys = {rock: condition.key for rock, condition in conditions.items()}
    same = larger[larger.get("study_key", "") == larger.rock.map(keys)]
    few = table.joints.where(table.rock != ALL_ROCKS).max() if "joints" in table else 0
    if set(same.rock) != set(keys) or not same.joints.min() > few:
        return table, 0
    rows = list[dict[str, Any]]()
    for rock, of_rock in same.groupby("rock", sort=False):
        rows += _rows(of_rock, str(rock), stated, within)
    if len(keys) > 1:
        rows += _rows_of_all_rocks(pd.DataFrame(rows), len(keys), within)
    made = pd.DataFrame(rows)
    states = table[table.kind == EFFECTS].drop_duplicates(["rock", "variant"])
    states = states.set_index(["rock", "variant"])
    measured = pd.MultiIndex.from_frame(made[["rock", "variant"]])
    left_out = states[states.state == LEFT_OUT].reindex(measured)
    for name in ("state", "reason"):
        made[name] = made[name].where(left_out[name].isna().to_numpy(), left_out[name].to_numpy())
    others = states[~states.index.isin(measured)].reset_index()
    kept = ["rock", "variant", "kind", "state", "reason"]
    others = others[others.cycle.isna() if "cycle" in others else others.index >= 0][kept]
    made = pd.concat([made, others], ignore_index=True)
    made = made.reindex(columns=list(dict.fromkeys([*table.columns, *made.columns])))
    words = {"verdict": "", "needed_by": "", "state": "", "reason": ""}
    return with_failures(made.fillna(words)), int(same.joints.min())


def _rows(of_rock: pd.DataFrame, rock: str, stated: str, within: float) -> list[dict[str, Any]]:
    """Return the rows of a rock's table ``assessment.csv`` in the columns of `assessed_table`.

    ``stated`` and ``within`` are those of `with_larger`.
    """
    # tables of an earlier version have no errors of times
    of_rock = of_rock.assign(error=of_rock.get("seconds_standard_error", math.nan))
    times = {
        variant: Estimate(*part[["seconds", "error"]].iloc[0])
        for variant, part in of_rock.groupby("variant")
    }
    rows = []
    for variant, of_variant in of_rock.groupby("variant", sort=False):
        effects = bool(lacks_effects(pd.Series([variant]))[0])
        cycles = []
        for cycle, part in of_variant.groupby("cycle"):
            first = part.iloc[0]
            given_up = str(first.verdict) == GIVEN_UP
            fails = given_up or str(first.verdict) == NEEDED_AS_FAILS
            row: dict[str, Any] = {"rock": rock, "kind": EFFECTS if effects else SETTING}
            row |= {"variant": variant, "reference": first.reference, "cycle": cycle}
            # tables of an earlier version have no counts
            failed = int(first.get("failed", fails))
            row |= {"of_study": variant == stated, "joints": first.joints - failed}
            row |= {"failed": failed, "given_up": int(first.get("given_up", given_up))}
            for quantity, name in SHOWN_COLUMNS.items():
                found = part[part.quantity == quantity].iloc[0]
                row |= {
                    f"{name}_percent{suffix}": found[f"{end}_percent"]
                    for end, suffix in ENDS.items()
                }
            seconds = Estimate(math.nan, math.nan) if fails else times[variant]
            row |= estimate_columns("seconds", seconds)
            change = relative_change(seconds, times[stated], variant == stated)
            row |= estimate_columns("time_percent", change, 100.0)
            cycles.append({"state": "", "reason": ""} | row)
        rows += _judged(cycles, within)
    return rows


def _judged(rows: list[dict[str, Any]], within: float) -> list[dict[str, Any]]:
    """Return the rows of the cycles of one variant with the verdicts on it."""
    if rows[0]["kind"] == EFFECTS:
        verdict, needed_by = judged_effects(rows, within)
        return [row | {"verdict": verdict, "needed_by": needed_by} for row in rows]
    return [row | {"verdict": judged_setting(row, within), "needed_by": ""} for row in rows]


def _rows_of_all_rocks(table: pd.DataFrame, rocks: int, within: float) -> list[dict[str, Any]]:
    """Return the rows of all rocks together, for the variants and cycles that every rock has.

    ``rocks`` is the number of rocks.
    """
    rows = []
    for _, of_variant in table.groupby("variant", sort=False):
        cycles = []
        for _, part in of_variant.groupby("cycle"):
            if len(part) < rocks:
                continue
            row = part.iloc[0].to_dict() | {"rock": ALL_ROCKS}
            row |= {name: part[name].sum() for name in ("joints", "failed", "given_up")}
            for name in ("seconds", "time_percent"):
                columns = part[[name, f"{name}_standard_error"]].to_numpy()
                row |= estimate_columns(name, together([Estimate(*one) for one in columns]))
            for name in (f"{name}_percent" for name in SHOWN_COLUMNS.values()):
                value = part[name].mean()
                half = np.linalg.norm(part[f"{name}_high"] - part[name]) / rocks
                low = max(value - half, -100.0)  # as `change_interval`
                row |= {name: value, f"{name}_low": low, f"{name}_high": value + half}
            cycles.append(row)
        rows += _judged(cycles, within) if cycles else []
    return rows

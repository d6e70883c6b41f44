"""Means of quantities over surfaces, in the columns and units of tables."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from jointclosure.engine.quantities import COLUMNS, COORDINATES, QUANTITIES, shown_as
from jointclosure.statistics.standard_errors import Estimate, harmonic_mean, ratio_of_means


def grouped(joints: pd.DataFrame, *by: str) -> Iterator[tuple[dict[str, Any], pd.DataFrame]]:
    """Generate the joints with equal coordinates, and these in the columns of a published table."""
    for values, part in joints.groupby(list(by), sort=False, dropna=False):
        at = {}
        for name, value in zip(by, values, strict=True):
            column, scale = shown_as(name, COORDINATES.get(name, ("", "1"))[1])
            at[column] = value if scale == 1.0 else scale * value
        yield at, part


def mean_shown(name: str, values: np.ndarray) -> Estimate:
    """Compute the mean (harmonic for stiffnesses) of a quantity (n,) [SI] in the unit of tables."""
    shown = COLUMNS[name][1] * np.asarray(values, dtype=float)
    if QUANTITIES[name].harmonic:
        return harmonic_mean(shown)
    return ratio_of_means(shown, np.ones(shown.size))


def means(joints: pd.DataFrame, names: Sequence[str]) -> dict[str, float]:
    """Compute the means of quantities with their errors, by column of a table."""
    row = {}
    for name in names:
        column = COLUMNS[name][0]
        row[column], row[f"{column}_error"] = mean_shown(name, joints[name].to_numpy())
    return row


def summary(
    joints: pd.DataFrame, by: Sequence[str], names: Sequence[str], reference: Mapping[str, Any]
) -> pd.DataFrame:
    """Tabulate means over surfaces, and their paired changes [%] from a reference.

    ``by`` are the columns that name a point, and ``reference`` values of some of them.
    """
    others = [name for name in (*by, "cycle") if name not in reference]
    here = (joints[list(reference)] == pd.Series(reference)).all(axis=1)
    bases = dict(list(joints[here].groupby(others)))
    rows = []
    for at, part in grouped(joints, *by, "cycle"):
        base = bases[tuple(part[others].iloc[0])]
        for name in names:
            values, before = part[name].to_numpy(), base[name].to_numpy()
            rows.append(at | {"response": name} | _change(name, values, before))
    return pd.DataFrame(rows)


def _change(name: str, values: np.ndarray, before: np.ndarray) -> dict[str, float]:
    """Compute the mean of a quantity, and its change from ``before`` on the same surfaces."""
    both = np.isfinite(values) & np.isfinite(before)
    values, before = values[both], before[both]
    over, under = (1.0 / before, 1.0 / values) if QUANTITIES[name].harmonic else (values, before)
    mean, ratio = mean_shown(name, values), ratio_of_means(over, under)
    return {
        "value": mean.value,
        "error": mean.standard_error,
        "change_percent": 100.0 * (ratio.value - 1.0),
        "change_error": 100.0 * ratio.standard_error,
        "samples": int(both.sum()),
    }

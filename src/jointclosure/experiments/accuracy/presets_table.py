"""What each setting of the numerics was off by, and what it took: the table that presets are of."""

import json
from collections.abc import Iterator

import pandas as pd

from jointclosure.experiments.accuracy.design import Setting


def setting_table(
    costs: pd.DataFrame, settings: list[Setting], scenes: dict, presets: dict
) -> pd.DataFrame:
    """What each setting of the numerics was off by, and what it took.

    Parameters
    ----------
    costs : DataFrame
        As from `jointclosure.experiments.accuracy.cost.cost_table`.
    settings : list of Setting
        Those of the costs.
    scenes : dict
        The variants of the model, with their ``finest`` setting, and where there is one
        its ``cross``: the finest setting of another integrator.
    presets : dict
        Knob and value of every preset, by name.

    Returns
    -------
    DataFrame
        For each variant and setting: ``numerics``, as JSON, in which it differs from the
        variant's base; ``error_percent``, the largest |error| of a mean maximum closure of a
        rock and cycle; ``bound_percent``, the largest end of their confidence intervals;
        ``relative_time``, ``pairs`` (of FFTs) and ``seconds``, means of the rocks' medians.

    Notes
    -----
    All settings of a variant are held against one truth, its finest setting. That one's own
    error is 0 by this, and its bound that of the finest setting of the other integrator.
    """
    rows = []
    for scene, about in scenes.items():
        for setting, changed in _numerical(settings, scene):
            point = _point(setting.knob, setting.value)
            part = _rows_of(costs, scene, point)
            names = [name for name, each in presets.items() if each == point]
            row = {"scene": scene, "preset": names[0] if names else ""} | point
            row |= _worst(part)
            if point == about["finest"] and about.get("cross"):
                row["bound_percent"] = _worst(_rows_of(costs, scene, about["cross"]))[
                    "bound_percent"
                ]
            row |= dict(part[["relative_time", "pairs", "seconds"]].mean())
            rows.append(row | {"numerics": json.dumps(changed)})
    return pd.DataFrame(rows)


def _worst(part: pd.DataFrame) -> dict:
    """Largest error of a rock and cycle, and largest end of a confidence interval."""
    return {
        "error_percent": part.mean_error_percent.abs().max(),
        "bound_percent": part[["mean_low", "mean_high"]].abs().max(axis=None),
    }


def _point(knob: str, value: float | str) -> dict:
    return {"knob": knob, "value": value}


def _rows_of(costs: pd.DataFrame, scene: str, point: dict) -> pd.DataFrame:
    here = (costs.scene == scene) & (costs.knob == point["knob"])
    return costs[here & (costs["value"] == point["value"])]


def _numerical(settings: list[Setting], scene: str) -> Iterator[tuple[Setting, dict]]:
    """Settings of a variant's first rock that differ from its base in numerics only, and how."""
    mine = [each for each in settings if each.scene == scene]
    mine = [each for each in mine if each.rock == mine[0].rock]
    for setting in mine:
        if setting.numerics is not None:
            yield setting, setting.numerics

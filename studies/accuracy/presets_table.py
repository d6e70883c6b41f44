"""Table of errors and costs of the settings of the numerics, from which presets are made."""

import json

import pandas as pd

from studies.accuracy.design import Setting


def setting_table(
    costs: pd.DataFrame, settings: list[Setting], scenes: dict, presets: dict
) -> pd.DataFrame:
    """Summarise the error and cost of each setting of the numerics.

    Parameters
    ----------
    costs : DataFrame
        As from `studies.accuracy.cost.cost_table`.
    settings : list of Setting
        Settings of the costs.
    scenes : dict
        Variants of the model, with their ``finest`` setting and optionally
        ``cross``, the finest setting of another integrator.
    presets : dict
        Knob and value of every preset, by name.

    Returns
    -------
    DataFrame
        For each variant and setting of its first rock that differs from the base only in numerics:
        ``numerics``, the differences as JSON; ``error_percent``, the largest |error| of a mean
        maximum closure of a rock and cycle; ``bound_percent``, the largest end of their confidence
        intervals; ``relative_time``, ``pairs`` (of FFTs) and ``seconds``, means of the rocks'
        medians.

    Notes
    -----
    The reference of all settings of a variant is its finest setting. The error of that is
    therefore 0, and its bound is that of the finest setting of the other integrator.
    """
    rows = []
    for scene, about in scenes.items():
        of_scene = [setting for setting in settings if setting.scene == scene]
        for setting in of_scene:
            if setting.rock != of_scene[0].rock or setting.numerics is None:
                continue
            point = {"knob": setting.knob, "value": setting.value}
            part = _rows_of(costs, scene, point)
            bounded = part
            if point == about["finest"] and about.get("cross"):
                bounded = _rows_of(costs, scene, about["cross"])
            names = [name for name, preset in presets.items() if preset == point]
            rows.append(
                {"scene": scene, "preset": names[0] if names else ""}
                | point
                | {"error_percent": part.mean_error_percent.abs().max()}
                | {"bound_percent": bounded[["mean_low", "mean_high"]].abs().max(axis=None)}
                | dict(part[["relative_time", "pairs", "seconds"]].mean())
                | {"numerics": json.dumps(setting.numerics)}
            )
    return pd.DataFrame(rows)


def _rows_of(costs: pd.DataFrame, scene: str, point: dict) -> pd.DataFrame:
    here = (costs.scene == scene) & (costs.knob == point["knob"])
    return costs[here & (costs["value"] == point["value"])]

"""What each setting of the numerics was off by, and what it took: the table that presets are of."""

import json
from collections.abc import Iterator

import numpy as np
import pandas as pd

from jointclosure.studies.accuracy.design import Setting


def setting_table(
    costs: pd.DataFrame, settings: list[Setting], scenes: dict, presets: dict
) -> pd.DataFrame:
    """What each setting of the numerics was off by, and what it took.

    Parameters
    ----------
    costs : DataFrame
        As from `jointclosure.studies.accuracy.cost.cost_table`.
    settings : list of Setting
        Those of the costs.
    scenes : dict
        The scenes of the design, whose ``finest`` is held against its ``cross``:
        the finest setting of another integrator.
    presets : dict
        Knob and value of every preset, by name.

    Returns
    -------
    DataFrame
        For each scene and setting: ``numerics``, as JSON, in which it differs from the
        scene's base; ``error_percent``, |error| of the mean maximum closure in the mean
        of the rocks, the larger of the cycles; ``bound_percent``, the same with half the
        width of its confidence interval on top; ``worst_percent``, the largest of a rock and
        cycle; ``relative_time``, ``pairs`` (of FFTs) and ``seconds``, means of the rocks'
        medians.
    """
    rows = []
    for scene, about in scenes.items():
        for setting, changed in _numerical(settings, scene):
            point = _point(setting.knob, setting.value)
            # the finest is held against the finest of another integrator
            judged = (about.get("cross") or point) if point == about["finest"] else point
            part, timed = (_rows_of(costs, scene, each) for each in (judged, point))
            names = [name for name, each in presets.items() if each == point]
            rows.append(
                {"scene": scene, "preset": names[0] if names else ""}
                | point
                | {
                    **_pooled(part),
                    **timed[["relative_time", "pairs", "seconds"]].mean(),
                    "numerics": json.dumps(changed),
                }
            )
    return pd.DataFrame(rows)


def _pooled(part: pd.DataFrame) -> dict:
    """Errors of a setting in the mean of its rocks, of the cycle where they are larger."""
    part = part.assign(half=0.5 * (part.mean_high - part.mean_low))
    cycles = part.groupby("cycle")
    error = cycles.mean_error_percent.mean().abs()
    half = cycles.half.apply(lambda of_rocks: np.sqrt(np.sum(of_rocks**2)) / len(of_rocks))
    return {
        "error_percent": error.max(),
        "bound_percent": (error + half).max(),
        "worst_percent": part.mean_error_percent.abs().max(),
    }


def _point(knob: str, value: float | str) -> dict:
    return {"knob": knob, "value": value}


def _rows_of(costs: pd.DataFrame, scene: str, point: dict) -> pd.DataFrame:
    here = (costs.scene == scene) & (costs.knob == point["knob"])
    return costs[here & (costs["value"] == point["value"])]


def _numerical(settings: list[Setting], scene: str) -> Iterator[tuple[Setting, dict]]:
    """Settings of a scene's first rock that differ from its base in the numerics only, and how."""
    mine = [each for each in settings if each.scene == scene]
    mine = [each for each in mine if each.rock == mine[0].rock]
    for setting in mine:
        if setting.numerics is not None:
            yield setting, setting.numerics

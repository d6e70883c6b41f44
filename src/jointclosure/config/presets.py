"""Numerics by one word, or by the accuracy that is wanted, from what was measured.

The study of accuracy (config/accuracy.yaml) writes `setting_table`, of which the
project keeps a copy in workflow/resources: what each setting was off by, and what
it took. A configuration names one of its presets, or an accuracy; then the
cheapest setting that was found to reach it is taken.
"""

import json
from collections.abc import Callable
from typing import NamedTuple

import pandas as pd

from jointclosure.config.configuration import CHOSEN_BY, effects_of
from jointclosure.inputs import InputError

SCENE = "regularised"
"""Scene whose limit an accuracy is held against: the model as stated has none."""


class Chosen(NamedTuple):
    """Numerics that stand for a preset or an accuracy, and a sentence on them."""

    numerics: dict
    said: str


def chosen_numerics(
    configuration: dict, default: dict, measured: Callable[[], pd.DataFrame]
) -> Chosen:
    """The numerics that a configuration's preset or accuracy stands for.

    Parameters
    ----------
    configuration : dict
        Whose ``numerics`` has the key ``preset`` or ``accuracy``, or neither.
    default : dict
        ``numerics`` of the default configuration, the paper's: a key that a preset
        sets and that differs from it was set by the user as well.
    measured : callable
        Gives the table of `setting_table`; called where it is needed.

    Returns
    -------
    Chosen
        Complete numerics, which keep the key that they were chosen by.

    Raises
    ------
    InputError
        Both keys, a preset that does not exist, an accuracy that no setting was found
        to reach or that has no meaning here, or a key that the choice would override.
    """
    numerics = configuration["numerics"]
    preset, accuracy = (numerics.get(key) for key in CHOSEN_BY)
    if preset is None and accuracy is None:
        return Chosen(numerics, "")
    if preset is not None and accuracy is not None:
        raise InputError(
            f"numerics.preset = {preset!r}, numerics.accuracy = {accuracy!r}: give one of them"
        )
    table = measured()
    if accuracy is None:
        row = _preset(table, preset, _scene(configuration))
    else:
        row = _accurate(configuration, table, accuracy)
    if row is None:
        return Chosen(numerics, "numerics.accuracy: nothing breaks, all is solved to 1e-10")
    changed = json.loads(row.numerics)
    here = table[table.scene == SCENE]
    touched = set().union(*(json.loads(each) for each in here.numerics))
    for key in touched:
        if numerics[key] != default[key]:
            name = "preset" if accuracy is None else "accuracy"
            raise InputError(
                f"numerics.{key} = {numerics[key]!r}: leave it out, numerics.{name} chooses it"
            )
    return Chosen(numerics | changed, _said(row, preset, accuracy))


def _scene(configuration: dict) -> str:
    """Scene of the measurements that a study's model is: its radii are bounded, or not."""
    return "full" if configuration["choices"]["largest_radius_mm"] is None else SCENE


def _preset(table: pd.DataFrame, name: object, scene: str) -> pd.Series:
    known = table[(table.preset.fillna("") != "") & (table.scene == scene)].set_index(
        "preset", drop=False
    )
    if name not in known.index:
        raise InputError(f"numerics.preset = {name!r}: must be one of {', '.join(known.index)}")
    return known.loc[name]


def _accurate(configuration: dict, table: pd.DataFrame, accuracy: object) -> pd.Series | None:
    """The cheapest setting found to be within an accuracy; None where nothing breaks."""
    if isinstance(accuracy, bool) or not isinstance(accuracy, int | float) or not 0 < accuracy < 1:
        raise InputError(f"numerics.accuracy = {accuracy!r}: must be a number between 0 and 1")
    rocks = [name for name in configuration["study"]["rocks"] if name in configuration["rocks"]]
    if not any(effects_of(configuration, rock).breakage for rock in rocks):
        return None
    if configuration["choices"]["largest_radius_mm"] is None:
        raise InputError(
            f"numerics.accuracy = {accuracy!r}: the model without choices.largest_radius_mm has no "
            "limit on the first cycle to be near (docs/decisions/0010-resolved-breakage.md): "
            "set it, to 20 for example, or give numerics.preset instead"
        )
    known = table[table.scene == SCENE]
    enough = known[known.error_percent <= 100.0 * accuracy]
    if enough.empty:
        raise InputError(
            f"numerics.accuracy = {accuracy!r}: the best that was measured is "
            f"{0.01 * known.error_percent.min():.2g} (docs/accuracy.md)"
        )
    return enough.loc[enough.pairs.idxmin()]


def _said(row: pd.Series, preset: object, accuracy: object) -> str:
    what = f"preset {preset}" if accuracy is None else f"accuracy {accuracy:g}"
    radii = "radii are bounded" if row.scene == SCENE else "radii are the paper's"
    return (
        f"numerics: {what} is {row.knob} {row['value']}: {row.numerics}; the mean of two rocks was "
        f"off by {row.error_percent:.2g} % (confidence up to {row.bound_percent:.2g} %) where "
        f"{radii}, at {row.relative_time:.2g} times the time of the paper's steps"
    ).replace(" nan", "")

"""Numerics by one word, or by the accuracy that is wanted, from what was measured.

The study of accuracy (config/accuracy.yaml) writes `setting_table`, of which the
package keeps a copy (accuracy_settings.csv): what each setting was off by, and what
it took. A configuration names one of its presets, or an accuracy; then the
cheapest setting that was found to reach it is taken.
"""

import json
from collections.abc import Callable
from typing import NamedTuple

import pandas as pd

from jointclosure.inputs import InputError

CHOSEN_BY = ("preset", "accuracy")
"""Keys of ``numerics`` that stand for others."""

SCENE = "regularised"
"""Scene whose limit an accuracy is held against: the model as stated has none."""


def numerics_in_full(keys: dict) -> dict:
    """Numerics without the preset or accuracy that chose them."""
    return {key: value for key, value in keys["numerics"].items() if key not in CHOSEN_BY}


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


def anything_breaks(configuration: dict) -> bool:
    """Whether breakage acts in a rock of the study, which may have its own effects."""
    rocks = (configuration["rocks"].get(name, {}) for name in configuration["study"]["rocks"])
    own = ((rock.get("effects") or {}).get("breakage") for rock in rocks)
    usual = configuration["effects"]["breakage"]
    return any(usual if breaks is None else breaks for breaks in own)


def _preset(table: pd.DataFrame, name: object, scene: str) -> pd.Series:
    known = table[(table.preset.fillna("") != "") & (table.scene == scene)].set_index(
        "preset", drop=False
    )
    if name not in known.index:
        raise InputError(f"numerics.preset = {name!r}: must be one of {', '.join(known.index)}")
    return known.loc[name]


def _accurate(configuration: dict, table: pd.DataFrame, accuracy: float) -> pd.Series | None:
    """The cheapest setting found to be within an accuracy; None where nothing breaks."""
    if not anything_breaks(configuration):
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

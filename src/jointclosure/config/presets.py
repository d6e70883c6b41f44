"""Numerics by one word, or by the accuracy that is wanted, from what was found of them.

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

SCENES = {None: "full", 20.0: "regularised"}
"""Variants of the accuracy study by the largest radius [mm] that they have, None for the model as
stated, which has no limit to be near."""


def radius_of(scene: str) -> float | None:
    """The largest radius [mm] of a variant of the accuracy study."""
    return next(radius for radius, name in SCENES.items() if name == scene)


def radii_words(scene: str) -> str:
    """What the radii of such a variant are, in words."""
    radius = radius_of(scene)
    return "as in the paper" if radius is None else f"bounded to {radius:g} mm"


def numerics_in_full(keys: dict) -> dict:
    """Numerics without the preset or accuracy that chose them."""
    return {key: value for key, value in keys["numerics"].items() if key not in CHOSEN_BY}


class Chosen(NamedTuple):
    """Numerics that stand for a preset or an accuracy, and a sentence on them."""

    numerics: dict
    said: str


def chosen_numerics(
    configuration: dict,
    default: dict,
    measured: Callable[[], pd.DataFrame],
    by: str | None = None,
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
    by : str, optional
        Key of ``numerics`` that the user set, where that is not the one it is chosen by here.

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
    if not anything_breaks(configuration) and accuracy is not None:
        return Chosen(numerics, "numerics.accuracy: nothing breaks, all is solved to 1e-10")
    scene = _scene(configuration)
    table = measured()
    known = table[table.scene == scene]
    row = _preset(known, preset) if accuracy is None else _accurate(known, accuracy, scene)
    changed = json.loads(row.numerics)
    touched = set().union(*(json.loads(each) for each in known.numerics))
    for key in touched:
        if numerics[key] != default[key]:
            name = by or ("preset" if accuracy is None else "accuracy")
            raise InputError(
                f"numerics.{key} = {numerics[key]!r}: leave it out, numerics.{name} chooses it"
            )
    return Chosen(numerics | changed, _said(row, preset, accuracy))


def _scene(configuration: dict) -> str:
    """Variant of the accuracy study that has a study's largest radius; others are not known."""
    radius = configuration["choices"]["largest_radius_mm"]
    if radius in SCENES:
        return SCENES[radius]
    key = next(key for key in CHOSEN_BY if configuration["numerics"].get(key) is not None)
    raise InputError(
        f"choices.largest_radius_mm = {radius!r}: numerics.{key} is known for "
        f"{_measured_radii()} only; "
        "give the keys of numerics themselves"
    )


def _measured_radii(bounded: bool = False) -> str:
    radii = [radius for radius in SCENES if radius is not None or not bounded]
    return ", ".join("null" if radius is None else f"{radius:g}" for radius in radii)


def anything_breaks(configuration: dict) -> bool:
    """Whether breakage acts in a rock of the study, which may have its own effects."""
    rocks = (configuration["rocks"].get(name, {}) for name in configuration["study"]["rocks"])
    own = ((rock.get("effects") or {}).get("breakage") for rock in rocks)
    usual = configuration["effects"]["breakage"]
    return any(usual if breaks is None else breaks for breaks in own)


def _preset(known: pd.DataFrame, name: object) -> pd.Series:
    presets = known[known.preset.fillna("") != ""].set_index("preset", drop=False)
    if name not in presets.index:
        raise InputError(f"numerics.preset = {name!r}: must be one of {', '.join(presets.index)}")
    return presets.loc[name]


def _accurate(known: pd.DataFrame, accuracy: float, scene: str) -> pd.Series:
    """The cheapest setting whose bound, of the worst rock and cycle, is within an accuracy."""
    if scene == SCENES[None]:
        raise InputError(
            f"numerics.accuracy = {accuracy!r}: the model without choices.largest_radius_mm has no "
            "limit on the first cycle to be near (docs/decisions/0010-resolved-breakage.md): "
            f"set it to one that is known ({_measured_radii(bounded=True)}), or give "
            "numerics.preset instead"
        )
    enough = known[known.bound_percent <= 100.0 * accuracy]
    if enough.empty:
        best = 0.01 * known.bound_percent.min()
        raise InputError(
            f"numerics.accuracy = {accuracy!r}: must be at least {best:.2g}, the best bound that "
            "is known (docs/accuracy.md)"
        )
    return enough.loc[enough.pairs.idxmin()]


def _said(row: pd.Series, preset: object, accuracy: object) -> str:
    what = f"preset {preset}" if accuracy is None else f"accuracy {accuracy:g}"
    return (
        f"numerics: {what} is {row.knob} {row['value']}: {row.numerics}; mean closures were "
        f"off by {row.error_percent:.2g} % (95 % confidence: up to "
        f"{row.bound_percent:.2g} %) where radii are {radii_words(row.scene)}, at "
        f"{row.relative_time:.2g} times the time of the paper's steps"
    ).replace(" nan", "")

"""Numerics selected by a preset or by a required accuracy, from measured errors.

The study of accuracy (accuracy.yaml) writes `setting_table`, with the errors and the cost of
each setting; the package has a copy of it (accuracy_settings.csv). A configuration names one of its
presets, or an accuracy; then the cheapest setting that reached it is used.
"""

import json
from collections.abc import Callable
from typing import NamedTuple

import pandas as pd

from jointclosure.inputs import InputError

CHOSEN_BY = ("preset", "accuracy")
"""Keys of ``numerics`` that select other keys."""

SCENES = {None: "full", 20.0: "regularised"}
"""Variants of the accuracy study by their largest radius [mm]. None is the model as stated in the
paper, whose closures do not converge to a limit."""


def radius_of(scene: str) -> float | None:
    """Return the largest radius [mm] of a variant of the accuracy study."""
    return next(radius for radius, name in SCENES.items() if name == scene)


def radii_words(scene: str) -> str:
    """Describe the radii of a variant of the accuracy study in words."""
    radius = radius_of(scene)
    return "as in the paper" if radius is None else f"bounded to {radius:g} mm"


def numerics_in_full(keys: dict) -> dict:
    """Return numerics without the preset or accuracy that selected them."""
    return {key: value for key, value in keys["numerics"].items() if key not in CHOSEN_BY}


class Chosen(NamedTuple):
    """Numerics selected by a preset or an accuracy, and a sentence on them."""

    numerics: dict
    remark: str


def chosen_numerics(
    configuration: dict,
    default: dict,
    measured: Callable[[], pd.DataFrame],
    by: str | None = None,
) -> Chosen:
    """Return the numerics selected by a configuration's preset or accuracy.

    ``default`` are the numerics of the default configuration: a key that is selected and differs
    from it was set besides, and is refused. ``measured`` returns the table of `setting_table`, if
    it is needed; ``by`` is the key that was set, if another one selects the numerics here.
    """
    numerics = configuration["numerics"]
    preset, accuracy = (numerics.get(key) for key in CHOSEN_BY)
    if preset is None and accuracy is None:
        return Chosen(numerics, "")
    if preset is not None and accuracy is not None:
        raise InputError(
            f"numerics.preset = {preset!r}, numerics.accuracy = {accuracy!r}: only one of them "
            "must be given"
        )
    if not anything_breaks(configuration) and accuracy is not None:
        return Chosen(numerics, "numerics.accuracy: without breakage everything is solved to 1e-10")
    scene = _scene(configuration)
    table = measured()
    known = table[table.scene == scene]
    row = _preset(known, preset) if accuracy is None else _accurate(known, accuracy, scene)
    changed = json.loads(row.numerics)
    touched = set().union(*(json.loads(text) for text in known.numerics))
    for key in touched:
        if numerics[key] != default[key]:
            name = by or ("preset" if accuracy is None else "accuracy")
            raise InputError(
                f"numerics.{key} = {numerics[key]!r}: must be left out, numerics.{name} selects it"
            )
    return Chosen(numerics | changed, _described(row, preset, accuracy))


def _scene(configuration: dict) -> str:
    """Return the variant of the accuracy study that has the largest radius of a study."""
    radius = configuration["choices"]["largest_radius_mm"]
    if radius in SCENES:
        return SCENES[radius]
    key = next(key for key in CHOSEN_BY if configuration["numerics"].get(key) is not None)
    raise InputError(
        f"choices.largest_radius_mm = {radius!r}: must be one of {_measured_radii()} for "
        f"numerics.{key}; otherwise give the keys of numerics themselves"
    )


def _measured_radii(bounded: bool = False) -> str:
    radii = [radius for radius in SCENES if radius is not None or not bounded]
    return ", ".join("null" if radius is None else f"{radius:g}" for radius in radii)


def anything_breaks(configuration: dict) -> bool:
    """Return whether breakage acts in a rock of the study, with its separate effects."""
    rocks = (configuration["rocks"].get(name, {}) for name in configuration["study"]["rocks"])
    by_rock = ((rock.get("effects") or {}).get("breakage") for rock in rocks)
    usual = configuration["effects"]["breakage"]
    return any(usual if breaks is None else breaks for breaks in by_rock)


def _preset(known: pd.DataFrame, name: object) -> pd.Series:
    presets = known[known.preset.fillna("") != ""].set_index("preset", drop=False)
    if name not in presets.index:
        raise InputError(f"numerics.preset = {name!r}: must be one of {', '.join(presets.index)}")
    return presets.loc[name]


def _accurate(known: pd.DataFrame, accuracy: float, scene: str) -> pd.Series:
    """Return the cheapest setting with a bound, for any rock and cycle, within an accuracy."""
    if scene == SCENES[None]:
        raise InputError(
            f"numerics.accuracy = {accuracy!r}: without choices.largest_radius_mm the first cycle "
            "does not converge to a limit (docs/decisions.md#0010-resolved-breakage); "
            f"choices.largest_radius_mm must be {_measured_radii(bounded=True)}, or give "
            "numerics.preset instead"
        )
    enough = known[known.bound_percent <= 100.0 * accuracy]
    if enough.empty:
        best = 0.01 * known.bound_percent.min()
        raise InputError(
            f"numerics.accuracy = {accuracy!r}: must be at least {best:.2g}, the smallest known "
            "bound (docs/accuracy.md)"
        )
    return enough.loc[enough.pairs.idxmin()]


def _described(row: pd.Series, preset: object, accuracy: object) -> str:
    what = f"preset {preset}" if accuracy is None else f"accuracy {accuracy:g}"
    return (
        f"numerics: {what} is {row.knob} {row['value']}: {row.numerics}; error of mean closures "
        f"{row.error_percent:.2g} % (95 % confidence: up to {row.bound_percent:.2g} %) if radii "
        f"are {radii_words(row.scene)}, at "
        f"{row.relative_time:.2g} times the time of the paper's steps"
    ).replace(" nan", "")

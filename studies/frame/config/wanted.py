"""Required accuracy of a result: selection of preset, surfaces and control variates.

Errors of presets, scatter of closures and the share explained by control variates were measured at
the paper's size and stress for each of its rocks; the package has a copy of the table
(accuracy_methods.csv, written by `snakemake total_error`). A rock of the table has its errors, any
other rock the worst of all. A study that requires an accuracy starts with the number of surfaces
that this table predicts. `make study` adds surfaces in blocks until the error estimated from the
study itself is within it.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.inputs import InputError
from jointclosure.parameters import PROPERTIES, key_of
from jointclosure.statistics.total_error import Bias, method_of

MOST = 200
"""Largest number of surfaces of a case, if the configuration does not state it."""
BLOCK = 10
"""Number of surfaces that are added at a time; totals are multiples of it."""
MEASURED_SURFACES = 4000
"""Number of surfaces for the means of control variates, if they are used."""
KNOWN_AT = "100 x 100 cells, 30 MPa"
"""Conditions at which errors of presets were measured (studies/accuracy/accuracy_biases.yaml)."""
_OF_ONE_MODEL = ("effects", "choices", "surface")
"""Sections that must have their default values, because errors were measured only with these."""
_CHOSEN = {
    "study": ("realizations", "realizations_per_job"),
    "statistics": ("control_variates",),
}
"""Keys that the choice sets, besides those of a preset."""


class Wanted(NamedTuple):
    """Required total error ``of`` a "mean" or "interval", ``within`` a relative bound.

    ``most`` is the largest number of surfaces of a case; ``surfaces`` is their number if it is
    already known, otherwise None.
    """

    of: str
    within: float
    most: int
    surfaces: int | None


class Granted(NamedTuple):
    """Selected method, its total error [1], and the core-seconds of a case.

    ``surfaces`` are infinite if no number of them is enough. ``rocks`` are those whose errors
    were used.
    """

    preset: str
    control_variates: bool
    surfaces: float
    total: float
    seconds: float
    rocks: tuple[str, ...]


class PresetErrors(NamedTuple):
    """Bias of a preset in each known cycle, and where it was measured, in words."""

    of_cycle: dict[int, Bias]
    measured_at: str


def wanted_of(keys: dict) -> Wanted | None:
    """Return the accuracy that a configuration requires, None if it requires none."""
    accuracy = keys["numerics"].get("accuracy")
    if not isinstance(accuracy, dict):
        return None
    return Wanted(
        accuracy["of"], accuracy["within"], accuracy.get("most", MOST), accuracy.get("surfaces")
    )


def measured_rocks(keys: dict, default: dict) -> dict[str, str | None]:
    """Return, for each rock of a study, the rock whose errors it has; None if not measured.

    Errors were measured with the default properties of the default rocks.
    """
    properties = [key_of(name) for name in PROPERTIES]

    def same(name: str) -> bool:
        given, known = keys["rocks"][name], default["rocks"].get(name, {})
        return all(given.get(key) == known.get(key) for key in properties)

    return {name: name if same(name) else None for name in keys["study"]["rocks"]}


def methods_of(methods: pd.DataFrame, rocks: Iterable[str | None]) -> pd.DataFrame:
    """Return rows of measured rocks; those of all rocks if one is None or was not measured."""
    return methods[methods.rock.isin(rocks)] if {*rocks} <= {*methods.rock} else methods


def preset_errors(methods: pd.DataFrame, preset: str, of: str, rock: str | None) -> PresetErrors:
    """Return the errors of a preset for a measured rock; the worst of all rocks for another."""
    rows = methods_of(methods, [rock])
    return PresetErrors(biases(rows, preset, of), _measured_at(tuple(dict.fromkeys(rows.rock))))


def _measured_at(rocks: tuple[str, ...]) -> str:
    worst = "the worst of " if len(rocks) > 1 else ""
    return f"{worst}{', '.join(rocks)}, {KNOWN_AT}"


def biases(methods: pd.DataFrame, preset: str, of: str) -> dict[int, Bias]:
    """Return the largest error of a preset over the rocks of a table, for each known cycle."""
    rows = methods[(methods.response == of) & (methods.method == preset)]
    return {
        int(cycle): max((method_of(row).bias for row in part.itertuples()), key=_floor)
        for cycle, part in rows.groupby("cycle")
    }


def _floor(bias: Bias) -> float:
    """Return the total error [1] that no number of surfaces removes."""
    return bias.total(0.0)


def grant(wanted: Wanted, methods: pd.DataFrame, presets: Iterable[str], cycles: int) -> Granted:
    """Return the cheapest preset and number of surfaces with the required expected error.

    ``methods`` are as from `methods_of`; of the ``cycles`` those with known errors count.
    """
    known = methods[(methods.response == wanted.of) & (methods.cycle <= cycles)]
    ways = [
        _way(wanted, known[known.method == preset], preset, adjusted)
        for preset in presets
        for adjusted in (False, True)
        if (known.method == preset).any()
    ]
    if not ways:
        raise InputError(
            f"numerics.accuracy.of = {wanted.of!r}: its error is not known for the {cycles} cycles "
            "of this study (docs/accuracy.md)"
        )
    fewest = min(way.surfaces for way in ways)
    if np.isinf(fewest):
        least = min(max(map(_floor, biases(known, way.preset, wanted.of).values())) for way in ways)
        raise InputError(
            f"numerics.accuracy.within = {wanted.within:g}: must be more than "
            f"{np.ceil(1e3 * least) / 1e3:g}; no known preset reaches less with any number of "
            "surfaces"
        )
    if fewest > wanted.most:
        raise InputError(
            f"numerics.accuracy.within = {wanted.within:g}: takes about {fewest:.0f} surfaces a "
            f"case, more than numerics.accuracy.most = {wanted.most}"
        )
    return min((way for way in ways if way.surfaces <= wanted.most), key=lambda way: way.seconds)


def _way(wanted: Wanted, rows: pd.DataFrame, preset: str, adjusted: bool) -> Granted:
    """Return a preset with the number of surfaces of the rock and cycle that need most."""
    # use control variates if they explain any variance
    used = rows.control_variates & (rows.explained > 0.0) if adjusted else ~rows.control_variates
    rest = ~rows.control_variates & ~rows.cycle.isin(rows.cycle[used])
    ways = [method_of(row) for row in rows[used | rest].itertuples()]
    measured = MEASURED_SURFACES if adjusted else 0
    surfaces = max(way.surfaces_for(wanted.within, measured or np.inf) for way in ways)
    if np.isfinite(surfaces):
        surfaces = BLOCK * int(np.ceil(surfaces / BLOCK))
    total = max(way.total(surfaces, measured or np.inf) for way in ways)
    seconds = max(way.seconds(surfaces, measured) for way in ways)
    return Granted(preset, adjusted, surfaces, total, seconds, tuple(dict.fromkeys(rows.rock)))


def check_left_out(keys: dict, default: dict) -> None:
    """Refuse keys that the required accuracy selects; the ``default`` values count as not set."""
    accuracy = keys["numerics"]["accuracy"]
    if accuracy.get("surfaces") and accuracy["surfaces"] > accuracy.get("most", MOST):
        raise InputError(
            f"numerics.accuracy.surfaces = {accuracy['surfaces']}: must be at most "
            f"numerics.accuracy.most = {accuracy.get('most', MOST)}"
        )
    for section in _OF_ONE_MODEL:
        for name, value in keys[section].items():
            known = default[section].get(name)
            if value != known:
                raise InputError(
                    f"{section}.{name} = {value!r}: must be "
                    f"{'null' if known is None else repr(known)} with numerics.accuracy.of"
                )
    for rock, rock_keys in keys["rocks"].items():
        for section in rock_keys.keys() & set(_OF_ONE_MODEL):
            raise InputError(
                f"rocks.{rock}.{section} = {rock_keys[section]!r}: must be left out, "
                "numerics.accuracy.of is known only for the default values"
            )
    if keys["numerics"].get("idle_interaction"):
        raise InputError(
            f"numerics.idle_interaction = {keys['numerics']['idle_interaction']!r}: must be null "
            "or 0, its error is not known for numerics.accuracy.of"
        )
    for section, names in _CHOSEN.items():
        for name in names:
            value = keys[section].get(name)
            if value != default[section].get(name):
                raise InputError(
                    f"{section}.{name} = {value!r}: must be left out, numerics.accuracy.of "
                    "selects it"
                )


def with_granted(keys: dict, wanted: Wanted, granted: Granted) -> dict:
    """Return keys with the selected surfaces and control variates; numerics are not changed."""
    surfaces = int(granted.surfaces) if wanted.surfaces is None else wanted.surfaces
    study = {"realizations": surfaces, "realizations_per_job": BLOCK}
    variates = {"control_variates": MEASURED_SURFACES if granted.control_variates else None}
    return keys | {
        "study": keys["study"] | study,
        "statistics": keys["statistics"] | variates,
    }


def describe_grant(wanted: Wanted, granted: Granted) -> str:
    """Describe the selection and the predicted cost in words."""
    by = " and control variates" if granted.control_variates else ""
    start = int(granted.surfaces) if wanted.surfaces is None else wanted.surfaces
    return (
        f"accuracy: {wanted.of} within {100.0 * wanted.within:g} %: preset {granted.preset}, "
        f"{start} surfaces a case{by}; predicted from {granted.surfaces:.0f} surfaces: "
        f"{100.0 * granted.total:.2g} % in {granted.seconds / 60.0:.2g} core-minutes a case. The "
        f"error of the preset is that of {_measured_at(granted.rocks)}; elsewhere it differs "
        "(docs/accuracy.md)"
    )

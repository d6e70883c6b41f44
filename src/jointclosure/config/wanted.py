"""The accuracy of a result that is wanted: preset, surfaces and control variates that reach it.

What presets are off by, how closures scatter and what control variates explain was measured at the
paper's size and stress; the package has a copy of the table (accuracy_methods.csv, written by
`snakemake total_error`). A study that asks for an accuracy starts with the number of surfaces that
this predicts; `make study` adds more, in blocks, until what the study itself finds is within it.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.inputs import InputError
from jointclosure.statistics.total_error import Bias, method_of

MOST = 200
"""Surfaces a case, where the configuration does not say."""
BLOCK = 10
"""Surfaces that are added at a time; a multiple of them is closed."""
MEASURED_SURFACES = 4000
"""Surfaces that tell the means of control variates, where they are used."""
KNOWN_AT = {
    "mean": "dolerite and siltstone, 100 x 100 cells at 30 MPa",
    "interval": "dolerite and siltstone, 48 x 48 cells at 10 MPa",
}
"""Where the biases of presets were measured, by the kind of result (config/accuracy.yaml)."""
_OF_ONE_MODEL = ("effects", "choices", "surface")
"""Sections that must be as the default has them: biases were measured with these alone."""
_CHOSEN = {
    "study": ("realizations", "realizations_per_job"),
    "statistics": ("control_variates",),
}
"""Keys that the choice sets, besides those of a preset."""


class Wanted(NamedTuple):
    """What is wanted: total error ``of`` "mean" or "interval" ``within`` a share, from at ``most``
    so many surfaces a case; ``surfaces`` where their number is known already, else None."""

    of: str
    within: float
    most: int
    surfaces: int | None


class Granted(NamedTuple):
    """The way that was chosen, its total error [1], and the core-seconds that a case takes.

    ``surfaces`` are infinite where no number of them is enough.
    """

    preset: str
    control_variates: bool
    surfaces: float
    total: float
    seconds: float


def wanted_of(keys: dict) -> Wanted | None:
    """What a configuration wants of its results, None where it wants nothing."""
    wish = keys["numerics"].get("accuracy")
    if not isinstance(wish, dict):
        return None
    return Wanted(wish["of"], wish["within"], wish.get("most", MOST), wish.get("surfaces"))


def biases(methods: pd.DataFrame, preset: str, of: str) -> dict[int, Bias]:
    """What a preset is off by, of the rock where that is most, for each cycle that is known."""
    own = methods[(methods.response == of) & (methods.method == preset)]
    return {
        int(cycle): max((method_of(row).bias for row in part.itertuples()), key=_floor)
        for cycle, part in own.groupby("cycle")
    }


def _floor(bias: Bias) -> float:
    """Total error that no number of surfaces takes away [1]."""
    return bias.total(0.0)


def grant(wanted: Wanted, methods: pd.DataFrame, presets: Iterable[str], cycles: int) -> Granted:
    """The cheapest preset and number of surfaces whose total error is expected to be as wanted.

    Parameters
    ----------
    wanted : Wanted
    methods : DataFrame
        As from `jointclosure.experiments.accuracy.total.method_table`.
    presets : iterable of str
    cycles : int
        Of the study; each counts of which the error is known.

    Raises
    ------
    InputError
        An accuracy that no preset has at any number of surfaces, or at no more than the most.
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
            f"numerics.accuracy.of = {wanted.of!r}: of the {cycles} cycles of this study its "
            "error is not known (docs/accuracy.md)"
        )
    fewest = min(way.surfaces for way in ways)
    if np.isinf(fewest):
        least = min(max(map(_floor, biases(known, way.preset, wanted.of).values())) for way in ways)
        raise InputError(
            f"numerics.accuracy.within = {wanted.within:g}: no preset is known to have it, however "
            f"many the surfaces; must be more than {np.ceil(1e3 * least) / 1e3:g}"
        )
    if fewest > wanted.most:
        raise InputError(
            f"numerics.accuracy.within = {wanted.within:g}: takes about {fewest:.0f} surfaces a "
            f"case, more than numerics.accuracy.most = {wanted.most}"
        )
    return min((way for way in ways if way.surfaces <= wanted.most), key=lambda way: way.seconds)


def _way(wanted: Wanted, own: pd.DataFrame, preset: str, adjusted: bool) -> Granted:
    """A preset with the surfaces that the rock and cycle where they are most needs."""
    # control variates are used where they explain anything
    used = own.control_variates & (own.explained > 0.0) if adjusted else ~own.control_variates
    rest = ~own.control_variates & ~own.cycle.isin(own.cycle[used])
    ways = [method_of(row) for row in own[used | rest].itertuples()]
    measured = MEASURED_SURFACES if adjusted else 0
    surfaces = max(way.surfaces_for(wanted.within, measured or np.inf) for way in ways)
    if np.isfinite(surfaces):
        surfaces = BLOCK * int(np.ceil(surfaces / BLOCK))
    total = max(way.total(surfaces, measured or np.inf) for way in ways)
    seconds = max(way.seconds(surfaces, measured) for way in ways)
    return Granted(preset, adjusted, surfaces, total, seconds)


def check_left_out(keys: dict, default: dict) -> None:
    """Refuse a configuration that sets what its wanted accuracy is to choose.

    Parameters
    ----------
    keys, default : dict
        The configuration, and the default one, whose values count as not set.

    Raises
    ------
    InputError
        Naming the key.
    """
    wish = keys["numerics"]["accuracy"]
    if wish.get("surfaces") and wish["surfaces"] > wish.get("most", MOST):
        raise InputError(
            f"numerics.accuracy.surfaces = {wish['surfaces']}: must be at most "
            f"numerics.accuracy.most = {wish.get('most', MOST)}"
        )
    for section in _OF_ONE_MODEL:
        for name, value in keys[section].items():
            known = default[section].get(name)
            if value != known:
                raise InputError(
                    f"{section}.{name} = {value!r}: numerics.accuracy.of is known for "
                    f"{'null' if known is None else repr(known)} only"
                )
    for rock, own in keys["rocks"].items():
        for section in own.keys() & set(_OF_ONE_MODEL):
            raise InputError(
                f"rocks.{rock}.{section} = {own[section]!r}: leave it out, numerics.accuracy.of is "
                "known for the default ones only"
            )
    if keys["numerics"].get("idle_interaction"):
        raise InputError(
            f"numerics.idle_interaction = {keys['numerics']['idle_interaction']!r}: must be null "
            "or 0, what it is off by is in no bias of numerics.accuracy.of"
        )
    for section, names in _CHOSEN.items():
        for name in names:
            value = keys[section].get(name)
            if value != default[section].get(name):
                raise InputError(
                    f"{section}.{name} = {value!r}: leave it out, numerics.accuracy.of chooses it"
                )


def with_granted(keys: dict, wanted: Wanted, granted: Granted) -> dict:
    """Keys with the surfaces and control variates that were chosen; numerics are as they were."""
    surfaces = int(granted.surfaces) if wanted.surfaces is None else wanted.surfaces
    study = {"realizations": surfaces, "realizations_per_job": BLOCK}
    variates = {"control_variates": MEASURED_SURFACES if granted.control_variates else None}
    return keys | {
        "study": keys["study"] | study,
        "statistics": keys["statistics"] | variates,
    }


def said(wanted: Wanted, granted: Granted) -> str:
    """What was chosen, and the predicted cost, in words."""
    by = " and control variates" if granted.control_variates else ""
    start = int(granted.surfaces) if wanted.surfaces is None else wanted.surfaces
    return (
        f"accuracy: {wanted.of} within {100.0 * wanted.within:g} %: preset {granted.preset}, "
        f"{start} surfaces a case{by}; predicted from {granted.surfaces:.0f} surfaces: "
        f"{100.0 * granted.total:.2g} % in {granted.seconds / 60.0:.2g} core-minutes a case. What "
        f"the preset is off by was measured at {KNOWN_AT[wanted.of]}; elsewhere it is another "
        "number (docs/accuracy.md)"
    )

"""Names of sets of effects, as tables, figures and pages show them."""

from collections.abc import Sequence

import pandas as pd

from jointclosure.parameters import Effects


def joined(effects: Sequence[str]) -> str:
    """Return names of effects (fields of `Effects`) as words: "breakage and gouge"."""
    words = [name.replace("_", " ") for name in effects]
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)


def effects_title(effects: Effects) -> str:
    """Return the name of a set of effects: "all effects", "all but gouge", "only substrate".

    What is named are the effects that do not act, or those that act if these are fewer.
    """
    by_acting = {True: list[str](), False: list[str]()}
    for name, acts in effects._asdict().items():
        by_acting[bool(acts)].append(name)
    if not by_acting[False]:
        return "all effects"
    if not by_acting[True]:
        return "no effects"
    if len(by_acting[True]) < len(by_acting[False]):
        return f"only {joined(by_acting[True])}"
    return f"all but {joined(by_acting[False])}"


_WITHOUT = "without "


def without(effects: Sequence[str]) -> str:
    """Return the name of a scene from which effects are left out: "without breakage and gouge"."""
    return f"{_WITHOUT}{joined(effects)}"


def effects_of(variant: str) -> str:
    """Return the words on the effects that a scene named by `without` leaves out."""
    return variant.removeprefix(_WITHOUT)


def lacks_effects(variants: pd.Series) -> pd.Series:
    """Return which variants of a scene are ones without effects, by their names (`without`)."""
    return variants.str.startswith(_WITHOUT)

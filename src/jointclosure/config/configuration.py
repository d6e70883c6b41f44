"""The configuration of a study: merged, checked and turned into SI, once and in one place."""

import copy
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from jointclosure.config.contradictions import contradictions
from jointclosure.config.files import DEFAULT, MEASURED, METHODS, ConfigurationError, read_plain
from jointclosure.config.keys import ConfigurationKeys
from jointclosure.config.presets import anything_breaks, chosen_numerics, numerics_in_full
from jointclosure.config.schema import problems
from jointclosure.config.typed import (
    Ablation,
    Configuration,
    Grid,
    MeasuredFile,
    MismatchDesign,
    Output,
    SizeDesign,
    SizeSpectrum,
    Statistics,
    Study,
    StudyRock,
    Surface,
    Validation,
    Walls,
)
from jointclosure.config.units import to_si
from jointclosure.config.wanted import (
    check_left_out,
    describe_grant,
    grant,
    wanted_of,
    with_granted,
)
from jointclosure.inputs import InputError
from jointclosure.parameters import (
    AUTO_TOLERANCE,
    PROPERTIES,
    Choices,
    Effects,
    Numerics,
    key_of,
    rock_of,
)


class Configured(NamedTuple):
    """A configuration as keys of a file, complete; as the library has it; and what was chosen.

    ``said`` is a sentence on numerics that a preset or accuracy stands for, or empty; ``granted``
    the preset that a result's accuracy chose, or None.
    """

    keys: dict
    typed: Configuration
    said: str
    granted: str | None = None


def merged(*settings: dict) -> dict:
    """Nested settings, later ones over earlier ones."""
    answer: dict = {}
    for each in settings:
        for key, value in each.items():
            nested = isinstance(value, dict) and isinstance(answer.get(key), dict)
            answer[key] = merged(answer[key], value) if nested else copy.deepcopy(value)
    return answer


def merged_study(*paths: Path) -> dict:
    """The default configuration and files over it, not yet checked.

    Raises
    ------
    ConfigurationError
        As `jointclosure.config.files.read_plain`.
    """
    return merged(*(written_out(read_plain(path)) for path in (DEFAULT, *paths)))


def written_out(keys: dict) -> dict:
    """Keys whose ``effects: auto`` is written out: those of the full model, chosen to 2 %."""
    if keys.get("effects") != "auto":
        return keys
    return keys | {"effects": Effects()._asdict() | {"auto": AUTO_TOLERANCE}}


def configured(keys: dict, read: Callable[[Path], pd.DataFrame]) -> Configured:
    """A configuration from merged keys: words turned into numbers, checked, and in SI.

    Parameters
    ----------
    keys : dict
        As from `merged_study`; complete, and not yet checked.
    read : callable
        Reads the table that ``numerics.preset`` and ``accuracy`` choose from, where one
        of them is given.

    Raises
    ------
    ConfigurationError
        Naming every key that is wrong, its value, what is allowed, and for
        an unknown key the one that was probably meant.
    """
    keys = written_out(keys)
    _refuse(problems(ConfigurationKeys, keys))
    try:
        keys, sentence, granted = _chosen(keys, read_plain(DEFAULT), read)
    except InputError as error:
        raise ConfigurationError(str(error)) from None
    _refuse(problems(ConfigurationKeys, keys))
    complete = _complete(keys)
    _refuse(contradictions(complete, _typed))
    return Configured(keys, _typed(complete), sentence, granted)


def _chosen(keys: dict, default: dict, read) -> tuple[dict, str, str | None]:
    """Keys with what a preset or an accuracy stands for, a sentence on it, and a granted preset."""
    wanted = wanted_of(keys)
    if wanted is None:
        chosen = chosen_numerics(keys, default["numerics"], lambda: read(MEASURED))
        return keys | {"numerics": chosen.numerics}, chosen.said, None
    if not anything_breaks(keys):
        raise InputError("numerics.accuracy.of: known where contacts break, and nothing does here")
    if keys["numerics"].get("preset") is not None:
        raise InputError(
            f"numerics.preset = {keys['numerics']['preset']!r}: leave it out, "
            "numerics.accuracy.of chooses it"
        )
    check_left_out(keys, default)
    settings, cycles = read(MEASURED), keys["study"]["cycles"]
    granted = grant(wanted, read(METHODS), settings.preset.dropna().unique(), cycles)
    named = {"preset": granted.preset, "accuracy": None}
    numerics = chosen_numerics(
        keys | {"numerics": keys["numerics"] | named},
        default["numerics"],
        lambda: settings,
        by="accuracy.of",
    ).numerics
    kept = {"preset": None, "accuracy": keys["numerics"]["accuracy"]}
    whole = with_granted(keys, wanted, granted) | {"numerics": numerics | kept}
    return whole, describe_grant(wanted, granted), granted.preset


def resolved(keys: dict) -> Configuration:
    """The configuration of keys that were checked before, as those in the file of a study."""
    return _typed(_complete(keys))


def _refuse(lines: Iterable[str]) -> None:
    found = list(dict.fromkeys(lines))
    if found:
        raise ConfigurationError("configuration:\n" + "\n".join(f"  {line}" for line in found))


def _complete(keys: dict) -> dict:
    """Keys with those that were left out."""
    return ConfigurationKeys.model_validate(keys).model_dump(warnings=False)


def _typed(keys: dict) -> Configuration:
    """Complete keys, in SI."""
    si = to_si(keys)
    study = keys["study"]
    rocks = {name: _rock(keys["rocks"][name], si["effects"]) for name in study["rocks"]}
    auto = si["effects"]["auto"]
    if si["numerics"]["idle_interaction"] is None:
        si["numerics"]["idle_interaction"] = auto or 0.0
    if si["output"]["largest_stress"] is None:
        si["output"]["largest_stress"] = max(rock.max_normal_stress for rock in rocks.values())
    return Configuration(
        study=Study(**study | {"rocks": tuple(study["rocks"])}),
        rocks=rocks,
        grid=Grid(**si["grid"]),
        surface=Surface(**si["surface"]),
        seating_stress=si["seating_stress"],
        effects_chosen_to=auto,
        choices=Choices(**si["choices"]),
        numerics=Numerics(**numerics_in_full(si)),
        statistics=Statistics(**si["statistics"]),
        output=Output(**si["output"]),
        ablation=_ablation(si["ablation"]),
        flow=si["flow"],
        mismatch=_mismatch(si["mismatch"]),
        size=_size(si["size"]),
    )


def _rock(keys: dict, effects: dict) -> StudyRock:
    si, levels = to_si(keys), keys["levels"]
    own = {name: on for name, on in keys["effects"].items() if on is not None}
    given = effects | own
    si["jrc"] = float("nan") if keys["jrc"] is None else keys["jrc"]
    varied = {
        name: tuple(sorted([*to_si(levels)[name], si[name]]))
        for name in PROPERTIES
        if levels[key_of(name)] is not None
    }
    walls, measured = si["walls"], si["measured"]
    return StudyRock(
        title=keys["title"],
        intact=rock_of(si),
        jrc=si["jrc"],
        max_normal_stress=si["max_normal_stress"],
        max_normal_stress_is_assumed=keys["max_normal_stress_is_assumed"],
        effects=Effects(**{name: given[name] for name in Effects._fields}),
        levels=varied,
        walls=Walls(**walls | {"inverted": tuple(walls["inverted"])}) if walls else None,
        measured=MeasuredFile(**measured) if measured else None,
    )


def _ablation(si: dict | None) -> Ablation | None:
    if si is None:
        return None
    validation = si["validation"]
    if validation:
        validation = Validation(**{name: _tuple(part) for name, part in validation.items()})
    return Ablation(tuple(si["jrc"]), tuple(si["stress"]), validation)


def _mismatch(si: dict | None) -> MismatchDesign | None:
    if si is None:
        return None
    return MismatchDesign(
        tuple(sorted(si["wavelength"])), tuple(sorted(si["shift_in_cells"])), si["tolerance"]
    )


def _size(si: dict | None) -> SizeDesign | None:
    if si is None:
        return None
    spectra = {name: SizeSpectrum(**each) for name, each in si["spectra"].items()}
    patches, spacings = (tuple(sorted(si[name])) for name in ("patch", "spacing"))
    return SizeDesign(patches, spacings, si["most_cells"], spectra)


def _tuple(value):
    return tuple(value) if isinstance(value, list) else value

"""The configuration of a study: merged, checked and turned into SI, once and in one place."""

import copy
import functools
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from jointclosure.engine.settings import Grid, Surface, Walls
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
from jointclosure.parameters.units import to_si
from studies.frame.config.contradictions import contradictions
from studies.frame.config.files import DEFAULT, MEASURED, METHODS, ConfigurationError, read_plain
from studies.frame.config.keys.configuration import ConfigurationKeys
from studies.frame.config.presets import anything_breaks, chosen_numerics, numerics_in_full
from studies.frame.config.schema import problems
from studies.frame.config.typed import (
    Ablation,
    Configuration,
    MeasuredFile,
    MismatchDesign,
    Output,
    SizeDesign,
    SizeSpectrum,
    Statistics,
    Study,
    StudyRock,
    Validation,
)
from studies.frame.config.wanted import (
    check_left_out,
    describe_grant,
    grant,
    measured_rocks,
    methods_of,
    wanted_of,
    with_granted,
)


class Configured(NamedTuple):
    """A configuration as keys of a file, complete; as the library has it; and what was chosen.

    ``remark`` is a sentence on numerics that a preset or accuracy stands for, or empty; ``granted``
    the preset that a result's accuracy chose, or None.
    """

    keys: dict
    typed: Configuration
    remark: str
    granted: str | None = None


def overlaid(keys: dict, changes: dict) -> dict:
    """Nested keys with others over them; what does not change is not copied."""
    return keys | {
        key: overlaid(keys[key], value)
        if isinstance(value, dict) and isinstance(keys.get(key), dict)
        else value
        for key, value in changes.items()
    }


def merged(*settings: dict) -> dict:
    """Nested settings, later ones over earlier ones, as a copy."""
    return copy.deepcopy(functools.reduce(overlaid, settings, {}))


def merged_study(*paths: Path) -> dict:
    """The default configuration and files over it, not yet checked.

    Raises
    ------
    ConfigurationError
        As `studies.frame.config.files.read_plain`.
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
    refuse(problems(ConfigurationKeys, keys))
    try:
        keys, sentence, granted = _chosen(keys, read_plain(DEFAULT), read)
    except InputError as error:
        raise ConfigurationError(str(error)) from None
    refuse(problems(ConfigurationKeys, keys))
    whole = complete(keys)
    refuse(contradictions(whole, _typed))
    return Configured(keys, _typed(whole), sentence, granted)


def checked_with(keys: dict, *changes: dict) -> Configuration:
    """Check a configuration with other keys; a preset or accuracy is written out before.

    Parameters
    ----------
    keys : dict
        Of `Configured`.
    *changes : dict
        Nested keys.

    Raises
    ------
    ConfigurationError
        As `configured`, and for a preset or an accuracy among the changes.
    """
    plain = keys | {"numerics": numerics_in_full(keys)}
    return configured(merged(plain, *changes), _no_table).typed


def _no_table(path: Path) -> pd.DataFrame:
    raise InputError("numerics.preset, numerics.accuracy: only for a study as a whole")


def _chosen(keys: dict, default: dict, read) -> tuple[dict, str, str | None]:
    """Keys with what a preset or an accuracy stands for, a sentence on it, and a granted preset."""
    wanted = wanted_of(keys)
    if wanted is None:
        chosen = chosen_numerics(keys, default["numerics"], lambda: read(MEASURED))
        return keys | {"numerics": chosen.numerics}, chosen.remark, None
    if not anything_breaks(keys):
        raise InputError("numerics.accuracy.of: known where contacts break, and nothing does here")
    if keys["numerics"].get("preset") is not None:
        raise InputError(
            f"numerics.preset = {keys['numerics']['preset']!r}: leave it out, "
            "numerics.accuracy.of chooses it"
        )
    check_left_out(keys, default)
    settings, cycles = read(MEASURED), keys["study"]["cycles"]
    methods = methods_of(read(METHODS), measured_rocks(keys, default).values())
    granted = grant(wanted, methods, settings.preset.dropna().unique(), cycles)
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
    return _typed(complete(keys))


def with_keys(configuration: Configuration, keys: dict, changes: dict) -> Configuration:
    """Replace some keys of a configuration that was checked; the new values are not checked.

    Parameters
    ----------
    configuration : Configuration
    keys : dict
        Its `complete` keys.
    changes : dict
        Nested keys. Only the fields that depend on their sections are made anew.
    """
    whole = written_out(overlaid(keys, changes))
    fields = {field for section in changes for field in _FIELDS_OF.get(section, (section,))}
    return configuration._replace(**{field: _FIELDS[field](whole) for field in fields})


def refuse(problems: Iterable[str]) -> None:
    """Raise `ConfigurationError` where there are problems, one line each."""
    if lines := list(dict.fromkeys(problems)):
        raise ConfigurationError("configuration:\n" + "\n".join(f"  {line}" for line in lines))


def problem_lines(error: InputError) -> list[str]:
    """The lines of an error of `refuse`, or of another one."""
    lines = str(error).removeprefix("configuration:").split("\n")
    return [line.strip() for line in lines if line.strip()]


def complete(keys: dict) -> dict:
    """Checked keys with those that were left out."""
    return ConfigurationKeys.model_validate(keys).model_dump(warnings=False)


def _typed(keys: dict) -> Configuration:
    """Complete keys, in SI."""
    return Configuration(**{field: of_keys(keys) for field, of_keys in _FIELDS.items()})


def _study(keys: dict) -> Study:
    return Study(**keys["study"] | {"rocks": tuple(keys["study"]["rocks"])})


def _rocks(keys: dict) -> dict[str, StudyRock]:
    return {name: _rock(keys["rocks"][name], keys["effects"]) for name in keys["study"]["rocks"]}


def _numerics(keys: dict) -> Numerics:
    numerics = numerics_in_full({"numerics": to_si(keys["numerics"])})
    if numerics["idle_interaction"] is None:
        numerics["idle_interaction"] = keys["effects"]["auto"] or 0.0
    return Numerics._make(numerics[name] for name in Numerics._fields)  # checked by its user


def _output(keys: dict) -> Output:
    output = to_si(keys["output"])
    if output["largest_stress"] is None:
        rocks = (to_si(keys["rocks"][name]) for name in keys["study"]["rocks"])
        output["largest_stress"] = max(rock["max_normal_stress"] for rock in rocks)
    return Output(**output)


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


def _ablation(keys: dict) -> Ablation | None:
    if keys["ablation"] is None:
        return None
    si = to_si(keys["ablation"])
    validation = si["validation"]
    if validation:
        validation = Validation(**{name: _tuple(part) for name, part in validation.items()})
    return Ablation(tuple(si["jrc"]), tuple(si["stress"]), validation)


def _mismatch(keys: dict) -> MismatchDesign | None:
    if keys["mismatch"] is None:
        return None
    si = to_si(keys["mismatch"])
    return MismatchDesign(
        tuple(sorted(si["wavelength"])), tuple(sorted(si["shift_in_cells"])), si["tolerance"]
    )


def _size(keys: dict) -> SizeDesign | None:
    if keys["size"] is None:
        return None
    si = to_si(keys["size"])
    spectra = {name: SizeSpectrum(**each) for name, each in si["spectra"].items()}
    patches, spacings = (tuple(sorted(si[name])) for name in ("patch", "spacing"))
    return SizeDesign(patches, spacings, si["most_cells"], spectra)


def _tuple(value):
    return tuple(value) if isinstance(value, list) else value


_FIELDS: dict[str, Callable[[dict], Any]] = {
    "study": _study,
    "rocks": _rocks,
    "grid": lambda keys: Grid(**to_si(keys["grid"])),
    "surface": lambda keys: Surface(**to_si(keys["surface"])),
    "seating_stress": lambda keys: to_si({"seating_stress_MPa": keys["seating_stress_MPa"]})[
        "seating_stress"
    ],
    "effects_chosen_to": lambda keys: keys["effects"]["auto"],
    "choices": lambda keys: Choices(**to_si(keys["choices"])),
    "numerics": _numerics,
    "statistics": lambda keys: Statistics(**to_si(keys["statistics"])),
    "output": _output,
    "ablation": _ablation,
    "flow": lambda keys: keys["flow"],
    "mismatch": _mismatch,
    "size": _size,
}
"""Each field of a configuration, from complete keys."""
_FIELDS_OF = {
    "study": ("study", "rocks", "output"),
    "rocks": ("rocks", "output"),
    "effects": ("rocks", "effects_chosen_to", "numerics"),
    "seating_stress_MPa": ("seating_stress",),
}
"""Fields that depend on a section of the keys; of any other section the one of its name."""

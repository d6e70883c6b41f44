"""Check a merged configuration, before anything is computed from it."""

import copy
import difflib
import itertools
from collections.abc import Iterable, Iterator
from pathlib import Path

import jsonschema
import yaml

from jointclosure.config.units import to_si
from jointclosure.config.walls import wall_problems
from jointclosure.inputs import InputError
from jointclosure.parameters import (
    Choices,
    Effects,
    Numerics,
    check_choices,
    check_numerics,
    check_scene,
    scene_name,
)
from jointclosure.solvers.registry import SOLVERS
from jointclosure.surface.roughness import relation_of

CHOSEN_BY = ("preset", "accuracy")
"""Keys of ``numerics`` that stand for others."""
_AUTO_TOLERANCE = 0.02
"""Of `effects: auto`, which names none."""


class ConfigurationError(InputError):
    """A configuration that cannot be run; the message lists all that is wrong."""


def merged(*settings: dict) -> dict:
    """Nested settings, later ones over earlier ones."""
    answer: dict = {}
    for each in settings:
        for key, value in each.items():
            nested = isinstance(value, dict) and isinstance(answer.get(key), dict)
            answer[key] = merged(answer[key], value) if nested else copy.deepcopy(value)
    return answer


def read_schema(path: str | Path) -> dict:
    """The JSON schema of a configuration, from its YAML file."""
    # every job of a workflow reads it again: by libyaml, where it is there, which is faster
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    return yaml.load(Path(path).read_text(encoding="utf-8"), Loader=loader)


def read_plain(path: str | Path) -> dict:
    """A configuration's own file, as the plain data that it must be.

    Snakemake runs Python expressions in a file that has ``__use_yte__``: the file of
    a stranger is to be read by this function first, as `make` does.

    Raises
    ------
    ConfigurationError
        The file is no mapping, has a tag of YAML, or asks to be run as a template.
    """
    try:
        settings = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise ConfigurationError(f"{path}: not plain YAML: {error}") from error
    if not isinstance(settings, dict | None):
        raise ConfigurationError(f"{path}: must hold keys and values, not {settings!r}")
    if "__use_yte__" in (settings or {}):
        raise ConfigurationError(
            f"{path}: __use_yte__ = {settings['__use_yte__']!r}: templates are not allowed, "
            "as Snakemake would run the Python in them"
        )
    return settings or {}


def checked(configuration: dict, schema: dict) -> dict:
    """The configuration itself, if it can be run.

    Raises
    ------
    ConfigurationError
        Naming every key that is wrong, its value, what is allowed, and for
        an unknown key the one that was probably meant.
    """
    problems = schema_problems(configuration, schema)
    if not problems:
        problems = list(_contradictions(configuration))
    if problems:
        raise ConfigurationError("configuration:\n" + "\n".join(f"  {line}" for line in problems))
    return configuration


def schema_problems(configuration: dict, schema: dict) -> list[str]:
    """What a configuration has against its schema, one line each."""
    validator = jsonschema.Draft202012Validator(schema)
    errors = sorted(validator.iter_errors(configuration), key=lambda e: list(e.path))
    # a line lists all that a section lacks, of which each is an error
    return list(dict.fromkeys(line for error in errors for line in _explained(error)))


def effects_of(configuration: dict, rock: str | None = None) -> Effects:
    """Effects of a study's scenes, or of a rock's, which may have its own.

    With ``effects.auto`` these are the ones that may be chosen.
    """
    own = configuration["rocks"][rock].get("effects", {}) if rock else {}
    given = configuration["effects"] | own
    return Effects(**{name: given[name] for name in Effects._fields})


def choice_tolerance(configuration: dict) -> float | None:
    """The tolerance by which effects are chosen; None where they are as configured."""
    return configuration["effects"].get("auto")


def end_of_stress_axis(configuration: dict) -> float:
    """End of the closure curves' stress axis [MPa]: as set, or the largest of the rocks' maxima."""
    end = configuration["output"]["largest_stress_MPa"]
    if end is not None:
        return end
    rocks = configuration["rocks"]
    return max(rocks[name]["max_normal_stress_MPa"] for name in configuration["study"]["rocks"])


def kernels_of(settings: Iterable[dict]) -> list[list[str]]:
    """What the kernels of some settings depend on: scene, peaks, solver and breakage, each once.

    Parameters
    ----------
    settings : iterable of dict
        Each with ``effects``, ``choices`` and ``numerics`` as in a configuration.
    """
    found = {
        (
            scene_name(effects_of(each)),
            each["choices"]["peaks"],
            each["numerics"]["solver"],
            each["numerics"]["breakage"],
        )
        for each in settings
    }
    return [list(each) for each in sorted(found)]


def of_rock(configuration: dict, rock: str) -> dict:
    """A study's configuration without its other rocks."""
    alone = {"study": configuration["study"] | {"rocks": [rock]}}
    return configuration | alone | {"rocks": {rock: configuration["rocks"][rock]}}


def written_out(configuration: dict) -> dict:
    """A configuration whose ``effects: auto`` is written out: all may act, chosen to 2 %."""
    if configuration.get("effects") != "auto":
        return configuration
    everything = dict.fromkeys(Effects._fields, True)
    return configuration | {"effects": everything | {"auto": _AUTO_TOLERANCE}}


def choices_of(configuration: dict) -> Choices:
    """Choices of a study, in SI."""
    return Choices(**to_si(configuration["choices"]))


def numerics_of(configuration: dict) -> Numerics:
    """Numerics of a study, in SI."""
    return Numerics(**to_si(numerics_in_full(configuration)))


def numerics_in_full(configuration: dict) -> dict:
    """Numerics of a study without the preset or accuracy that chose them."""
    return {key: value for key, value in configuration["numerics"].items() if key not in CHOSEN_BY}


def _explained(error: jsonschema.ValidationError) -> Iterator[str]:
    """One line for each key that a schema error is about."""
    where = ".".join(str(part) for part in error.absolute_path)
    prefix = f"{where}." if where else ""
    schema = error.schema
    if error.validator == "additionalProperties" and isinstance(error.instance, dict):
        known = list(schema.get("properties", {}))
        for key in error.instance:
            if key not in known:
                close = difflib.get_close_matches(str(key), known, n=1)
                meant = f"; did you mean {close[0]}?" if close else ""
                yield (
                    f"{prefix}{key} = {error.instance[key]!r}: unknown key{meant} "
                    f"(allowed: {', '.join(known)})"
                )
    elif error.validator == "required":
        missing = [key for key in schema["required"] if key not in error.instance]
        yield f"{where or 'the configuration'}: lacks {', '.join(missing)}"
    else:
        yield f"{where or 'the configuration'} = {error.instance!r}: {_allowed(error)}"


def _allowed(error: jsonschema.ValidationError) -> str:
    rule, value = error.validator, error.validator_value
    if rule == "type" and list(error.absolute_path) == ["effects"]:
        return "must be auto, or effects with true or false"
    close = ""
    if rule == "enum" and isinstance(error.instance, str):
        found = difflib.get_close_matches(error.instance, [str(v) for v in value], n=1)
        close = f"; did you mean {found[0]}?" if found else ""
    said = {
        "type": f"must be of type {_choice(value)}",
        "enum": f"must be one of {_choice(value)}{close}",
        "minimum": f"must be at least {value}",
        "maximum": f"must be at most {value}",
        "exclusiveMinimum": f"must be above {value}",
        "exclusiveMaximum": f"must be below {value}",
        "minItems": f"needs at least {value} values",
        "pattern": f"must match {value} (lower-case letters, digits and underscores)",
    }
    return said.get(rule, error.message)


def _choice(values: object) -> str:
    return ", ".join(map(str, values)) if isinstance(values, list) else str(values)


def _contradictions(configuration: dict) -> Iterator[str]:
    """What no schema can say: keys that contradict each other."""
    rocks, study = configuration["rocks"], configuration["study"]
    for name in study["rocks"]:
        if name not in rocks:
            close = difflib.get_close_matches(name, rocks, n=1)
            meant = f"; did you mean {close[0]}?" if close else ""
            yield f"study.rocks = {name!r}: not among rocks ({', '.join(rocks)}){meant}"
    for check in (
        *(
            lambda name=name: check_scene(effects_of(configuration, name))
            for name in (None, *study["rocks"])
            if name is None or "effects" in rocks.get(name, {})
        ),
        lambda: check_choices(choices_of(configuration), to_si(configuration["grid"])["spacing"]),
        lambda: check_numerics(numerics_of(configuration), tuple(SOLVERS)),
    ):
        try:
            check()
        except InputError as error:
            yield str(error)
    if choice_tolerance(configuration) is not None and study["realizations"] < 2:
        yield (
            f"study.realizations = {study['realizations']!r}: "
            "effects.auto closes pieces of 2 pairs of walls at least"
        )
    relation = relation_of(configuration["surface"]["jrc_relation"])
    for name in study["rocks"]:
        rock = rocks.get(name)
        if rock is None:
            continue
        if configuration["seating_stress_MPa"] >= rock["max_normal_stress_MPa"]:
            yield (
                f"seating_stress_MPa = {configuration['seating_stress_MPa']!r}: must be below "
                f"rocks.{name}.max_normal_stress_MPa = {rock['max_normal_stress_MPa']!r}"
            )
        stress, end = rock["max_normal_stress_MPa"], configuration["output"]["largest_stress_MPa"]
        where = f"rocks.{name}.max_normal_stress_MPa = {stress!r}"
        if end is not None and end < stress:
            yield f"output.largest_stress_MPa = {end!r}: must be at least {where}"
        moduli = [rock["youngs_modulus_GPa"], *(rock["levels"].get("youngs_modulus_GPa") or [])]
        if stress >= 1e3 * min(moduli):
            yield f"{where}: must be below Young's modulus, {1e3 * min(moduli):g} MPa"
        yield from wall_problems(configuration, name)
        levels_of_rock = {key: value for key, value in rock["levels"].items() if value is not None}
        for parameter, levels in levels_of_rock.items():
            if rock.get(parameter) is not None:
                where = f"rocks.{name}.levels.{parameter}"
                yield from _level_problems(where, levels, rock[parameter])
        jrcs = [rock.get("jrc"), *levels_of_rock.get("jrc", [])]
        for jrc in (jrc for jrc in jrcs if jrc is not None):
            if not relation.smallest_jrc <= jrc <= relation.largest_jrc:
                yield (
                    f"rocks.{name}: jrc = {jrc!r}: "
                    f"{configuration['surface']['jrc_relation']} holds "
                    f"from {relation.smallest_jrc:g} to {relation.largest_jrc:g}"
                )
        for ratio in levels_of_rock.get("poisson_ratio", []):
            if not 0.0 <= ratio <= 0.5:
                yield f"rocks.{name}.levels.poisson_ratio = {ratio!r}: must lie in [0, 0.5]"


def _level_problems(where: str, levels: list, own: float) -> Iterator[str]:
    if any(not later > earlier for earlier, later in itertools.pairwise(levels)):
        yield f"{where} = {levels!r}: must be strictly ascending"
    if own in levels:
        yield f"{where} = {levels!r}: lists the rock's own value {own!r}, which is a level anyway"
    if any(not level >= 0 for level in levels):
        yield f"{where} = {levels!r}: must be positive"

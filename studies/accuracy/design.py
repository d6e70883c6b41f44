"""Settings of an accuracy study, and the runs that close the same surfaces at all of them.

A setting is a variant of the model (scene) of one rock with one changed knob: a step, a tolerance,
a solver, a surface rule. Its configuration is merged from the keys of the study, the scene and the
knob, see ``accuracy`` in `studies.accuracy.section`. A run closes the surfaces at all levels of
one rock property, which gives its indifference interval.
"""

import json
import re
from collections.abc import Iterator
from typing import NamedTuple

from jointclosure.engine.settings import BASE, ClosureSettings
from jointclosure.inputs import InputError
from studies.frame.config.configuration import configured, merged, problem_lines, refuse
from studies.frame.config.files import ConfigurationError
from studies.frame.config.model import Configuration
from studies.frame.ensemble.cases import block_settings, cases_of, surface_settings

_OF_RUN = ("study", "effects", "choices", "numerics", "grid", "surface", "rocks")
"""Sections of a configuration that a run depends on."""


class Setting(NamedTuple):
    """Value of a knob in a variant of the model (``scene``) of a rock.

    Knob `BASE` is the setting without any changed knob. ``run`` is the name of the run with its
    results: settings with equal configurations share one. ``other_joints``: whether the knob
    changes the joints themselves, so that a difference is no numerical error.
    """

    scene: str
    rock: str
    knob: str
    value: float | str
    run: str
    other_joints: bool


class Run(NamedTuple):
    """Closures of the same surfaces at all levels of a rock property.

    ``levels`` are their settings, by ascending ``values`` of the property [SI]; ``base`` is its
    value at the base level [SI].
    """

    levels: tuple[ClosureSettings, ...]
    values: tuple[float, ...]
    base: float


def design_of(keys: dict) -> tuple[list[Setting], dict[str, Run]]:
    """Return all settings of a configuration's ``accuracy`` section, and the runs by name."""
    problems = list(_unknown(keys))
    settings: list[Setting] = []
    runs: dict[str, Run] = {}
    if not problems:
        for setting, whole in _settings(keys):
            try:
                typed = configured(whole).typed
                runs.setdefault(setting.run, _run(typed, setting.rock, keys["accuracy"]))
            except InputError as error:
                where = f"variant {setting.scene}, {setting.knob} {setting.value}"
                problems += [f"accuracy: {where}: {line}" for line in problem_lines(error)]
            settings.append(setting)
    refuse(problems)
    return settings, runs


def _settings(keys: dict) -> Iterator[tuple[Setting, dict]]:
    """Generate all settings of a design, with the keys of their configurations."""
    design = keys["accuracy"]
    runs: dict[str, str] = {}
    for scene, scene_keys in design["scenes"].items():
        overrides = {key: value for key, value in scene_keys.items() if key != "finest"}
        for rock in keys["study"]["rocks"]:
            base = merged(keys, overrides, {"study": {"rocks": [rock]}})
            turned: list[tuple[str, float | str, dict]] = [(BASE, "", base)]
            for knob, way in design["knobs"].items():
                if scene in way["scenes"]:
                    turned += [(knob, value, whole) for value, whole in _turned(base, way)]
            for knob, value, whole in turned:
                what = json.dumps([scene, rock, *(whole[key] for key in _OF_RUN)], sort_keys=True)
                run = runs.setdefault(what, label_of(scene, rock, knob, value))
                other = design["knobs"].get(knob, {}).get("other_joints", False)
                yield Setting(scene, rock, knob, value, run, other), whole


def _run(configuration: Configuration, rock: str, design: dict) -> Run:
    """Return the run of a configuration of one rock."""
    parameter = design["parameter"]
    labelled = {case.label: case for case in cases_of(configuration)}
    cases = [case for case in labelled.values() if case.parameter in (BASE, parameter)]
    cases = sorted(cases, key=lambda case: case.property(parameter))
    block = range(configuration.study.realizations)
    surfaces = surface_settings(configuration, cases[0], block)
    settings = [
        block_settings(configuration, labelled, case.label, block)._replace(surfaces=surfaces)
        for case in cases
    ]
    return Run(
        # no quantity counts from seating, and an elastic curve needs no point there
        tuple(level._replace(seating_stress=0.0) for level in settings),
        tuple(case.property(parameter) for case in cases),
        configuration.rocks[rock].intact._asdict()[parameter],
    )


def _unknown(keys: dict) -> Iterator[str]:
    """Generate problems of variants, knobs and keys that do not exist."""
    design = keys["accuracy"]
    for scene, settings in design["scenes"].items():
        overrides = {key: value for key, value in settings.items() if key != "finest"}
        yield from _strange(keys, overrides, f"accuracy.scenes.{scene}")
        knob = settings["finest"]["knob"]
        if knob != BASE and scene not in design["knobs"].get(knob, {"scenes": []})["scenes"]:
            yield f"accuracy.scenes.{scene}.finest.knob = {knob!r}: is no knob of this variant"
    for knob, way in design["knobs"].items():
        where = f"accuracy.knobs.{knob}"
        for scene in way["scenes"]:
            if scene not in design["scenes"]:
                yield f"{where}.scenes = {scene!r}: must be one of {', '.join(design['scenes'])}"
        yield from _strange(keys, way.get("set", {}), f"{where}.set")
        for key in _keys_of(way):
            section, name = key.split(".")
            if not isinstance(keys.get(section), dict) or name not in keys[section]:
                yield f"{where}: {key}: there is no such key"
        for entry in way["values"]:
            if isinstance(entry, dict):
                yield from _strange(keys, entry["set"], f"{where}.values")
            elif not _keys_of(way):
                yield f"{where}.values = {entry!r}: without key or scale it needs value and set"


def _keys_of(way: dict) -> list[str]:
    """Return the keys (section.key) that a knob sets or scales."""
    return [way["key"]] if way.get("key") else way.get("scale") or []


def _strange(known: dict, settings: dict, where: str) -> Iterator[str]:
    """Generate problems of nested keys that do not exist, or replace a whole section."""
    for key, value in settings.items():
        if key not in known:
            yield f"{where}.{key} = {value!r}: unknown key (allowed: {', '.join(known)})"
        elif isinstance(known[key], dict) and not isinstance(value, dict):
            yield f"{where}.{key} = {value!r}: must hold keys and values"
        elif isinstance(value, dict) and isinstance(known[key], dict):
            yield from _strange(known[key], value, f"{where}.{key}")


def label_of(scene: str, rock: str, knob: str, value: float | str) -> str:
    """Return the name of a run's files, which is never parsed."""
    shown = value if isinstance(value, str) else f"{value:g}"
    text = "-".join(part for part in (scene, rock, knob, shown) if part)
    return re.sub("[^a-z0-9_-]+", "_", text.lower().replace(".", "p").replace("+", ""))


def _turned(base: dict, way: dict) -> Iterator[tuple[float | str, dict]]:
    """Generate the values of a knob with their configurations."""
    base = merged(base, way.get("set", {}))
    for entry in way["values"]:
        if isinstance(entry, dict):
            yield entry["value"], merged(base, entry["set"])
            continue
        change: dict = {}
        for key in _keys_of(way):
            section, name = key.split(".")
            value = base[section][name]
            if way.get("scale"):
                for number, where in ((value, key), (entry, "values")):
                    if not isinstance(number, int | float):
                        raise ConfigurationError(
                            f"accuracy.knobs: {where} = {number!r}: must be a number to be scaled"
                        )
            value = value * entry if way.get("scale") else entry
            change = merged(change, {section: {name: value}})
        yield entry, merged(base, change)

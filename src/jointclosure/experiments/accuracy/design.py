"""What accuracy costs: the same surfaces closed at many settings.

A setting is one scene of one rock with one knob turned: a step, a tolerance, a
solver, a surface rule. Each is a whole configuration, merged from the keys of the study,
the scene and the knob, see ``accuracy`` in `jointclosure.config.keys`; what is kept of it is
what a run depends on. A run closes the surfaces at all levels of one rock property, so that
its indifference interval can be followed too.
"""

import json
import re
from collections.abc import Iterator
from typing import NamedTuple

from jointclosure.config.configuration import configured, merged, problem_lines, refuse
from jointclosure.config.files import ConfigurationError
from jointclosure.config.presets import numerics_in_full
from jointclosure.config.typed import Configuration, Grid, Surface
from jointclosure.ensemble.cases import BASE, cases_of
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.inputs import InputError
from jointclosure.parameters import Rock

_OWN = ("study", "effects", "choices", "numerics", "grid", "surface", "rocks")
"""Sections of a configuration that a run depends on."""


_POINTS = ("finest", "cross")
"""Keys of a variant that name a knob and its value, and are no settings."""


class Setting(NamedTuple):
    """A knob turned to a value, in a variant of the model (``scene``) of a rock.

    Knob `BASE` is the setting in which none is turned. ``run`` names the run that has its
    results: settings with equal configurations share one. ``other_joints`` are closed where
    the knob changes the joints themselves: a difference there is no numerical error.
    ``numerics`` are the keys in which it differs from the variant's base, None where it
    differs in others too.
    """

    scene: str
    rock: str
    knob: str
    value: float | str
    run: str
    other_joints: bool
    numerics: dict | None


class Run(NamedTuple):
    """Closures of the same surfaces at all levels of a rock property.

    ``levels`` are their settings, the property's values ascending; ``values`` these values and
    ``base`` the rock's own [SI].
    """

    levels: tuple[ClosureSettings, ...]
    values: tuple[float, ...]
    base: float


class Joint(NamedTuple):
    """What a variant of the model closes: the joint of its first rock, at the base level.

    ``stress`` [Pa]; ``levels``: how many a run has.
    """

    grid: Grid
    surface: Surface
    rock: Rock
    jrc: float
    stress: float
    levels: int


def joint_of(scene: str, settings: list[Setting], runs: dict[str, Run]) -> Joint:
    """The joint of a variant."""
    run = runs[next(each.run for each in settings if each.scene == scene)]
    closed = run.levels[run.values.index(run.base)]
    case, made = closed.case, closed.surfaces
    stress, levels = case.max_normal_stress, len(run.levels)
    return Joint(made.grid, made.surface, case.intact, case.jrc, stress, levels)


def design_of(keys: dict) -> tuple[list[Setting], dict[str, Run]]:
    """All settings of a configuration's ``accuracy`` section, and the runs by name.

    Parameters
    ----------
    keys : dict
        Of a configuration that was checked, see `jointclosure.config.configuration.Configured`.

    Returns
    -------
    settings : list of Setting
        The base of each variant first.
    runs : dict

    Raises
    ------
    ConfigurationError
        Naming each variant, knob or key that does not exist, and each setting that
        the model cannot take.
    """
    problems = list(_unknown(keys))
    settings: list[Setting] = []
    runs: dict[str, Run] = {}
    if not problems:
        for setting, whole in _settings(keys):
            try:
                typed = configured(whole, _no_table).typed
                runs.setdefault(setting.run, _run(typed, setting.rock, keys["accuracy"]))
            except InputError as error:
                where = f"variant {setting.scene}, {setting.knob} {setting.value}"
                problems += [f"accuracy: {where}: {line}" for line in problem_lines(error)]
            settings.append(setting)
    refuse(problems)
    return settings, runs


def _no_table(path):
    raise InputError("numerics.preset, numerics.accuracy: not in a variant or knob")


def _settings(keys: dict) -> Iterator[tuple[Setting, dict]]:
    """All settings of a design, each with the keys of its configuration."""
    design = keys["accuracy"]
    plain = keys | {"numerics": numerics_in_full(keys)}  # what a preset chose is written there
    runs: dict[str, str] = {}
    for scene, scene_keys in design["scenes"].items():
        overrides = {key: value for key, value in scene_keys.items() if key not in _POINTS}
        for rock in keys["study"]["rocks"]:
            base = merged(plain, overrides, {"study": {"rocks": [rock]}})
            turned: list[tuple[str, float | str, dict]] = [(BASE, "", base)]
            for knob, way in design["knobs"].items():
                if scene in way["scenes"]:
                    turned += [(knob, value, whole) for value, whole in _turned(base, way)]
            for knob, value, whole in turned:
                what = json.dumps([scene, rock, *(whole[key] for key in _OWN)], sort_keys=True)
                run = runs.setdefault(what, label_of(scene, rock, knob, value))
                other = design["knobs"].get(knob, {}).get("other_joints", False)
                changed = _changed_numerics(whole, base)
                yield Setting(scene, rock, knob, value, run, other, changed), whole


def _changed_numerics(keys: dict, base: dict) -> dict | None:
    """Numerics that are not as in the base, None where any other key is not."""
    if any(keys[name] != base[name] for name in base if name != "numerics"):
        return None
    numerics, usual = keys["numerics"], base["numerics"]
    return {key: numerics[key] for key in usual if numerics[key] != usual[key]}


def _run(configuration: Configuration, rock: str, design: dict) -> Run:
    """The run of a configuration of one rock."""
    parameter = design["parameter"]
    cases = [case for case in cases_of(configuration) if case.parameter in (BASE, parameter)]
    cases = sorted(cases, key=lambda case: case.property(parameter))
    block = range(configuration.study.realizations)
    surfaces = surface_settings(configuration, cases[0], block)
    settings = (closure_settings(configuration, case, surfaces) for case in cases)
    return Run(
        # nothing is read from seating on, and an elastic curve needs no point there
        tuple(each._replace(seating_stress=0.0) for each in settings),
        tuple(case.property(parameter) for case in cases),
        configuration.rocks[rock].intact._asdict()[parameter],
    )


def _unknown(keys: dict) -> Iterator[str]:
    design = keys["accuracy"]
    for scene, settings in design["scenes"].items():
        overrides = {key: value for key, value in settings.items() if key not in _POINTS}
        yield from _strange(keys, overrides, f"accuracy.scenes.{scene}")
        for name in _POINTS:
            knob = (settings.get(name) or {"knob": BASE})["knob"]
            if knob != BASE and scene not in design["knobs"].get(knob, {"scenes": []})["scenes"]:
                where = f"accuracy.scenes.{scene}.{name}.knob"
                yield f"{where} = {knob!r}: is not turned in this variant"
    for name, point in design["presets"].items():
        if point["knob"] != BASE and point["knob"] not in design["knobs"]:
            yield f"accuracy.presets.{name}.knob = {point['knob']!r}: there is no such knob"
    yield from _unknown_of_total(design)
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


def _unknown_of_total(design: dict) -> Iterator[str]:
    """What the diagram of total error names and the design does not have."""
    total = design.get("total")
    if not total:
        return
    for key, of in (("scene", "methods"), ("interval_scene", "interval_methods")):
        scene = total[key]
        if scene not in design["scenes"]:
            yield f"accuracy.total.{key} = {scene!r}: must be one of {', '.join(design['scenes'])}"
        for name, point in total.get(of, {}).items():
            way = design["knobs"].get(point["knob"], {"scenes": [], "values": []})
            values = [each["value"] if isinstance(each, dict) else each for each in way["values"]]
            turned = scene in way["scenes"] and point["value"] in values
            if point["knob"] != BASE and not turned:
                where = f"accuracy.total.{of}.{name}"
                yield f"{where} = {point['knob']} {point['value']}: is not turned in {scene}"


def _keys_of(way: dict) -> list[str]:
    """Keys (section.key) that a knob sets, or scales."""
    return [way["key"]] if way.get("key") else way.get("scale") or []


def _strange(known: dict, settings: dict, where: str) -> Iterator[str]:
    """Nested settings that the configuration does not have, or that replace a whole section."""
    for key, value in settings.items():
        if key not in known:
            yield f"{where}.{key} = {value!r}: unknown key (allowed: {', '.join(known)})"
        elif isinstance(known[key], dict) and not isinstance(value, dict):
            yield f"{where}.{key} = {value!r}: must hold keys and values"
        elif isinstance(value, dict) and isinstance(known[key], dict):
            yield from _strange(known[key], value, f"{where}.{key}")


def label_of(scene: str, rock: str, knob: str, value: float | str) -> str:
    """Name of a run's files; never taken apart."""
    shown = value if isinstance(value, str) else f"{value:g}"
    text = "-".join(part for part in (scene, rock, knob, shown) if part)
    return re.sub("[^a-z0-9_-]+", "_", text.lower().replace(".", "p").replace("+", ""))


def _turned(base: dict, way: dict) -> Iterator[tuple[float | str, dict]]:
    """Values of a knob, and the configuration at each."""
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

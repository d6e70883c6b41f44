"""What accuracy costs: the same surfaces closed at many settings.

A setting is one scene of one rock with one knob turned: a step, a tolerance, a
solver, a surface rule. Each is a whole configuration, merged from the study's,
the scene's and the knob's; see ``accuracy`` in the schema. A run closes the
surfaces at all levels of one rock property, so that its indifference interval
can be followed too.
"""

import json
import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

from jointclosure.config.configuration import (
    ConfigurationError,
    choices_of,
    effects_of,
    merged,
    numerics_of,
)
from jointclosure.config.units import to_si
from jointclosure.ensemble.cases import Case, cases_of
from jointclosure.ensemble.timing import timed_simulation, walls_of
from jointclosure.inputs import InputError
from jointclosure.parameters import check_choices, check_numerics, check_scene
from jointclosure.solvers.registry import SOLVERS

BASE = "base"
"""Knob of the setting in which none is turned."""
_OWN = ("study", "effects", "choices", "numerics", "grid", "surface", "rocks")
"""Sections of a configuration that a run depends on."""


_POINTS = ("finest", "cross")
"""Keys of a scene that name a knob and its value, and are no settings."""


class Setting(NamedTuple):
    """A knob turned to a value, in a scene of a rock.

    ``run`` names the run that has its results: settings with equal
    configurations share one.
    """

    scene: str
    rock: str
    knob: str
    value: float | str
    run: str
    configuration: dict


def settings_of(configuration: dict) -> list[Setting]:
    """All settings of the configuration's ``accuracy`` section, the base of each scene first."""
    design = configuration["accuracy"]
    plain = {key: value for key, value in configuration.items() if key != "accuracy"}
    found: list[Setting] = []
    runs: dict[str, str] = {}
    for scene, scene_settings in design["scenes"].items():
        overrides = {key: value for key, value in scene_settings.items() if key not in _POINTS}
        for rock in configuration["study"]["rocks"]:
            base = merged(plain, overrides, {"study": {"rocks": [rock]}})
            turned = [(BASE, "", base)]
            for knob, way in design["knobs"].items():
                if scene in way["scenes"]:
                    turned += [(knob, value, whole) for value, whole in _turned(base, way)]
            for knob, value, whole in turned:
                what = json.dumps([scene, rock, *(whole[key] for key in _OWN)], sort_keys=True)
                run = runs.setdefault(what, label_of(scene, rock, knob, value))
                found.append(Setting(scene, rock, knob, value, run, whole))
    return found


def checked_settings(configuration: dict) -> list[Setting]:
    """`settings_of`, if all of them can be run.

    Raises
    ------
    ConfigurationError
        Naming each scene, knob or key that does not exist, and each setting that
        the model cannot take.
    """
    problems = list(_unknown(configuration))
    if not problems:
        for setting in settings_of(configuration):
            try:
                check_scene(effects_of(setting.configuration))
                spacing = to_si(setting.configuration["grid"])["spacing"]
                check_choices(choices_of(setting.configuration), spacing)
                check_numerics(numerics_of(setting.configuration), tuple(SOLVERS))
            except InputError as error:
                where = f"scene {setting.scene}, {setting.knob} {setting.value}"
                problems.append(f"accuracy: {where}: {error}")
    if problems:
        raise ConfigurationError("configuration:\n" + "\n".join(f"  {line}" for line in problems))
    return settings_of(configuration)


def _unknown(configuration: dict) -> Iterator[str]:
    design = configuration["accuracy"]
    for scene, settings in design["scenes"].items():
        overrides = {key: value for key, value in settings.items() if key not in _POINTS}
        yield from _strange(configuration, overrides, f"accuracy.scenes.{scene}")
        for name in _POINTS:
            knob = settings.get(name, {"knob": BASE})["knob"]
            if knob != BASE and scene not in design["knobs"].get(knob, {"scenes": []})["scenes"]:
                yield f"accuracy.scenes.{scene}.{name}.knob = {knob!r}: is not turned in this scene"
    for name, point in design["presets"].items():
        if point["knob"] != BASE and point["knob"] not in design["knobs"]:
            yield f"accuracy.presets.{name}.knob = {point['knob']!r}: there is no such knob"
    for knob, way in design["knobs"].items():
        where = f"accuracy.knobs.{knob}"
        for scene in way["scenes"]:
            if scene not in design["scenes"]:
                yield f"{where}.scenes = {scene!r}: must be one of {', '.join(design['scenes'])}"
        yield from _strange(configuration, way.get("set", {}), f"{where}.set")
        for key in [way["key"]] if "key" in way else way.get("scale", []):
            section, name = key.split(".")
            if name not in configuration.get(section, {}):
                yield f"{where}: {key}: there is no such key"
        for entry in way["values"]:
            if isinstance(entry, dict):
                yield from _strange(configuration, entry["set"], f"{where}.values")
            elif "key" not in way and "scale" not in way:
                yield f"{where}.values = {entry!r}: without key or scale it needs value and set"


def _strange(known: dict, settings: dict, where: str) -> Iterator[str]:
    """Keys of nested settings that the configuration does not have."""
    for key, value in settings.items():
        if key not in known:
            yield f"{where}.{key} = {value!r}: unknown key (allowed: {', '.join(known)})"
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
        for key in way["scale"] if "scale" in way else [way["key"]]:
            section, name = key.split(".")
            value = base[section][name] * entry if "scale" in way else entry
            change = merged(change, {section: {name: value}})
        yield entry, merged(base, change)


def cases_of_run(setting: Setting, parameter: str) -> list[Case]:
    """Cases of a run: all levels of one rock property, ascending."""
    cases = [
        case for case in cases_of(setting.configuration) if case.parameter in (BASE, parameter)
    ]
    return sorted(cases, key=lambda case: getattr(case, parameter))


def close_at(
    setting: Setting, parameter: str, report: Callable[[str], None] = lambda line: None
) -> xr.Dataset:
    """Close the surfaces of a run at all levels of a rock property.

    Returns
    -------
    Dataset
        ``max_closure`` and ``max_closure_net`` [m] over (level, realization, cycle), ``status``,
        ``timing_simulation`` [s] and ``timing_pair`` [s], the time of one FFT pair
        (`scipy.fft.rfft2` and `irfft2` of 200 x 200) beside each simulation.
    """
    whole = setting.configuration
    study = whole["study"]
    cases = cases_of_run(setting, parameter)
    shape = (len(cases), study["realizations"])
    closure, net = np.full((2, *shape, study["cycles"]), np.nan)
    status = np.zeros(shape, np.int16)
    seconds, pairs = np.zeros(shape), np.zeros(shape)
    for realization in range(study["realizations"]):
        walls = walls_of(whole, cases[0], realization)
        for level, case in enumerate(cases):
            timed = timed_simulation(whole, case, walls)
            closure[level, realization] = timed.closed.max_closure.values
            bulk = timed.closed.max_bulk_indentation.values
            net[level, realization] = timed.closed.max_closure.values - bulk
            status[level, realization] = timed.closed.status
            seconds[level, realization] = timed.seconds
            pairs[level, realization] = timed.pair
        report(f"realisation {realization}: {seconds[:, realization].sum():.2f} s")
    dimensions = ("level", "realization")
    return xr.Dataset(
        {
            "max_closure": ((*dimensions, "cycle"), closure, {"units": "m"}),
            "max_closure_net": ((*dimensions, "cycle"), net, {"units": "m"}),
            "status": (dimensions, status),
            "timing_simulation": (dimensions, seconds, {"units": "s"}),
            "timing_pair": (dimensions, pairs, {"units": "s"}),
        },
        coords={
            "level": [getattr(case, parameter) for case in cases],
            "cycle": np.arange(1, study["cycles"] + 1),
        },
        attrs={"base": getattr(next(c for c in cases if c.parameter == BASE), parameter)},
    )

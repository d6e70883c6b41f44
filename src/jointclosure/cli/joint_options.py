"""Options and output of the commands that close a joint: rock, load and model."""

import argparse
import inspect
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

from jointclosure.engine.budget import Budget
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.curves import curve_table, cycle_table, has_flow
from jointclosure.joint.protocol import FAILURE
from jointclosure.joint.simulation import simulate
from jointclosure.parameters import OF_ROCK, Effects, Rock, key_of
from jointclosure.storage.folders import check_record
from jointclosure.walls.scans.units import UNITS
from studies.frame.config.files import value_of

_SHORTER = {"compressive_strength": "strength"}
"""Options with a shorter name than the property of rock that they set."""
_INTACT = {_SHORTER.get(name, name): name for name in OF_ROCK}
"""Properties of intact rock by option."""
OPTIONS = {option: key_of(name) for option, name in _INTACT.items()} | {
    "jrc": "jrc",
    "stress": "max_normal_stress_MPa",
}
"""Keys of a rock in a configuration by option."""
NEEDED = tuple(option for option in OPTIONS if _INTACT.get(option) not in Rock._field_defaults)
"""Options that must be given if no rock is named: those of properties without a default."""


def documented(function: Callable) -> dict[str, str]:
    """Return the first sentence of the documentation of each parameter of a function."""
    text = re.split(r"(?:Parameters|Attributes)\n-+\n", inspect.getdoc(function) or "")[1]
    entries = re.findall(r"^(\S+(?:, \S+)*)(?: : .*)?\n((?:    .*\n?)+)", text, re.MULTILINE)
    texts: dict[str, str] = {}
    for names, about in entries:
        plain = re.sub(r" \[[^]]*\]| \(`jointc[^)]*\)|`", "", " ".join(about.split()))
        texts |= dict.fromkeys(names.split(", "), re.split(r"\.(?: |$)", plain)[0])
    return texts


def add_keywords(group: argparse._ActionsContainer, function: Callable, **options: dict) -> None:
    """Declare options that are keywords of a function; its documentation is their help.

    ``options`` are arguments of ``add_argument`` by the name of the option, and ``keyword`` if that
    of the function has another name.
    """
    texts, signature = documented(function), inspect.signature(function).parameters
    for name, about in options.items():
        keyword = about.pop("keyword", name)
        default = about.setdefault("default", signature[keyword].default)
        text = texts[keyword] + (f" (default {default})" if default else "")
        option = "--" + name.replace("_", "-")
        group.add_argument(option, help=text.replace("%", "%%"), **about)


def add_scans(group: argparse._ActionsContainer, function: Callable, spacing: str) -> None:
    """Declare what files of scans do not state; the keyword ``spacing`` is that of the scans."""
    add_keywords(
        group,
        function,
        units={"choices": list(UNITS)},
        spacing={"keyword": spacing, "type": float, "metavar": "mm"},
        variable={},
    )


def add_rock(command: argparse.ArgumentParser) -> None:
    """Declare the arguments of the material of the joint."""
    rock = command.add_argument_group("rock")
    rock.add_argument("--rock", metavar="NAME", help="a rock of the configuration, or granite")
    rock.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="configuration whose keys replace those of the paper's study",
    )
    for option, name in _INTACT.items():
        about = OF_ROCK[name]
        rock.add_argument(
            "--" + option.replace("_", "-"),
            type=float,
            metavar=about.symbol.upper() if about.unit == "1" else about.unit,
            help=f"{about.long_name} {about.symbol}",
        )


def add_load_and_model(command: argparse.ArgumentParser) -> None:
    """Declare the arguments of the load and of the model."""
    load = command.add_argument_group("load")
    load.add_argument(
        "--stress",
        type=_stress,
        metavar="MPa",
        help="maximum normal stress; or a load history, the stresses at which the load turns, "
        "such as 5,0,20,2,30",
    )
    add_keywords(load, Conditions, cycles={"type": int, "metavar": "N"})
    add_seating(load)
    add_keywords(load, simulate, snapshots={"type": _stresses, "metavar": "MPa,..."})
    load.add_argument(
        "--animation",
        type=Path,
        metavar="FILE.gif",
        help="animation of the joint being crushed",
    )
    add_keywords(add_model(command), Conditions, flow={"action": "store_true"})


def add_seating(load: argparse._ArgumentGroup) -> None:
    """Declare the stress from which seated closures count."""
    seating = {"keyword": "seating_stress", "type": float, "metavar": "MPa"}
    add_keywords(load, Conditions, seating=seating)


def add_model(command: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Declare the arguments of the model of a closure."""
    model = command.add_argument_group("model")
    model.add_argument(
        "--without",
        nargs="+",
        action="extend",
        choices=Effects._fields,
        default=[],
        metavar="EFFECT",
        help=f"effects to leave out, of {', '.join(Effects._fields)}",
    )
    model.add_argument(
        "--set",
        nargs="+",
        action="extend",
        type=_setting,
        default=[],
        metavar="KEY=VALUE",
        help="any other key of the configuration, such as choices.largest_radius_mm=20",
    )
    return model


def summary(closed: xr.Dataset, budget: Budget | None = None) -> str:
    """Format the results of each cycle as lines of text, with their range if it is known."""
    seating = 1e-6 * closed.attrs["seating_stress_Pa"]
    table = cycle_table(closed)
    names = {
        "max_closure_seated_net_mm": f"net since {seating:g} MPa",
        "residual_closure_seated_net_mm": "residual net",
        "max_closure_seated_mm": f"gross since {seating:g} MPa",
        "max_closure_mm": "gross from its start",
    }
    frame = table[list(names)].rename(columns=names)
    frame.index = [f"cycle {number}" for number in table.cycle]
    lines = (
        [
            "gross closure contains the elastic indentation of the half-spaces, net does not"
            f"; closures since {seating:g} MPa; in brackets the range of 9 in 10 "
            "random sets of the inputs that are not known",
            str(budget),
        ]
        if budget
        else [
            "closure (mm); gross contains the elastic indentation of the half-spaces, net does not",
            frame.to_string(float_format="{:.5f}".format),
        ]
    )
    full = table[table.mean_aperture_at_max_mm <= 0.0]
    for cycle, aperture in zip(full.cycle, full.mean_aperture_at_max_mm, strict=True):
        lines.append(
            f"warning: the mean aperture is {aperture:.2g} mm at the maximum of cycle {cycle}: the "
            "walls overlap by more than the void that is left, and the model does not hold there"
        )
    if has_flow(closed):
        lines += ["at the maximum (mm)", _apertures(closed).to_string(float_format="{:.5f}".format)]
    return "\n".join(lines)


def _apertures(closed: xr.Dataset) -> pd.DataFrame:
    """Return mechanical and hydraulic apertures [mm] at the largest stress of each cycle."""
    curves = curve_table(closed)
    at = curves.loc[curves.groupby("cycle").normal_stress_MPa.idxmax()]
    at.index = [f"cycle {number}" for number in at.cycle]
    names = {
        "mean_aperture_mm": "mean aperture",
        "hydraulic_aperture_x_mm": "hydraulic along x",
        "hydraulic_aperture_y_mm": "along y",
    }
    return at[list(names)].rename(columns=names)


def status_text(closed: xr.Dataset) -> str:
    """Return success or failure, with the remarks of the status in words."""
    about, status = closed.status.attrs, int(closed.status)
    named = zip(about["flag_masks"], about["flag_meanings"].split(), strict=True)
    remarks = [name for mask, name in named if status & int(mask)]
    word = "failed" if status >= FAILURE else "success"
    return f"{word}{': ' + ', '.join(remarks) if remarks else ''}"


def _numbers(text: str, what: str) -> tuple[float, ...]:
    """Read a list of numbers."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: must be {what}") from None


def _stress(text: str) -> float | tuple[float, ...]:
    """Read a stress, or a load history [MPa]."""
    stresses = _numbers(text, "a stress in MPa, or a load history such as 5,0,20,2,30")
    return stresses if len(stresses) > 1 else stresses[0]


def _stresses(text: str) -> tuple[float, ...]:
    """Read stresses [Pa] from a list in MPa."""
    return tuple(1e6 * stress for stress in _numbers(text, "stresses in MPa, such as 1,5,10"))


def _setting(text: str) -> dict:
    """Read a nested setting from `section.key=value`."""
    key, equals, value = text.partition("=")
    if not equals or not key:
        raise argparse.ArgumentTypeError(f"{text!r}: must be like numerics.breakage=resolved")
    setting: Any = value_of(value)
    for part in reversed(key.split(".")):
        setting = {part: setting}
    return setting


def check_can_be_made(folder: Path) -> None:
    """Refuse a folder of results that cannot be written, before anything is computed."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file, must be a folder")
    if not folder.parent.is_dir():
        raise InputError(f"{folder}: folder {folder.parent} not found")
    check_record(folder)


def check_destination(path: Path | None, suffixes: tuple[str, ...]) -> None:
    """Refuse a file that could not be written, before anything is computed; None is none."""
    if path is None:
        return
    if path.suffix.lower() not in suffixes:
        raise InputError(f"{path}: must end in {' or '.join(suffixes)}")
    if not path.parent.is_dir():
        raise InputError(f"{path}: folder {path.parent} not found")

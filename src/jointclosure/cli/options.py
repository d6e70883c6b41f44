"""Options of commands that are keywords of the library's functions, and files of their results."""

import argparse
import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import UnionType
from typing import Any, Literal, get_args, get_origin

from jointclosure.inputs import UNITS as UNITS_OF_SCANS
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.rocks import ROCKS, KnownRock, matching
from jointclosure.parameters import OF_ROCK, SOLVER_NAMES, Choices, Effects, Numerics, Rock
from jointclosure.parameters.units import in_unit, to_si
from jointclosure.storage.folders import check_record
from jointclosure.walls.registration import ORIENTATIONS, SHIFTS

UNITS = (
    {name: about.unit for name, about in OF_ROCK.items()}
    | {name: "um" for name in Numerics._fields if name.endswith("_step")}
    | dict.fromkeys(("max_normal_stress", "seating_stress", "snapshots"), "MPa")
    | dict.fromkeys(("spacing", "scan_spacing", "largest_radius"), "mm")
    | dict.fromkeys(("roll_off", "mismatch_wavelength"), "mm")
)
"""Units of options by keyword; other options have none."""
_OPTIONS = {
    "max_normal_stress": "stress",
    "seating_stress": "seating",
    "compressive_strength": "strength",
}
"""Options that have another name than their keyword."""
_CHOICES: dict[str, Iterable[str]] = {
    "units": UNITS_OF_SCANS,
    "orientation": ORIENTATIONS,
    "shift": SHIFTS,
    "solver": SOLVER_NAMES,
}
_NONE = "none"
PICTURES = (".png", ".pdf", ".svg")


def option_of(keyword: str) -> str:
    """Return the option of a keyword: --grid-spacing of grid_spacing."""
    return "--" + _OPTIONS.get(keyword, keyword).replace("_", "-")


def documented(function: Callable) -> dict[str, str]:
    """Return the first sentence of the documentation of each parameter of a function."""
    text = re.split(r"(?:Parameters|Attributes)\n-+\n", inspect.getdoc(function) or "")[1]
    entries = re.findall(r"^(\S+(?:, \S+)*)(?: : .*)?\n((?:    .*\n?)+)", text, re.MULTILINE)
    texts: dict[str, str] = {}
    for names, about in entries:
        plain = re.sub(r" \[\w+\]| \(`jointc[^)]*\)|`", "", " ".join(about.split()))
        texts |= dict.fromkeys(names.split(", "), re.split(r"(?<! al)\.(?: |$)", plain)[0])
    return texts


def add_keywords(
    group: argparse._ActionsContainer,
    function: Callable,
    *names: str,
    usual: Mapping[str, Any] = {},
    **changes: dict,
) -> None:
    """Declare keywords of a function as options; its documentation is their help.

    A value that is not given is not in the arguments, so that the function's default holds, or
    that of ``usual``. ``changes`` are arguments of ``add_argument`` by keyword, with the ``option``
    if it has another name.
    """
    texts, signature = documented(function), inspect.signature(function).parameters
    for name in (*names, *changes):
        given = changes.get(name, {})
        form = {} if "choices" in given else _form(name, signature[name].annotation)
        default = usual.get(name, signature[name].default)
        if isinstance(default, bool):
            form["default"] = default
        about: dict[str, Any] = {"dest": name, "default": argparse.SUPPRESS} | form | given
        default = given.get("default", default)
        if not isinstance(default, bool) and default not in (None, (), inspect.Parameter.empty):
            unit = UNITS.get(name, "")
            shown = in_unit(default, unit) if unit else default
            texts[name] += f" (default {shown}{' ' * bool(unit)}{unit})"
        option = about.pop("option", option_of(name))
        group.add_argument(option, **{"help": texts[name].replace("%", "%%")} | about)


def _form(name: str, hint: Any) -> dict[str, Any]:
    """Return the arguments of ``add_argument`` for a keyword with a type."""
    types = get_args(hint) if get_origin(hint) is UnionType else (hint,)
    kinds = {get_origin(kind) or kind for kind in types}
    if hint is bool:
        return {"action": argparse.BooleanOptionalAction if name == "replay" else "store_true"}
    if name in _CHOICES or Literal in kinds:
        return {"choices": list(_CHOICES.get(name, get_args(hint)))}
    if int in kinds:
        return {"type": int, "metavar": "N"}
    if name not in UNITS and float not in kinds:
        return {}
    several, unit = kinds & {Sequence, tuple}, UNITS.get(name, "1")
    kind = partial(numbers, name, bool(several), float in kinds, type(None) in kinds)
    metavar = "NUMBER" if unit == "1" else unit
    return {"type": kind, "metavar": f"{metavar},..." if several else metavar}


def numbers(keyword: str, several: bool, single: bool, none: bool, text: str) -> Any:
    """Read a number, or several with commas, in the unit of a keyword, in SI; or none."""
    if none and text == _NONE:
        return None
    unit, parts = UNITS.get(keyword, "1"), text.split(",") if several else [text]
    key = keyword if unit == "1" else f"{keyword}_{unit}"
    try:
        ((_, values),) = to_si({key: [float(part) for part in parts]}).items()
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    except ValueError:
        what = "numbers with commas between them" if several else "a number"
        raise argparse.ArgumentTypeError(f"{text!r}: must be {what}") from None
    return values[0] if single and len(values) == 1 else tuple(values)


def keywords(arguments: argparse.Namespace, names: Iterable[str]) -> dict[str, Any]:
    """Return the arguments that were given, of the named ones."""
    return {name: getattr(arguments, name) for name in names if hasattr(arguments, name)}


def add_rock(command: argparse.ArgumentParser) -> None:
    """Declare the rock, by its name or its properties."""
    rock = command.add_argument_group("rock")
    rock.add_argument("--rock", metavar="NAME", help=f"one of {', '.join(ROCKS)}")
    for name, about in OF_ROCK.items():
        form = _form(name, float) | {"dest": name, "default": argparse.SUPPRESS}
        rock.add_argument(option_of(name), help=f"{about.long_name} {about.symbol}", **form)


def add_load(command: argparse.ArgumentParser, simulate: Callable) -> None:
    """Declare the load, and what is stored under it."""
    load = command.add_argument_group("load")
    add_keywords(load, Conditions, "max_normal_stress", "cycles", "seating_stress")
    add_keywords(load, simulate, "snapshots")
    load.add_argument("--animation", type=Path, metavar="FILE.gif", help="animation of the closure")


def add_model(command: argparse.ArgumentParser, usual: Numerics, *fields: str) -> None:
    """Declare effects, choices, numerics with their usual values, and fields of `Conditions`."""
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
    add_keywords(model, Conditions, *fields)
    add_keywords(model, Choices, *Choices._fields)
    numerics = command.add_argument_group("numerics")
    add_keywords(numerics, Numerics, *Numerics._fields, usual=usual._asdict())


def rock_of(arguments: argparse.Namespace, *needed: str) -> KnownRock:
    """Return the rock that is named or given; without a name the keywords ``needed`` must be too.

    Properties that are given replace those of a named rock.
    """
    given = keywords(arguments, OF_ROCK)
    if arguments.rock is None:
        required = [name for name in OF_ROCK if name not in Rock._field_defaults]
        missing = [name for name in (*required, *needed) if not hasattr(arguments, name)]
        if missing:
            options = ", ".join(map(option_of, missing))
            raise InputError(f"without --rock (such as --rock granite): {options} must be given")
        return KnownRock("Rock", Rock(**given))
    name = matching(arguments.rock, ROCKS)
    if name is None:
        raise InputError(f"--rock {arguments.rock}: must be one of {', '.join(ROCKS)}")
    return ROCKS[name]._replace(intact=ROCKS[name].intact._replace(**given))


def jrc_of(arguments: argparse.Namespace, rock: KnownRock) -> Any:
    """Return the joint roughness coefficient that is given, or that of the rock."""
    if (jrc := getattr(arguments, "jrc", rock.jrc)) is None:
        raise InputError(f"--rock {arguments.rock}: has no roughness, --jrc must be given")
    return jrc


def model_of(arguments: argparse.Namespace, usual: Numerics) -> dict[str, Any]:
    """Return effects, choices and numerics; without a stated rule of breakage the usual ones."""
    given = keywords(arguments, Numerics._fields)
    numerics = (Numerics() if "breakage" in given else usual)._replace(**given)
    if "tolerance" in given and numerics.breakage != "resolved":
        raise InputError(
            "--tolerance: has no effect on fixed steps of breakage, needs --breakage resolved"
        )
    return {
        "effects": Effects()._replace(**dict.fromkeys(arguments.without, False)),
        "choices": Choices(**keywords(arguments, Choices._fields)),
        "numerics": numerics,
    }


def conditions_of(
    arguments: argparse.Namespace, rock: KnownRock, usual: Numerics
) -> dict[str, Any]:
    """Return the fields of `Conditions` that are given; ``usual`` as for `model_of`."""
    stress = {"max_normal_stress": rock.max_normal_stress}
    given = keywords(arguments, Conditions._fields) | {"rock": rock.intact}
    return stress | given | model_of(arguments, usual)


def check_folder(folder: Path) -> None:
    """Refuse a folder of results that cannot be written, before anything is computed."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file, must be a folder")
    if not folder.parent.is_dir():
        raise InputError(f"{folder}: folder {folder.parent} not found")
    check_record(folder)


def check_file(path: Path | None, suffixes: tuple[str, ...]) -> None:
    """Refuse a file that could not be written, before anything is computed; None is none."""
    if path is None:
        return
    if path.suffix.lower() not in suffixes:
        raise InputError(f"{path}: must end in {' or '.join(suffixes)}")
    if not path.parent.is_dir():
        raise InputError(f"{path}: folder {path.parent} not found")

"""Options of the command line that are keywords of the library's functions, and their values."""

import argparse
import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, get_args, get_origin

import numpy as np

from jointclosure.inputs import UNITS as UNITS_OF_SCANS
from jointclosure.inputs import InputError
from jointclosure.inputs.keywords import documented
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.load import Load
from jointclosure.joint.rocks import ROCKS, KnownRock, matching
from jointclosure.joint.simulation import simulate
from jointclosure.measured.headings import CLOSURE_UNITS, FORCE_UNITS, STRESS_UNITS
from jointclosure.measured.joint_arguments import MeasuredJoint
from jointclosure.parameters import OF_ROCK, USUAL, Choices, Effects, Numerics, Rock, check_usual
from jointclosure.parameters.units import in_unit, to_si, unit_meant
from jointclosure.storage.folders import check_record
from jointclosure.uncertainty.scanned_joint import close
from jointclosure.walls.jrc import RELATIONS
from jointclosure.walls.registration import registered
from jointclosure.walls.registration_options import ORIENTATIONS, SHIFTS, SPIKES
from jointclosure.walls.synthesis import NORMALISATIONS, RULES

UNITS = (
    {name: about.unit for name, about in OF_ROCK.items()}
    | {name: "um" for name in Numerics._fields if name.endswith("_step")}
    | dict.fromkeys(("max_normal_stress", "seating_stress", "snapshots", "at", "strengths"), "MPa")
    | dict.fromkeys(("spacing", "scan_spacing", "largest_radius"), "mm")
    | dict.fromkeys(("roll_off", "mismatch_wavelength", "size"), "mm")
    | dict.fromkeys(("joint_length", "lab_length"), "mm")
    | dict.fromkeys(("shifts", "crushed_strength_ratios"), "1")
)
"""Units of the values of options, by keyword; other options have no unit."""
_NAMES = {
    "max_normal_stress": ("--stress", "--max-normal-stress"),
    "seating_stress": ("--seating", "--seating-stress"),
    "compressive_strength": ("--strength", "--compressive-strength"),
    "shape": ("--cells",),
}
"""Names of options, by keyword, where they are not only that of the keyword."""
_CHOICES: dict[str, Iterable[str]] = {
    "units": UNITS_OF_SCANS,
    "orientation": ORIENTATIONS,
    "shift": SHIFTS,
    "spikes": SPIKES,
    "stress_unit": tuple(STRESS_UNITS | FORCE_UNITS),
    "closure_unit": tuple(CLOSURE_UNITS),
    "jrc_relation": tuple(RELATIONS),
    "normalise": NORMALISATIONS,
    "rule": RULES,
}
PICTURES = (".png", ".pdf", ".svg")
SCANS, PLACES = ("units", "scan_spacing", "variable"), ("orientation", "shift", "spikes")
"""Keywords of `read_scan`, and keywords of `registered`. The spacing of `registered` is not among
them, as it is a keyword of `Conditions` too."""


def names_of(keyword: str) -> tuple[str, ...]:
    """Return the names of the option for a keyword, a short one first."""
    return _NAMES.get(keyword) or (f"--{keyword.replace('_', '-')}",)


def add_keywords(
    group: argparse._ActionsContainer,
    function: Callable,
    *names: str,
    usual: Mapping[str, Any] = {},
    **changes: dict,
) -> None:
    """Declare keywords of a function as options.

    The help of an option is the first sentence on its keyword in the function's docstring.
    An option that is not given is left out of the parsed arguments, so that the function's default
    holds. The help names this default, or that in ``usual``. ``changes`` are arguments of
    ``add_argument`` by keyword, which replace those made here; their keywords are declared too.
    """
    texts = documented(function)
    signature = inspect.signature(function).parameters
    for name in (*names, *changes):
        change = changes.get(name, {})
        parameter = signature[name]
        text = texts[name].partition(". ")[0].removesuffix(".")
        text = text.replace("%", "%%").replace("None", "none")
        default = change.get("default", usual.get(name, parameter.default))
        about: dict[str, Any] = {"dest": name, "default": argparse.SUPPRESS}
        if isinstance(default, bool):
            about["default"] = default
        elif default not in (None, (), inspect.Parameter.empty):
            unit = UNITS.get(name, "")
            several = isinstance(default, tuple) and ",".join(map(str, default))
            shown = several or (f"{in_unit(default, unit)} {unit}" if unit else default)
            text += f" (default {shown:g})" if isinstance(shown, float) else f" (default {shown})"
        form = {} if "choices" in change else _form(name, parameter.annotation)
        group.add_argument(*names_of(name), **{"help": text} | about | form | change)


def _form(name: str, hint: Any) -> dict[str, Any]:
    """Return the arguments of ``add_argument`` for a keyword, by the ``hint`` of its type."""
    types = get_args(hint)[:1] if get_origin(hint) is Annotated else (hint,)
    types = get_args(hint) if get_origin(hint) is UnionType else types
    kinds = {get_origin(kind) or kind for kind in types}
    several = kinds & {Sequence, tuple}
    unit = UNITS.get(name, "1")
    if hint is bool:
        return {"action": argparse.BooleanOptionalAction if name == "replay" else "store_true"}
    if name == "shape":
        return {"type": partial(read, _cells), "metavar": "N"}
    if name in _CHOICES or Literal in kinds:
        allowed = list(_CHOICES.get(name, get_args(hint)))
        for_each = {"type": one_or_two, "metavar": f"{'|'.join(allowed)},..."}
        return for_each if several else {"choices": allowed}
    if int in kinds:
        return {"type": int, "metavar": "N"}
    if name not in UNITS and float not in kinds:
        return {}
    kind = partial(read, numbers, name, bool(several), float in kinds, type(None) in kinds)
    metavar = "NUMBER" if unit == "1" else unit
    return {"type": kind, "metavar": f"{metavar},..." if several else metavar}


def read(check: Callable, *words: Any) -> Any:
    """Return the value ``check(*words)`` of an option; turn `InputError` into argparse's error."""
    try:
        return check(*words)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _cells(text: str) -> tuple[int, int]:
    """Return the numbers of cells (y, x) that a text states, such as "100" or "200x100" (x by y).

    Raise `InputError` for other texts.
    """
    parts = text.lower().split("x")
    if len(parts) > 2 or not all(part.isdigit() for part in parts):
        raise InputError(f"{text!r}: must be a number, or two such as 200x100")
    return int(parts[-1]), int(parts[0])


def one_or_two(text: str) -> str | tuple[str, ...]:
    """Return the text of an option for both walls; a tuple of its words if it has commas.

    Two words are for the upper and for the lower wall.
    """
    words = tuple(text.split(","))
    return words if words[1:] else text


def numbers(keyword: str, several: bool, single: bool, none: bool, text: str) -> Any:
    """Return the numbers [SI] in the text of an option, which are in the unit of its keyword.

    It is a tuple of floats. ``several`` is whether the text may have numbers with commas between
    them. If ``single``, one number alone is returned as a float. If ``none``, the text may be
    "none", for which None is returned. Raise `InputError` for other texts.
    """
    if none and text == "none":
        return None
    unit = UNITS.get(keyword, "1")
    parts = text.split(",") if several else [text]
    key = keyword if unit == "1" else f"{keyword}_{unit}"
    try:
        values = [float(part) for part in parts]
    except ValueError:
        what = "numbers with commas between them" if several else "a number"
        raise InputError(f"{text!r}: must be {what}") from None
    ((_, values),) = to_si({key: values}).items()
    return values[0] if single and len(values) == 1 else tuple(values)


def writable(suffixes: tuple[str, ...], text: str | Path) -> Path:
    """Return ``text`` as the path of a result: a file with one of the ``suffixes``, or a folder.

    It is that of a folder if there are no suffixes. Their case is ignored. Nothing is created or
    written. Raise `InputError` if the suffix is another, the parent folder is missing, a file is in
    the place of the folder, or the record of the folder cannot be read. Permissions are not
    checked.
    """
    path = Path(text)
    if suffixes and path.suffix.lower() not in suffixes:
        raise InputError(f"{path}: must end in {' or '.join(suffixes)}")
    if not suffixes and path.exists() and not path.is_dir():
        raise InputError(f"{path}: is a file, must be a folder")
    if not path.parent.is_dir():
        raise InputError(f"{path}: folder {path.parent} not found")
    if not suffixes:
        check_record(path)
    return path


def add_file_option(
    group: argparse._ActionsContainer,
    option: str,
    text: str,
    *suffixes: str,
    others: Sequence[str] = (),
    **changes: Any,
) -> None:
    """Declare an option for the path of a file of results, or of their folder.

    The file ends in one of the ``suffixes``; without any it is a folder. `writable` checks the
    path. ``text`` is the help, ``others`` are further names of the option, and ``changes`` are
    arguments of `add_argument`.
    """
    form = {"type": partial(read, writable, suffixes)} | changes
    metavar = f"FILE{suffixes[0]}" if suffixes else "FOLDER"
    group.add_argument(option, *others, help=text, metavar=metavar, **form)


def add_walls(command: argparse.ArgumentParser) -> None:
    """Declare the arguments for the scans of both walls, and the options of their registration."""
    for wall in ("upper", "lower"):
        what = "x.txt,y.txt,z.txt for matrices in three files; or flat"
        command.add_argument(wall, help=f"scan of the {wall} wall; {what}")
    add_keywords(command.add_argument_group("scans"), close, *SCANS)
    add_keywords(command.add_argument_group("joint"), registered, "spacing", *PLACES)


def add_conditions(
    command: argparse.ArgumentParser, usual: Numerics, load: bool = True, states: bool = True
) -> None:
    """Declare the options of the rock, the load, stored states, the model and the numerics.

    Without ``load`` there are no options of load and flow, without ``states`` none of snapshots,
    named stresses, laws and animation. ``usual`` are the numerics that the help names as defaults.
    """
    rock = command.add_argument_group("rock")
    rock.add_argument("--rock", metavar="NAME", help=f"one of {', '.join(ROCKS)}", choices=ROCKS,
                      type=lambda name: matching(name, ROCKS) or name)  # fmt: skip
    for name, about in OF_ROCK.items():
        form = _form(name, float) | {"dest": name, "default": argparse.SUPPRESS}
        rock.add_argument(*names_of(name), help=f"{about.long_name} {about.symbol}", **form)
    if load:
        loads = command.add_argument_group("load")
        add_keywords(loads, Conditions, "max_normal_stress", "cycles", "seating_stress")
    if load and states:
        add_keywords(loads, simulate, snapshots={"default": ()})
        add_keywords(loads, close, at={"default": ()})
        law = command.add_argument_group("law of Barton and Bandis")
        add_keywords(law, close, "joint_length", "lab_length")
        add_file_option(loads, "--animation", "animation of the closure", ".gif")
    model = command.add_argument_group("model")
    what = f"effects to leave out, of {', '.join(Effects._fields)}"
    model.add_argument("--without", nargs="+", action="extend", choices=Effects._fields, default=[],
                       metavar="EFFECT", help=what)  # fmt: skip
    add_keywords(model, Conditions, *(("flow", "unusual_values")[not states :] if load else ()))
    add_keywords(model, Choices, *Choices._fields)
    numerics = command.add_argument_group("numerics")
    add_keywords(numerics, Numerics, *Numerics._fields, usual=usual._asdict())


def add_measured(
    command: argparse.ArgumentParser, usual: Numerics, title: str, function: Callable, *names: str
) -> None:
    """Declare the arguments for a measured curve and for joints that are compared with it.

    ``names`` are keywords of ``function`` in a group with a ``title``; ``usual`` are the numerics
    that the help names as defaults.
    """
    command.add_argument("curve", type=Path, help="CSV of the measured closure curve")
    add_keywords(
        command.add_argument_group("curve"), MeasuredJoint, "seating_stress", "stress_unit",
        "closure_unit",
        area={"type": float, "metavar": "mm2"},
        columns={"type": lambda text: text.split(","), "metavar": "STRESS,CLOSURE[,CYCLE]"},
        closure_error={"type": float, "metavar": "%", "default": 2.0},
    )  # fmt: skip
    add_keywords(command.add_argument_group(title), function, *names)
    joint = command.add_argument_group("joint")
    scans = {"nargs": 2, "metavar": ("UPPER", "LOWER")}
    add_keywords(joint, MeasuredJoint, "units", "orientation", scans=scans)
    add_keywords(joint.add_mutually_exclusive_group(), MeasuredJoint, "size", "shape")
    add_keywords(joint, MeasuredJoint, "jrc", "spacing", "hurst", "roll_off", "surfaces", "seed")
    add_conditions(command, usual, load=False)


def add_export_cycle(group: argparse._ArgumentGroup) -> None:
    """Declare the option for the cycle whose loading gives the constants for other programs."""
    what = (
        "cycle of whose loading the constants for other programs and tables for GEOS are, counted "
        "from 1 (default 1, the first loading)"
    )
    group.add_argument("--export-cycle", type=int, default=1, metavar="N", help=what)


def check_export_cycle(cycle: int, load: Load) -> None:
    """Raise `InputError` if the cycle of --export-cycle is not one of the load."""
    cycles = len(load.load_cycles)
    if not 1 <= cycle <= cycles:
        raise InputError(f"--export-cycle {cycle}: must be a cycle of the load, 1 to {cycles}")


def refuse(problems: Sequence[str]) -> None:
    """Raise one `InputError` that lists all problems, if there are any."""
    if problems:
        raise InputError("; ".join(problems))


def unusual_options(arguments: argparse.Namespace) -> list[str]:
    """Return a sentence for each option with a value that is unusual for rock, in its unit.

    There is none with --unusual-values, or for commands that do not have this option.
    """
    if getattr(arguments, "unusual_values", True):
        return []
    problems = []
    for name, stated in given(arguments, USUAL).items():
        unit = UNITS.get(name, "1")
        for value in np.atleast_1d([] if stated is None else stated).tolist():
            if name == "max_normal_stress" and value == 0.0:  # a load may go back to 0
                continue
            try:
                check_usual((), **{name: value})
            except InputError:
                low, high = (in_unit(end, unit) for end in USUAL[name][:2])
                number = in_unit(value, unit)
                if value < 0.0:
                    problems.append(f"{names_of(name)[0]} {number:g}: must be positive")
                    continue
                problems.append(
                    f"{names_of(name)[0]} {number:g}: not usual of rock ({low:g} to {high:g} "
                    f"{unit}); {unit_meant(number, low, high, unit)} --unusual-values takes it as "
                    "it is"
                )
    return problems


def given(arguments: argparse.Namespace, names: Iterable[str]) -> dict[str, Any]:
    """Return those of the named arguments that were given on the command line, by name."""
    return {name: getattr(arguments, name) for name in names if hasattr(arguments, name)}


def keywords(
    arguments: argparse.Namespace, function: Callable, usual: Numerics, *needed: str
) -> tuple[KnownRock, dict[str, Any]]:
    """Return the rock that options state, and the values [SI] of a function's keywords, by name.

    Keywords are those given, those of the rock, effects, choices and numerics, and the ``needed``
    ones, which a named rock may give. Numerics that are not given have the ``usual`` values, or
    their defaults if the rule of breakage is given. Raise one `InputError` that lists all options
    whose values are unusual, and all properties and needed keywords that are neither given nor
    those of a named rock.
    """
    problems = unusual_options(arguments)
    known = ROCKS.get(arguments.rock)
    stated = given(arguments, OF_ROCK)
    required = () if known else [name for name in OF_ROCK if name not in Rock._field_defaults]
    missing = [
        names_of(name)[0]
        for name in (*required, *needed)
        if getattr(known, name, None) is None and not hasattr(arguments, name)
    ]
    if missing:
        where = f"--rock {arguments.rock}" if known else "without --rock (such as --rock granite)"
        problems.append(f"{where}: {', '.join(missing)} must be given")
    refuse(problems)
    intact = known.intact._replace(**stated) if known else Rock(**stated)
    rock = (known or KnownRock("Rock", intact))._replace(intact=intact)
    rock = rock._replace(**given(arguments, needed))
    stated = given(arguments, Numerics._fields)
    numerics = (Numerics() if "breakage" in stated else usual)._replace(**stated)
    return rock, given(arguments, inspect.signature(function).parameters) | {
        **{name: getattr(rock, name) for name in needed},
        "rock": rock.intact,
        "effects": Effects()._replace(**dict.fromkeys(arguments.without, False)),
        "choices": Choices(**given(arguments, Choices._fields)),
        "numerics": numerics,
    }


def measured_joint(
    arguments: argparse.Namespace, function: Callable, usual: Numerics
) -> dict[str, Any]:
    """Return the values [SI] of a function's keywords for a measured curve, by name.

    A JRC is needed unless walls are scanned. Raise `InputError` as `keywords`.
    """
    needed = () if hasattr(arguments, "scans") else ("jrc",)
    _, stated = keywords(arguments, function, usual, *needed)
    if "area" in stated:
        stated["area"] *= 1e-6
    return stated | {"closure_error": 1e-2 * arguments.closure_error}

"""What a configuration says of measured walls (`rocks.<rock>.walls`), checked."""

from collections.abc import Iterator
from pathlib import Path

from jointclosure.config.units import to_si
from jointclosure.inputs import InputError
from jointclosure.surface.measured import LARGEST_FILLED_SHARE
from jointclosure.surface.measured_pairs import PARTNERS

SIDES = ("upper", "lower")


def wall_files(walls: dict) -> dict[str, str]:
    """Files of the measured walls by "upper" and "lower"."""
    return {side: walls[side] for side in SIDES if walls[side] not in PARTNERS}


def wall_settings(walls: dict) -> dict:
    """Settings of a rock's walls in SI, with what was left out."""
    usual = {
        "units": None,
        "spacing": None,
        "variable": None,
        "missing": "refuse",
        "largest_filled_share": LARGEST_FILLED_SHARE,
        "inverted": [],
    }
    return usual | to_si(walls)


def wall_problems(configuration: dict, name: str) -> Iterator[str]:
    """What is wrong with the roughness of a rock, one line each."""
    rock = configuration["rocks"][name]
    walls, where = rock.get("walls"), f"rocks.{name}"
    if not walls:
        if rock.get("jrc") is None:
            yield f"{where}: lacks jrc, or walls (measured ones)"
        return
    if rock.get("jrc") is not None:
        yield (
            f"{where}.jrc = {rock['jrc']!r}: not with walls, whose roughness is as measured; leave "
            "it out, or set it to null where it is another file's"
        )
    if rock["levels"].get("jrc") is not None:
        yield (
            f"{where}.levels.jrc = {rock['levels']['jrc']!r}: measured walls have no JRC to be "
            "varied; leave it out, or set it to null where it is another file's"
        )
    files = wall_files(walls)
    if not files:
        words = f"upper = {walls['upper']!r}, lower = {walls['lower']!r}"
        yield f"{where}.walls: {words}: at least one must be a file"
    for side in walls.get("inverted", []):
        if side not in files:
            yield f"{where}.walls.inverted = {walls['inverted']!r}: {side} is not a file"
    effects = rock.get("effects") or configuration["effects"]
    if effects == "auto" or configuration["effects"].get("auto") is not None:
        yield f"effects: auto: not with {where}.walls; its pilot draws walls of given JRC"
    for section in ("accuracy", "ablation"):
        if configuration.get(section):
            yield f"{section}: not with {where}.walls; it draws walls of given JRC"


def check_files(configuration: dict) -> None:
    """Raise `InputError` where a file of the study's walls does not exist."""
    for name in configuration["study"]["rocks"]:
        walls = configuration["rocks"][name].get("walls")
        for side, file in (wall_files(walls) if walls else {}).items():
            if not Path(file).is_file():
                raise InputError(
                    f"rocks.{name}.walls.{side} = {file!r}: there is no such file in {Path.cwd()}; "
                    f"a path (from there, or absolute) or one of {', '.join(PARTNERS)}"
                )

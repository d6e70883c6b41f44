"""What a configuration says of scanned walls (`rocks.<rock>.walls`), checked."""

from collections.abc import Iterator
from pathlib import Path

from jointclosure.config.typed import SIDES, Configuration, Walls
from jointclosure.inputs import InputError
from jointclosure.surface.measured_pairs import PARTNERS

_OF_MADE_WALLS = (
    "accuracy",
    "ablation",
    "readings",
    "mismatch",
    "misalignment",
    "size",
    "global_sensitivity",
)
"""Sections of studies whose walls are made of a JRC."""


def wall_files(walls: Walls) -> dict[str, str]:
    """Files of scanned walls by "upper" and "lower"."""
    return {side: getattr(walls, side) for side in SIDES if getattr(walls, side) not in PARTNERS}


def wall_problems(keys: dict, name: str) -> Iterator[str]:
    """What is wrong with the roughness of a rock of complete keys, one line each."""
    rock = keys["rocks"][name]
    walls, jrc, levels = rock["walls"], rock["jrc"], rock["levels"]["jrc"]
    where = f"rocks.{name}"
    if not walls:
        if jrc is None:
            yield f"{where}: lacks jrc, or walls (scanned ones)"
        return
    if jrc is not None:
        yield (
            f"{where}.jrc = {jrc:g}: not with walls, whose roughness is as measured; leave "
            "it out, or set it to null where it is another file's"
        )
    if levels is not None:
        yield (
            f"{where}.levels.jrc = [{', '.join(f'{level:g}' for level in levels)}]: scanned walls "
            "have no JRC to be varied; leave it out, or set it to null where it is another file's"
        )
    files = [side for side in SIDES if walls[side] not in PARTNERS]
    if not files:
        words = f"upper = {walls['upper']!r}, lower = {walls['lower']!r}"
        yield f"{where}.walls: {words}: at least one must be a file"
    for side in walls["inverted"]:
        if side not in files:
            yield f"{where}.walls.inverted = {walls['inverted']!r}: {side} is not a file"
    yield from _registration_problems(walls, files, f"{where}.walls")
    if keys["effects"]["auto"] is not None:
        yield f"effects: auto: not with {where}.walls; its pilot draws walls of given JRC"
    for section in _OF_MADE_WALLS:
        if keys[section]:
            yield f"{section}: not with {where}.walls; it draws walls of given JRC"


def _registration_problems(walls: dict, files: list[str], where: str) -> Iterator[str]:
    """What is wrong with how two scans are brought together, one line each."""
    if not walls["bring_together"]:
        for key in ("orientation", "shift"):
            if walls[key] is not None:
                yield f"{where}.{key} = {walls[key]}: only with bring_together: true"
        return
    if len(files) < 2:
        yield f"{where}.bring_together = true: needs two files, upper and lower"
    if walls["inverted"]:
        yield (
            f"{where}.inverted = {walls['inverted']!r}: not with bring_together, which finds how "
            "the upper file lies; say it by orientation"
        )
    if walls["missing"] != "refuse":
        yield (
            f"{where}.missing = {walls['missing']}: not with bring_together, which takes the "
            "largest rectangle without holes, and fills those up to largest_filled_share"
        )


def check_files(configuration: Configuration) -> None:
    """Raise `InputError` where a file of the study's walls does not exist."""
    for name, rock in configuration.rocks.items():
        for side, file in (wall_files(rock.walls) if rock.walls else {}).items():
            if not Path(file).is_file():
                raise InputError(
                    f"rocks.{name}.walls.{side} = {file!r}: there is no such file in {Path.cwd()}; "
                    f"a path (from there, or absolute) or one of {', '.join(PARTNERS)}"
                )

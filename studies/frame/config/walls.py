"""Checks of the scanned walls of a configuration (`rocks.<rock>.walls`)."""

from collections.abc import Iterator
from pathlib import Path

from jointclosure.engine.settings import SIDES, Walls
from jointclosure.inputs import InputError
from jointclosure.walls.measured import FLAT
from jointclosure.walls.scans import files_of
from studies.frame.config.keys.configuration import SECTIONS
from studies.frame.config.typed import Configuration
from studies.frame.ensemble.windows import PARTNERS


def wall_files(walls: Walls) -> dict[str, str]:
    """Return the scans of walls by "upper" and "lower": a file, or three with commas."""
    return {side: getattr(walls, side) for side in SIDES if getattr(walls, side) not in PARTNERS}


def wall_problems(keys: dict, name: str) -> Iterator[str]:
    """Generate problems of the roughness of a rock in complete keys, one line each."""
    rock = keys["rocks"][name]
    walls, jrc, levels = rock["walls"], rock["jrc"], rock["levels"]["jrc"]
    where = f"rocks.{name}"
    if not walls:
        if jrc is None:
            yield f"{where}: must have jrc, or walls (scanned)"
        return
    if jrc is not None:
        yield (
            f"{where}.jrc = {jrc:g}: must be left out with walls, whose roughness is measured, or "
            "null if another file sets it"
        )
    if levels is not None:
        yield (
            f"{where}.levels.jrc = [{', '.join(f'{level:g}' for level in levels)}]: must be left "
            "out for scanned walls, which have no JRC, or null if another file sets it"
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
    for section in SECTIONS.values():
        if keys[section]:
            yield f"{section}: not with {where}.walls; it draws walls of given JRC"


def _registration_problems(walls: dict, files: list[str], where: str) -> Iterator[str]:
    """Generate problems of the registration of two scans, one line each."""
    if not walls["bring_together"]:
        for key in ("orientation", "shift"):
            if walls[key] is not None:
                yield f"{where}.{key} = {walls[key]}: only with bring_together: true"
        return
    if len(files) < 2 and FLAT not in (walls["upper"], walls["lower"]):
        yield f"{where}.bring_together = true: needs two files, upper and lower"
    if walls["inverted"]:
        yield (
            f"{where}.inverted = {walls['inverted']!r}: not with bring_together, which determines "
            "the direction of the upper file; use orientation instead"
        )
    if walls["missing"] != "refuse":
        yield (
            f"{where}.missing = {walls['missing']}: not with bring_together, which uses the "
            "largest rectangle without holes, after filling up to largest_filled_share"
        )


def check_files(configuration: Configuration) -> None:
    """Raise `InputError` if a file of the study's walls does not exist."""
    for name, rock in configuration.rocks.items():
        for side, file in (wall_files(rock.walls) if rock.walls else {}).items():
            if not all(part.is_file() for part in files_of(file)):
                raise InputError(
                    f"rocks.{name}.walls.{side} = {file!r}: not found in {Path.cwd()}; must be "
                    f"a path (from there, or absolute) or one of {', '.join(PARTNERS)}"
                )

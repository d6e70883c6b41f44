"""Rocks of a configuration: their properties, levels, scanned walls and measured curves."""

import itertools
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, Field, create_model

from jointclosure.measured.headings import CLOSURE_UNITS, FORCE_UNITS, STRESS_UNITS
from jointclosure.parameters import OF_ROCK, PROPERTIES, Effects, Rock, key_of
from jointclosure.parameters.units import in_unit
from jointclosure.walls.gridding import FLAT
from jointclosure.walls.registration_options import ORIENTATIONS, SHIFTS
from jointclosure.walls.scans import files_of
from studies.frame.keys import OR_NULL, Distinct, Jrc, Section, Several, Text, entry, made_of
from studies.frame.settings import SIDES
from studies.frame.yaml_files import refuse

PARTNERS = ("rotated", "mirrored", "synthetic", FLAT)
"""Partners of a single scanned wall: the wall itself, turned by 180 degrees in its plane or
mirrored in x; an independent synthetic wall with its slope and Hurst exponent; or a flat wall."""
Levels: Any = create_model(  # type: ignore[call-overload]
    "Levels",
    __base__=Section,
    __doc__="For each parameter to be varied, its values besides the rock's own, ascending.",
    **{
        name: (
            Several[Annotated[float, Field(**about.bounds)]] | None,
            entry(
                "At least two values, strictly ascending; with the rock's own they make three "
                "levels or more; null for none.",
                None,
                alias=key_of(name),
                min_length=2,
            ),
        )
        for name, about in PROPERTIES.items()
    },
)
EffectKeys: Any = create_model(  # type: ignore[call-overload]
    "EffectKeys",
    __base__=Section,
    __doc__="Effects of this rock's cases, over those of the study.",
    **{name: (bool | None, entry("As in effects.", None)) for name in Effects._fields},
)


def intact_keys(base: type[BaseModel]) -> Any:
    """Return a model with the keys of ``base``, and a key for each property of an intact rock."""
    fields: dict[str, Any] = {}
    for name, about in OF_ROCK.items():
        unit = "" if about.unit == "1" else f" [{about.unit}]"
        default = Rock._field_defaults.get(name, ...)
        usual = "." if default is ... else f"; {in_unit(default, about.unit):g} unless given."
        described = f"{about.title} {about.symbol} of the intact rock{unit}{usual}"
        fields[name] = (float, entry(described, default, alias=key_of(name), **about.bounds))
    return create_model("IntactKeys", __base__=base, **fields)


_WALL = (
    "A file, relative to where the study is run (or absolute), or three with commas (x.txt,y.txt,"
    "z.txt); or, where the other wall is a file: rotated (that wall by 180 degrees), mirrored, "
    "synthetic (an independent wall of its slope and Hurst exponent), or flat."
)


class ScannedWalls(Section):
    """Scanned walls instead of a JRC, docs/two_scans.md."""

    upper: Text = entry(_WALL)
    lower: Text = entry(_WALL)
    units: Literal["m", "mm", "um", "nm", "inch"] | None = entry(
        "Of heights and distances, where the file does not say them.", None
    )
    spacing: float | None = entry(
        "Of a grid, where its file does not say it [mm].", None, alias="spacing_mm", gt=0
    )
    variable: str | None = entry(
        "Name of the array in an npz or netCDF file, or of a channel; needed where there are "
        "several.",
        None,
    )
    missing: Literal["refuse", "avoid", "nearest", "linear"] = entry(
        "Cells without a height: refuse (an error, the default), avoid (joints are cut where none "
        "is missing), nearest, linear (they are filled).",
        "refuse",
    )
    largest_filled_share: float = entry(
        "Share of the cells that may be filled, or taken out of contact (bring_together); 0.05 "
        "unless given.",
        0.05,
        ge=0,
        le=1,
    )
    inverted: Distinct[Literal["upper", "lower"]] = entry(
        "Walls (upper, lower) whose heights point into the rock, as those of an upper wall in the "
        "lower one's frame; none unless given.",
        (),
    )
    bring_together: bool = entry(
        "Whether two files are brought together first: orientation checked, spikes cut, the common "
        "plane removed, the overlap found; false unless given: they are taken cell by cell.",
        False,
    )
    orientation: Literal[tuple(ORIENTATIONS)] | None = entry(  # type: ignore[valid-type]
        "Of the upper file, where walls are brought together; null: the one that fits, if it is "
        "clear.",
        None,
    )
    shift: Literal[SHIFTS] | None = entry(  # type: ignore[valid-type]
        "Where walls are brought together: scanned (left where they were) or mated (the upper one "
        "moved to the best fit); null: mated.",
        None,
    )
    spikes: Literal["keep", "cut"] = entry(
        "Points that stand out from all but one of their neighbours, where walls are brought "
        "together: cut unless given.",
        "cut",
    )


class MeasuredFile(Section):
    """A measured curve of this rock's joint, drawn in closure_since_seating with its best fit."""

    file: Text = entry(
        "CSV file with columns stress, closure (units in their names, as stress_MPa,closure_mm) "
        "and cycle; a path from the project's folder."
    )
    stress_unit: Literal[tuple(STRESS_UNITS | FORCE_UNITS)] | None = entry(  # type: ignore[valid-type]
        "Unit of the stresses, or of forces, where the column's heading has none.", None
    )
    closure_unit: Literal[tuple(CLOSURE_UNITS)] | None = entry(  # type: ignore[valid-type]
        "Unit of the closures, where the column's heading has none.", None
    )
    area_mm2: float | None = entry(
        "Loaded area [mm2] of the measured joint, by which forces become stresses; only for a "
        "column of forces.",
        None,
        gt=0,
    )


class StudyRock(intact_keys(Section)):  # type: ignore[misc]
    """A rock; a study's own file may add some."""

    title: Annotated[Text, OR_NULL] = entry(
        "Name in tables and figures, as it is written; its key with a capital unless given.", ""
    )
    jrc: Annotated[Jrc, OR_NULL, AfterValidator(lambda jrc: math.nan if jrc is None else jrc)] = (
        entry("Joint roughness coefficient; left out (or null) where `walls` are given.", math.nan)
    )
    max_normal_stress: float = entry(
        "Maximum nominal normal stress of every cycle [MPa].", alias="max_normal_stress_MPa", gt=0
    )
    max_normal_stress_is_assumed: bool = entry(
        "Whether that stress is an assumption, to be flagged where it is shown; false unless "
        "given.",
        False,
    )
    # None stands for the study's effect, until the whole configuration is read
    effects: Annotated[Effects, made_of(EffectKeys)] = Field(
        Effects._make([None] * len(Effects._fields))
    )
    other_levels: Levels = Field(Levels(), alias="levels")
    walls: ScannedWalls | None = None
    measured: MeasuredFile | None = None

    @property
    def intact(self) -> Rock:
        """Properties of the intact rock."""
        return Rock._make(getattr(self, name) for name in OF_ROCK)

    @property
    def levels(self) -> dict[str, tuple[float, ...]]:
        """Ascending values [SI] of each varied parameter, with the rock's own value among them."""
        return {
            name: tuple(sorted([*others, getattr(self, name)]))
            for name in PROPERTIES
            if (others := getattr(self.other_levels, name)) is not None
        }

    def titled(self, name: str) -> "StudyRock":
        """Return the rock with a title, which is made of its key ``name`` if it has none."""
        return self if self.title else self._replace(title=title_of_key(name))

    def with_effects(self, usual: Effects) -> "StudyRock":
        """Return the rock with every effect stated; effects that it leaves open are the usual."""
        stated = {name: on for name, on in self.effects._asdict().items() if on is not None}
        return self._replace(effects=usual._replace(**stated))

    def problems(self, where: str) -> Iterator[str]:
        """Generate a line for each contradiction between keys of the rock; ``where`` is its key."""
        stress = self.max_normal_stress
        walls = self.walls
        others = self.other_levels.jrc
        stiffness = min(self.levels.get("youngs_modulus", (self.intact.youngs_modulus,)))
        if stress >= stiffness:
            yield (
                f"{where}.max_normal_stress_MPa = {in_unit(stress, 'MPa'):g}: must be below "
                f"Young's modulus, {in_unit(stiffness, 'MPa'):g} MPa"
            )
        if not walls and math.isnan(self.jrc):
            yield f"{where}: must have jrc, or walls (scanned)"
        if walls and not math.isnan(self.jrc):
            yield (
                f"{where}.jrc = {self.jrc:g}: must be left out with walls, whose roughness is "
                "measured, or null if another file sets it"
            )
        if walls and others is not None:
            yield (
                f"{where}.levels.jrc = [{', '.join(f'{jrc:g}' for jrc in others)}]: must be left "
                "out for scanned walls, which have no JRC, or null if another file sets it"
            )
        if walls:
            yield from _wall_problems(walls, f"{where}.walls")
        for parameter in self.levels:
            levels = getattr(self.other_levels, parameter)
            base = getattr(self, parameter)
            shown = [f"{in_unit(level, PROPERTIES[parameter].unit):g}" for level in (*levels, base)]
            stated = f"{where}.levels.{key_of(parameter)} = [{', '.join(shown[:-1])}]"
            ascends = all(later > earlier for earlier, later in itertools.pairwise(levels))
            if not ascends and not math.isnan(base):
                yield f"{stated}: must be strictly ascending"
            if base in levels:
                rocks_own = f"must not contain the value of the rock, {shown[-1]}, always a level"
                yield f"{stated}: {rocks_own}"


def _wall_problems(walls: ScannedWalls, where: str) -> Iterator[str]:
    """Generate a line for each contradiction between keys of scanned walls at the key ``where``."""
    files = wall_files(walls)
    inverted = f"{where}.inverted = {list(walls.inverted)!r}"
    if not files:
        words = f"upper = {walls.upper!r}, lower = {walls.lower!r}"
        yield f"{where}: {words}: at least one must be a file"
    yield from (f"{inverted}: {side} is not a file" for side in walls.inverted if side not in files)
    if not walls.bring_together:
        for name in ("orientation", "shift"):
            if getattr(walls, name) is not None:
                yield f"{where}.{name} = {getattr(walls, name)}: only with bring_together: true"
        return
    if len(files) < 2 and FLAT not in (walls.upper, walls.lower):
        yield f"{where}.bring_together = true: needs two files, upper and lower"
    if walls.inverted:
        yield (
            f"{inverted}: not with bring_together, which determines the direction of the upper "
            "file; use orientation instead"
        )
    if walls.missing != "refuse":
        yield (
            f"{where}.missing = {walls.missing}: not with bring_together, which uses the "
            "largest rectangle without holes, after filling up to largest_filled_share"
        )


def title_of_key(name: str) -> str:
    """Return a title made of the key of a rock: "My rock" for "my_rock"."""
    words = name.replace("_", " ")
    return words[0].upper() + words[1:]


def wall_files(walls: ScannedWalls) -> dict[str, str]:
    """Return the scan files by side ("upper", "lower"), without walls that are no file.

    Each is the path of a file, or three paths with commas between them.
    """
    return {side: getattr(walls, side) for side in SIDES if getattr(walls, side) not in PARTNERS}


def check_files(rocks: dict[str, StudyRock]) -> None:
    """Raise `ConfigurationError` that lists all missing files of scans and of measured curves."""
    refuse(_missing_files(rocks))


def _missing_files(rocks: dict[str, StudyRock]) -> Iterator[str]:
    """Generate a line for each missing file: its key, its path, and what is allowed."""
    here = f"not found in {Path.cwd()}; must be the path of a file (from there, or absolute)"
    for name, rock in rocks.items():
        for side, file in (wall_files(rock.walls) if rock.walls else {}).items():
            if not all(part.is_file() for part in files_of(file)):
                words = f"{here} or one of {', '.join(PARTNERS)}"
                yield f"rocks.{name}.walls.{side} = {file!r}: {words}"
        if rock.measured and not Path(rock.measured.file).is_file():
            yield f"rocks.{name}.measured.file = {rock.measured.file!r}: {here}"

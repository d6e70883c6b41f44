"""Keys of a rock: properties, levels, scanned walls, a measured curve."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, create_model

from jointclosure.parameters import OF_ROCK, PROPERTIES, Effects, Rock, key_of
from jointclosure.parameters.units import in_unit
from jointclosure.walls.registration import ORIENTATIONS, SHIFTS
from studies.frame.config.keys.entries import Keys, Text, entry

LevelKeys = create_model(
    "LevelKeys",
    __base__=Keys,
    __doc__="For each parameter to be varied, its values besides the rock's own, ascending.",
    **{
        key_of(name): (
            list[Annotated[float, Field(**about.bounds)]] | None,
            entry(
                "At least two values, strictly ascending; with the rock's own they make three "
                "levels or more; null for none.",
                None,
                min_length=2,
            ),
        )
        for name, about in PROPERTIES.items()
    },
)


RockEffectKeys = create_model(
    "RockEffectKeys",
    __base__=Keys,
    __doc__="Effects of this rock's cases, over those of the study.",
    **{name: (bool | None, entry("As in effects.", None)) for name in Effects._fields},
)


_WALL = entry(
    "A file, relative to where the study is run (or absolute), or three with commas (x.txt,y.txt,"
    "z.txt); or, where the other wall is a file: rotated (that wall, turned by 180 degrees), "
    "mirrored, synthetic (a wall of its slope and Hurst exponent, independent of it), or flat."
)


class WallKeys(Keys):
    """Scanned walls instead of a JRC, docs/two_scans.md."""

    upper: Text = _WALL
    lower: Text = _WALL
    units: Literal["m", "mm", "um", "nm"] | None = entry(
        "Of heights and distances, where the file does not say them.", None
    )
    spacing_mm: float | None = entry("Of a grid, where its file does not say it [mm].", None, gt=0)
    variable: str | None = entry(
        "Name of the array in an npz or netCDF file, or of a channel; needed where there are "
        "several.",
        None,
    )
    missing: Literal["refuse", "avoid", "nearest", "linear"] = entry(
        "What is done about cells without a height: refuse (an error, the default); avoid (joints "
        "are cut where none is missing); nearest, linear (filled).",
        "refuse",
    )
    largest_filled_share: float = entry(
        "Share of the cells that may be filled, or taken out of contact (bring_together); 0.05 "
        "unless given.",
        0.05,
        ge=0,
        le=1,
    )
    inverted: list[Literal["upper", "lower"]] = entry(
        "Walls (upper, lower) whose heights in the file point into the rock, as those of an upper "
        "wall in the lower one's frame; none unless given.",
        [],
        json_schema_extra={"uniqueItems": True},
    )
    bring_together: bool = entry(
        "Whether two files are brought together first: orientation checked, spikes cut, the common "
        "plane removed, the overlap found; false unless given: they are taken cell by cell.",
        False,
    )
    orientation: Literal[tuple(ORIENTATIONS)] | None = entry(
        "Of the upper file, where walls are brought together; null: the one that fits, if it is "
        "clear.",
        None,
    )
    shift: Literal[SHIFTS] | None = entry(
        "Where walls are brought together: scanned (left where they were) or mated (the upper one "
        "moved to where they fit best); null: scanned in a common frame, else mated.",
        None,
    )
    spikes: Literal["keep", "cut"] = entry(
        "Points that stand out from all but one of their neighbours, where walls are brought "
        "together: cut unless given.",
        "cut",
    )


class MeasuredKeys(Keys):
    """A measured curve of this rock's joint, drawn in closure_since_seating with its best fit."""

    file: Text = entry(
        "CSV file with columns stress, closure (units in their names, as stress_MPa,closure_mm) "
        "and cycle; a path from the project's folder."
    )
    stress_unit: Literal["Pa", "kPa", "MPa", "GPa"] | None = entry(
        "Unit of the stresses, where the column's name has none.", None
    )
    closure_unit: Literal["m", "mm", "um"] | None = entry(
        "Unit of the closures, where the column's name has none.", None
    )


def intact_keys(base: type[BaseModel]) -> type[BaseModel]:
    """Keys of the properties of an intact rock; one with a default may be left out."""
    keys: dict[str, Any] = {}
    for name, about in OF_ROCK.items():
        unit = "" if about.unit == "1" else f" [{about.unit}]"
        default = Rock._field_defaults.get(name, ...)
        if default is not ...:
            default = float(in_unit(default, about.unit))
        keys[key_of(name)] = (
            float,
            entry(
                f"{about.title} {about.symbol} of the intact rock{unit}"
                + ("." if default is ... else f"; {default:g} unless given."),
                default,
                **about.bounds,
            ),
        )
    return create_model("IntactKeys", __base__=base, **keys)


class _TitledKeys(Keys):
    title: Text = entry("Name in tables and figures.")


class RockKeys(intact_keys(_TitledKeys)):
    """A rock; a study's own file may add some."""

    jrc: float | None = entry(
        "Joint roughness coefficient; left out (or null) where `walls` are given.",
        None,
        **PROPERTIES["jrc"].bounds,
    )
    max_normal_stress_MPa: float = entry(
        "Maximum nominal normal stress of every cycle [MPa].", gt=0
    )
    max_normal_stress_is_assumed: bool = entry(
        "Whether that stress is an assumption, to be flagged where it is shown; false unless "
        "given.",
        False,
    )
    effects: RockEffectKeys = entry(RockEffectKeys.__doc__, RockEffectKeys())
    levels: LevelKeys = entry(LevelKeys.__doc__, LevelKeys())
    walls: WallKeys | None = entry(WallKeys.__doc__, None)
    measured: MeasuredKeys | None = entry(MeasuredKeys.__doc__, None)

"""The model of a whole configuration, in SI once it is read."""

import functools
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Annotated, Self, TypeVar

from pydantic import create_model, model_validator

from jointclosure.engine.settings import Grid, Surface
from jointclosure.inputs import InputError
from jointclosure.parameters import Choices, Numerics
from studies.frame.config.rocks import StudyRock
from studies.frame.config.schema import did_you_mean
from studies.frame.config.section import Made, Name, Section, StudySection, entry
from studies.frame.config.sections import (
    ChoiceKeys,
    GridKeys,
    NumericsKeys,
    Output,
    Statistics,
    Study,
    StudyEffects,
    SurfaceKeys,
)

_Section = TypeVar("_Section", bound=StudySection)


class Configuration(Section):
    """Configuration of a study."""

    study: Study
    rocks: dict[Name, StudyRock] = entry(
        "Rocks by name; a study's own file may add some.", min_length=1
    )
    grid: Annotated[Grid, Made(GridKeys)]
    surface: Annotated[Surface, Made(SurfaceKeys)]
    seating_stress: float = entry(
        "Stress from which seated closures count [MPa]; it changes what is read, never what "
        "happens.",
        alias="seating_stress_MPa",
        ge=0,
    )
    effects: StudyEffects
    flow: bool = entry(
        "Whether hydraulic apertures are found too, by Reynolds' equation at every step "
        "(docs/export.md#flow); it changes nothing else.",
        False,
    )
    choices: Annotated[Choices, Made(ChoiceKeys)]
    numerics: Annotated[Numerics, Made(NumericsKeys)]
    statistics: Statistics
    output: Output

    @model_validator(mode="after")
    def _resolved(self) -> Self:
        """Take the rocks of the study in its order, and what other sections leave open."""
        if unknown := list(_unknown(self.study.rocks, self.rocks)):
            raise ValueError("\n".join(unknown))
        usual = self.effects.acting
        rocks = {name: self.rocks[name].with_effects(usual) for name in self.study.rocks}
        output, numerics = self.output, self.numerics
        if output.largest_stress is None:
            largest = max(rock.max_normal_stress for rock in rocks.values())
            output = output._replace(largest_stress=largest)
        if numerics.idle_interaction is None:
            numerics = numerics._replace(idle_interaction=self.effects.auto or 0.0)
        return self._replace(rocks=rocks, output=output, numerics=numerics)

    @property
    def effects_chosen_to(self) -> float | None:
        """Tolerance by which a pilot chooses effects; None where they are as configured."""
        return self.effects.auto

    def problems_of_walls(self, name: str) -> Iterator[str]:
        """Generate keys of walls that mate in part, in a study that sets these keys itself."""
        surface = self.surface
        given = (surface.mismatch_wavelength, surface.correlation, surface.shift_in_cells)
        if given != (None, 0.0, 0):
            yield (
                f"{name}: the study sets surface.mismatch_wavelength_mm; it, correlation and "
                "shift_in_cells must be null, 0 and 0"
            )

    @property
    def study_sections(self) -> dict[str, StudySection]:
        """Sections of experiments that are given, by name."""
        given = {section.name: getattr(self, section.name, None) for section in sections().values()}
        return {name: section for name, section in given.items() if section is not None}

    def section(self, kind: type[_Section]) -> _Section:
        """Return the section of an experiment; raise `InputError` if it is left out."""
        section = getattr(self, kind.name)
        if section is None:
            raise InputError(f"{kind.name} = null: must be given for this study")
        return section


def _unknown(names: Iterable[str], rocks: Iterable[str]) -> Iterator[str]:
    for name in names:
        if name not in rocks:
            meant = did_you_mean(name, rocks)
            yield f"study.rocks = {name!r}: must be one of rocks ({', '.join(rocks)}){meant}"


@functools.cache
def sections() -> dict[str, type[StudySection]]:
    """Return the sections of experiments by the folder of the experiment."""
    folders = sorted(path.parent.name for path in Path(__file__).parents[2].glob("*/section.py"))
    return {name: import_module(f"studies.{name}.section").SECTION for name in folders}


@functools.cache
def model() -> type[Configuration]:
    """Return the model of a whole configuration, with the sections of all experiments."""
    return create_model(
        "Configuration",
        __base__=Configuration,
        __doc__=Configuration.__doc__,
        **{section.name: (section | None, None) for section in sections().values()},  # type: ignore
    )

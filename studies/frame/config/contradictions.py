"""Contradictions between keys, and values unusual for rock, which no single key can reveal."""

import difflib
import itertools
import math
from collections.abc import Callable, Iterator

from jointclosure.inputs import InputError
from jointclosure.joint.conditions import LARGEST_SEATING
from jointclosure.parameters import USUAL as _OF_ROCK
from jointclosure.parameters import check_choices, check_numerics, check_scene
from jointclosure.parameters.units import in_unit, name_and_unit
from jointclosure.walls.roughness import relation_of
from jointclosure.walls.synthesis import check_mismatch, spectrum_of
from studies.frame.config.keys.configuration import SECTIONS
from studies.frame.config.typed import Configuration, StudyRock
from studies.frame.config.walls import wall_problems

OTHER_TARGETS = {"hard_cases": ""} | SECTIONS
"""Folders of results of other targets, and the section that a study of that name must have."""
USUAL = _OF_ROCK | {"stress": _OF_ROCK["max_normal_stress"]}
"""Least and largest values that are usual, and their unit, by name of a key without its unit."""


def contradictions(keys: dict, typed: Callable[[dict], Configuration]) -> Iterator[str]:
    """Generate contradictions between keys that are each valid, one line each.

    Parameters
    ----------
    keys : dict
    typed : callable
        Returns the typed configuration of keys.
    """
    unknown = list(_unknown_rocks(keys))
    if unknown:
        yield from unknown
        return
    configuration = typed(keys)
    yield from _study_problems(keys)
    if configuration.study.unusual_values == "refuse":
        rocks = {name: keys["rocks"][name] for name in configuration.rocks}
        # check the settings of these studies separately
        checked = dict.fromkeys(("accuracy", "global_sensitivity"))
        yield from _unusual(keys | {"rocks": rocks} | checked, "")
    surface, spacing = configuration.surface, configuration.grid.spacing
    checks: tuple[Callable[[], object], ...] = (
        *(lambda effects=scene: check_scene(effects) for scene in _scenes(keys, configuration)),
        lambda: spectrum_of(surface.hurst, surface.rule, surface.roll_off, spacing),
        lambda: check_mismatch(surface.mismatch_wavelength, surface.correlation),
        lambda: check_choices(configuration.choices, spacing),
        lambda: check_numerics(configuration.numerics),
    )
    for check in checks:
        try:
            check()
        except InputError as error:
            yield str(error)
    share = keys["numerics"]["idle_interaction"]
    if share and not any(rock.effects.interaction for rock in configuration.rocks.values()):
        yield (
            f"numerics.idle_interaction = {share:g}: must be null or 0, because "
            "effects.interaction is false for every rock"
        )
    yield from _mismatch_problems(configuration)
    yield from _size_problems(configuration)
    for name, rock in configuration.rocks.items():
        yield from _rock_problems(name, rock, keys, configuration)


def _unknown_rocks(keys: dict) -> Iterator[str]:
    rocks = keys["rocks"]
    for name in keys["study"]["rocks"]:
        if name not in rocks:
            close = difflib.get_close_matches(name, rocks, n=1)
            meant = f"; did you mean {close[0]}?" if close else ""
            yield f"study.rocks = {name!r}: must be one of rocks ({', '.join(rocks)}){meant}"


def _study_problems(keys: dict) -> Iterator[str]:
    study = keys["study"]
    if len(set(study["rocks"])) < len(study["rocks"]):
        yield f"study.rocks = {study['rocks']!r}: must not have a rock twice"
    surfaces = keys["statistics"]["control_variates"]
    closed = max(study["realizations"], study["pool"] or 0)
    if surfaces is not None and surfaces <= closed:
        yield (
            f"statistics.control_variates = {surfaces}: must be more than the {closed} surfaces of "
            "a case, whose means they adjust (or null: no adjustment)"
        )
    section = OTHER_TARGETS.get(study["name"])
    if section is not None and not (section and keys[section]):
        yield (
            f"study.name = {study['name']!r}: results/{study['name']} belongs to another target; "
            "must be another name"
        )


def _mismatch_problems(configuration: Configuration) -> Iterator[str]:
    design, surface = configuration.mismatch, configuration.surface
    if design is None:
        return
    if 0 not in design.shift_in_cells:
        yield f"mismatch.shift_in_cells = {list(design.shift_in_cells)}: must contain 0"
    given = (surface.mismatch_wavelength, surface.correlation, surface.shift_in_cells)
    if given != (None, 0.0, 0):
        yield (
            "mismatch: the study sets surface.mismatch_wavelength_mm, correlation and "
            "shift_in_cells, which must be null, 0 and 0"
        )


def _size_problems(configuration: Configuration) -> Iterator[str]:
    design, grid = configuration.size, configuration.grid
    if design is None:
        return
    finest, largest = design.spacing[0], design.patch[-1]
    for spacing in design.spacing:
        if not _whole(spacing / finest):
            yield f"size.spacing_mm = {1e3 * spacing:g}: must be a multiple of {1e3 * finest:g}"
    for patch in design.patch:
        if not _whole(largest / patch):
            yield f"size.patch_mm = {1e3 * patch:g}: must be a whole part of {1e3 * largest:g}"
        for spacing in design.spacing:
            if not _whole(patch / spacing):
                yield (
                    f"size.patch_mm = {1e3 * patch:g}: must be a multiple of the spacing "
                    f"{1e3 * spacing:g}"
                )
    base = (grid.cells_x * grid.spacing, grid.cells_y * grid.spacing)
    if base[0] != base[1] or not _among(base[0], design.patch):
        yield f"size.patch_mm: must have the side of the grid, {1e3 * base[0]:g} (a square)"
    if not _among(grid.spacing, design.spacing):
        yield f"size.spacing_mm: must have grid.spacing_mm = {1e3 * grid.spacing:g}"
    surface = configuration.surface
    for name, spectrum in design.spectra.items():
        try:
            spectrum_of(spectrum.hurst, surface.rule, spectrum.roll_off, finest)
        except InputError as error:
            yield f"size.spectra.{name}: {error}"
    if surface.mismatch_wavelength is not None or surface.correlation or surface.shift_in_cells:
        yield "size: its walls are independent: surface.correlation and the like must be off"


def _whole(ratio: float) -> bool:
    return math.isfinite(ratio) and abs(ratio - round(ratio)) < 1e-9 * ratio


def _among(value: float, values: tuple[float, ...]) -> bool:
    return any(abs(value - other) < 1e-9 * value for other in values)


def _scenes(keys: dict, configuration: Configuration) -> list:
    """Return the effects of the study, and of each rock with separate effects."""
    given = keys["effects"]
    first = next(iter(configuration.rocks.values())).effects
    study = type(first)(**{name: given[name] for name in first._fields})
    return list(dict.fromkeys([study, *(rock.effects for rock in configuration.rocks.values())]))


def _unusual(keys: dict, where: str) -> Iterator[str]:
    """Generate messages on values that are unusual for rock and its joints."""
    for key, value in keys.items():
        name, unit = name_and_unit(key)
        if isinstance(value, dict):
            yield from _unusual(value, f"{where}{key}.")
        elif name in USUAL and value is not None:
            low, high = (in_unit(bound, unit) for bound in USUAL[name][:2])
            for number in value if isinstance(value, list) else [value]:
                if not (low <= number <= high or number == 0.0):
                    yield (
                        f"{where}{key} = {number!r}: not usual of rock ({low:g} to {high:g} {unit})"
                        "; is the unit right? study.unusual_values: allow takes it as it is"
                    )


def _rock_problems(
    name: str, rock: StudyRock, keys: dict, configuration: Configuration
) -> Iterator[str]:
    given = keys["rocks"][name]
    stress, seating = given["max_normal_stress_MPa"], keys["seating_stress_MPa"]
    where = f"rocks.{name}.max_normal_stress_MPa = {stress:g}"
    if seating > LARGEST_SEATING * stress:
        yield f"seating_stress_MPa = {seating:g}: must be at most {LARGEST_SEATING:g} of {where}"
    end = keys["output"]["largest_stress_MPa"]
    if end is not None and end < stress:
        yield f"output.largest_stress_MPa = {end:g}: must be at least {where}"
    stiffness = min(rock.levels.get("youngs_modulus", (rock.intact.youngs_modulus,)))
    if rock.max_normal_stress >= stiffness:
        yield f"{where}: must be below Young's modulus, {1e-6 * stiffness:g} MPa"
    yield from wall_problems(keys, name)
    varied = {key: levels for key, levels in given["levels"].items() if levels is not None}
    for key, levels in varied.items():
        if given[key] is not None:
            yield from _level_problems(f"rocks.{name}.levels.{key}", levels, given[key])
    jrcs = [jrc for jrc in (given["jrc"], *varied.get("jrc", [])) if jrc is not None]
    relation = relation_of(configuration.surface.jrc_relation)
    for jrc in jrcs:
        if not relation.smallest_jrc <= jrc <= relation.largest_jrc:
            yield (
                f"rocks.{name}: jrc = {jrc:g}: {configuration.surface.jrc_relation} holds "
                f"from {relation.smallest_jrc:g} to {relation.largest_jrc:g}"
            )


def _level_problems(where: str, levels: list, base: float) -> Iterator[str]:
    shown = f"{where} = [{', '.join(f'{level:g}' for level in levels)}]"
    if any(not later > earlier for earlier, later in itertools.pairwise(levels)):
        yield f"{shown}: must be strictly ascending"
    if base in levels:
        yield f"{shown}: must not contain the value of the rock, {base:g}, which is always a level"

"""Sources of uncertainty of a joint, and the changes of a result that they make."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from jointclosure.inputs import InputError, check_number, did_you_mean, naming
from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.joint.rocks import both_walls
from jointclosure.parameters import (
    OF_ROCK,
    PLAUSIBLE,
    Choices,
    Effects,
    Numerics,
    key_of,
    without_effect,
)
from jointclosure.parameters.units import in_unit, name_and_unit
from jointclosure.walls.scan_errors import ScanErrors

ORDER = "order"  # source of another order of breakage: a mirrored copy
OTHER_RULE = "other rule of steps"
"""Source of the joint by the paper's steps, by which its numerical error is judged. Ranges do not
contain it."""
TITLES = {
    "spacing": "grid spacing",
    "breakage": "numerical error",
    "registration": "registration",
    "noise": "noise of the scans",
    "resolution": "waves that the scans lost",
    "scale": "scale of heights",
    "holes": "missing heights",
    ORDER: "order of breakage",
    OTHER_RULE: "the paper's steps",
    "peak_modulus_ratio": "peak modulus ratio",
    "base_radius_in_cells": "base radius",
    "peaks": "choice of soft peaks",
} | {name: about.long_name for name, about in OF_ROCK.items()}
"""Titles of the sources of uncertainty, by name."""
COARSER = 2  # spacing of the coarser grid, over that of the joint
VARIED = {name: key_of(name) for name in OF_ROCK} | {
    "peak_modulus_ratio": "peak_modulus_ratio",
    "base_radius_in_cells": "base_radius_in_cells",
    "spacing": "spacing_mm",
}
"""Sources whose range can be stated, and their keys with units."""
ALL = "all together"  # source of the variants in which all sources have random values
MULTIPLE = "multiple"
"""Kind of a source whose value is that of the joint, a multiple of this, or this divided by the
multiple. A variant has the multiple; the division is not simulated, but its changes are expected
from those by the multiple."""
SHARED = "shared"  # kind of a source whose second value all variants have, unlike the joint


class Source(NamedTuple):
    """A source of uncertainty of a joint, and the values that it may have.

    ``values`` depend on the ``kind``. They are the lowest and the highest value of a "range", the
    alternatives of a "choice", or the numbers of the draws of a "random" source. All but a range
    begin with the value of the joint, which for a random source is no draw. The second value of a
    "shared" source holds in the variants of all other sources, which are compared with the variant
    that differs from the joint by it alone. `MULTIPLE` is a kind too. A source that is not
    ``varied`` is a choice of the model: it is changed alone, and is no part of the range.
    """

    values: tuple
    kind: str = "choice"
    varied: bool = True
    usual: float = 0.5  # position in a "range" at which the joint lies

    def at(self, position: float) -> Any:
        """Return the value of the source at a position in [0, 1).

        In a range it is by the logarithm if the lowest value is positive. A choice has equal parts
        of [0, 1) for its alternatives. A random source has another draw at each position. Sources
        that are shared or multiples have no value by position.
        """
        if self.kind == "random":
            return len(self.values) + int(position * 2**32)  # another draw
        if self.kind == "choice":
            return self.values[int(position * len(self.values))]
        low, high = self.values
        return low * (high / low) ** position if low > 0.0 else low + position * (high - low)

    def changes_at(self, changes: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Return the changes (n,) of a result that are expected at positions (n,) in [0, 1).

        ``changes`` (k,) are the changes at the values other than that of the joint, NaN, which
        counts as 0, for a variant that failed. In a range they are linear to either end from the
        joint, and with a shared source to either sign of its change. Random sources have 0 here.
        """
        if self.kind == "random":
            return np.zeros(positions.shape)
        changes = np.nan_to_num(changes)  # what is not known counts as 0
        if self.kind == "range":
            return np.interp(positions, [0.0, self.usual, 1.0], [changes[0], 0.0, changes[1]])
        if self.kind == SHARED:  # the error may as well have the other sign
            return (2.0 * positions - 1.0) * changes[0]
        if self.kind == MULTIPLE:
            return np.array([changes[0], 0.0, changes[1]])[(3.0 * positions).astype(int)]
        return np.append(0.0, changes)[(positions * len(self.values)).astype(int)]


def sources_of(
    conditions: CheckedConditions,
    shape: tuple[int, ...],
    ranges: Mapping[str, tuple[float, float]] = {},
    errors: ScanErrors | None = None,
) -> dict[str, Source]:
    """Return the sources of uncertainty of a joint of (ny, nx) = ``shape`` cells, by name.

    Sources without an effect on the joint are left out. ``ranges`` (lowest, highest) [SI] are
    stated for sources in `VARIED`, and ``errors`` are those of scanned walls, None for exact walls.
    Raise `InputError` if a range is not allowed (`check_ranges`).
    """
    check_ranges(conditions, ranges)
    effects = conditions.effects
    numerics = conditions.numerics
    choices = conditions.choices
    sources = {}
    if "spacing" in ranges:
        sources["spacing"] = Source((1, round(ranges["spacing"][1] / conditions.grid_spacing)))
    elif errors and errors.step > 1:
        sources["spacing"] = Source((1, 1 / errors.step))
    elif min(shape) >= 8 * COARSER:
        sources["spacing"] = Source((1, COARSER), MULTIPLE, False)
    if effects.breakage and numerics.solver == "fast" and numerics.target == "equilibrate":
        resolved = numerics.breakage == "resolved"
        if resolved and numerics.tolerance <= 0.05:  # it is at most 0.1
            sources["breakage"] = Source((numerics, coarser(numerics, 2.0)), SHARED)
        else:
            other = coarser(numerics, 0.5) if resolved else numerics._replace(breakage="resolved")
            sources["breakage"] = Source((numerics, other))
    if errors and errors.covariance.any():
        sources["registration"] = Source((0, 1, 2), "random")
    if errors and errors.noise[1] > 0.0:
        sources["noise"] = Source((0, 1, 2), "random")
    if errors and max(errors.waves) > 0.0:
        sources["resolution"] = Source((0, 1, 2), "random")
    if errors and errors.scale != 1.0:
        sources["scale"] = Source((0, 1, 2), "random")
    if errors and errors.holes.any():
        sources["holes"] = Source((0, 1, 2), "random")
    if effects.breakage:
        sources[ORDER] = Source(("as it is", "mirrored"), "random")
    for name, ends in PLAUSIBLE.items():
        values = tuple(ranges.get(name, ends))
        stated = name in ranges
        if without_effect(name, effects, choices, numerics):
            continue
        joint = getattr(choices, name)
        if isinstance(joint, str):
            others = (value for value in values if value != joint)
            sources[name] = Source((joint, *others), "choice", stated)
        else:
            sources[name] = _range_about(joint, values, stated)
    for name in OF_ROCK:
        if name in ranges:
            joint = getattr(both_walls(conditions.rock)[0], name)
            sources[name] = _range_about(joint, ranges[name], True)
    return sources


def coarser(numerics: Numerics, factor: float) -> Numerics:
    """Return numerics with the tolerance and the sizes of steps multiplied by a ``factor``.

    Settings without effect on joints with all effects stay as they are.
    """
    effects, choices = Effects(), Choices()
    scaled = {
        name: factor * getattr(numerics, name)
        for name in (*_step_sizes(), "tolerance")
        if not without_effect(name, effects, choices, numerics)
    }
    return numerics._replace(**scaled)


def by_paper_steps(numerics: Numerics) -> Numerics:
    """Return numerics with the paper's rule and sizes of steps; other settings stay."""
    usual = Numerics()._asdict()
    sizes = {name: usual[name] for name in _step_sizes()}
    return numerics._replace(breakage=usual["breakage"], **sizes)


def _step_sizes() -> list[str]:
    """Return the names of the fields of `Numerics` that are sizes of steps [m]."""
    return [name for name in Numerics._fields if "_step" in name and "most" not in name]


def _range_about(joint: float, ends: tuple[float, float], varied: bool) -> Source:
    """Return a source of kind "range" from two ends, which are moved to contain the joint's value.

    ``varied`` is as for `Source`. The position of the joint follows by logarithms if all values are
    positive.
    """
    low = min(joint, ends[0])
    high = max(joint, ends[1])
    part = (
        math.log(joint / low) / math.log(high / low) if low > 0.0 else (joint - low) / (high - low)
    )
    return Source((low, high), "range", varied, part)


def check_ranges(conditions: CheckedConditions, ranges: Mapping[str, tuple[float, float]]) -> None:
    """Raise `InputError` if a stated range of a source is not allowed.

    Each must be two ascending numbers [SI] for a name in `VARIED`, allowed for the conditions, and
    contain the value of the joint. Ranges of properties of rock need both walls of one rock. A
    range of the spacing must begin at the spacing of the joint's grid and end at about twice of it
    or more; it is not checked further if the grid is not known yet.
    """
    first, second = conditions.rock
    for name, ends in ranges.items():
        if name not in VARIED:
            known = ", ".join(VARIED)
            raise InputError(
                f"ranges: {name!r}: must be one of {known}{did_you_mean(name, VARIED)}"
            )
        if np.shape(ends) != (2,):
            raise InputError(f"ranges: {name} = {ends!r}: must be (lowest, highest)")
        for end in ends:
            check_number(f"ranges: {name}", end)
        if not ends[0] < ends[1]:
            unit = name_and_unit(VARIED[name])[1]
            low, high = (in_unit(end, unit) for end in ends)
            raise InputError(
                f"ranges: {VARIED[name]} = {low:g} to {high:g}: the lowest value must come first"
            )
        if name in OF_ROCK and first != second:
            raise InputError(f"ranges: {name}: both walls must be of one rock")
        if name == "spacing" and conditions.spacing is None:
            continue
        if name == "spacing":
            grid = conditions.grid_spacing
            if round(ends[1] / grid) < 2 or not np.isclose(ends[0], grid, rtol=1e-3):
                raise InputError(
                    f"ranges: spacing_mm = {1e3 * ends[0]:.4g} to {1e3 * ends[1]:.4g}: must begin "
                    f"at the spacing of the joint's grid, {1e3 * grid:.4g} mm, which is the "
                    "finest, and end at least at twice of it"
                )
            continue
        given = first if name in OF_ROCK else conditions.choices
        for end in ends:
            with naming("ranges"):
                type(given)(**given._asdict() | {name: end})
        if not ends[0] <= getattr(given, name) <= ends[1]:
            unit = name_and_unit(VARIED[name])[1]
            low, high, joint = (in_unit(each, unit) for each in (*ends, getattr(given, name)))
            raise InputError(
                f"ranges: {VARIED[name]} = {low:g} to {high:g}: must contain that of the joint, "
                f"{joint:g}"
            )

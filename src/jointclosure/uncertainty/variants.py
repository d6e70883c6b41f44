"""Variants of a joint: other values of what is not known of it, or of what the model chooses.

Each source of uncertainty is varied alone. Then the sources to which the range is due are varied
together: 12 joints have random values, drawn as a Latin hypercube (McKay, Beckman & Conover 1979).
Choices of the model without a stated range keep their usual values in these. Random numbers of a
source do not depend on the other sources. With resolved breakage all variants have twice the
tolerance, which shortens their time and hardly changes the effect of a source.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.parameters import OF_ROCK, PLAUSIBLE
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.uncertainty.sources import (
    ALL,
    ORDER,
    OTHER_RULE,
    SHARED,
    TITLES,
    Source,
    by_paper_steps,
)
from jointclosure.walls import Walls
from jointclosure.walls.scan_errors import ScanErrors

RANDOM_JOINTS = 12  # that are simulated with random values of all sources
SEED = 1796
"""Seed of the random values of these joints. Of the first 4,000 seeds it has the smallest largest
correlation between any two of `VARIED` (0.27; median of all seeds 0.59), so that the effects of
sources are not confounded."""
FURTHER_SEED = 1
"""Seed of the random values of further joints, whose results are estimated and not simulated."""
COPIES: Mapping[str, Callable[[np.ndarray], np.ndarray]] = {
    "as it is": lambda wall: wall,
    "last digits": lambda wall: wall * (1.0 + 1e-12),
    "mirrored": lambda wall: np.ascontiguousarray(wall[:, ::-1]),
    "transposed": lambda wall: np.ascontiguousarray(wall.T),
}
"""Copies of a wall whose results are equal but for rounding and the order of breakage."""
_FIELDS = {"spacing": "step", "registration": "place", ORDER: "copy"} | {
    name: name for name in ("noise", "resolution", "scale", "holes")
}
"""Fields of a variant by the names of the sources that change its walls."""


class Variant(NamedTuple):
    """A joint with another value of one source, or with other values of all sources.

    ``source`` is its name, ``value`` describes the value. Its walls have every ``step``-th cell of
    the grid; a step below 1 is that of a finer grid, which the scans do not resolve. ``place``,
    ``noise``, ``resolution``, ``scale`` and ``holes`` are the numbers of random draws of errors of
    the scans, 0 for none. ``copy`` is one of `COPIES`.
    """

    source: str
    value: str
    conditions: CheckedConditions
    step: float = 1
    place: int = 0
    noise: int = 0
    resolution: int = 0
    scale: int = 0
    holes: int = 0
    copy: str = "as it is"

    def walls(self, upper: np.ndarray, lower: np.ndarray, errors: ScanErrors | None) -> Walls:
        """Return the walls (y, x) [m] of the variant.

        ``upper`` and ``lower`` (y, x) [m] are the walls of the joint to which the ``errors`` refer.
        """
        step = round(self.step * (errors.step if errors else 1))
        if errors and self.scale:
            upper, lower = errors.with_one_scale(upper, lower, self.scale)
        if errors and self.resolution:
            upper, lower = errors.with_lost_waves(upper, lower, self.resolution)
        if errors and self.noise:
            upper, lower = errors.with_other_noise(upper, lower, self.noise)
        if errors and self.place:
            upper = errors.displaced(upper, self.place)
        if errors and self.holes:
            upper, lower = errors.with_filled_holes(upper, lower, self.holes)
        upper, lower = (COPIES[self.copy](wall) for wall in (upper, lower))
        return upper[::step, ::step], lower[::step, ::step]

    def changed(self, name: str, value: Any) -> "Variant":
        """Return the variant with another value of the source ``name``.

        Its own ``source`` and ``value`` stay, which the caller sets. For "spacing" the value is a
        step, and the spacing of the conditions changes with it.
        """
        conditions = self.conditions
        choices = self.conditions.choices
        if name in _FIELDS:
            changed = self._replace(**{_FIELDS[name]: value})
            spacing = value * conditions.grid_spacing if name == "spacing" else conditions.spacing
            return changed._replace(conditions=conditions._replace(spacing=spacing))
        if name == "breakage":
            return self._replace(conditions=conditions._replace(numerics=value))
        if name in PLAUSIBLE:
            choices = choices._replace(**{name: value})
            return self._replace(conditions=conditions._replace(choices=choices))
        upper, lower = (wall._replace(**{name: value}) for wall in conditions.rock)
        return self._replace(conditions=conditions._replace(rock=(upper, lower)))


def variants_of(
    conditions: CheckedConditions,
    sources: Mapping[str, Source],
    draws: int = RANDOM_JOINTS,
    seed: int = SEED,
) -> Iterator[Variant]:
    """Generate the variants of a joint, of which none is simulated here.

    If the joint has resolved breakage, the first has the paper's steps (`OTHER_RULE`). Then each
    source is changed alone, to each of its values. Then follow ``draws`` variants with random
    values of all sources that are varied in the range (`ALL`); if there are none but the order of
    breakage, these are copies with another order. All variants but the one with the paper's steps
    have the second value of a shared source.
    """
    joint = Variant("", "", conditions)
    if conditions.numerics.breakage == "resolved" and "breakage" in sources:
        paper = by_paper_steps(conditions.numerics)
        yield joint.changed("breakage", paper)._replace(source=OTHER_RULE, value="fixed steps")
    for name, source in sources.items():
        if source.kind == SHARED:
            joint = joint.changed(name, source.values[1])
    for name, source in sources.items():
        for value in source.values[0 if source.kind == "range" else 1 :]:
            yield joint.changed(name, value)._replace(source=name, value=value_text(name, value))
    fixed = {name for name, source in sources.items() if source.kind == SHARED or not source.varied}
    for number, row in enumerate(random_positions(sources, draws, seed)):
        drawn = joint._replace(source=ALL)
        texts = []
        if not sources.keys() - fixed - {ORDER}:  # only the order of breakage is left
            copy = list(COPIES)[1 + number % (len(COPIES) - 1)]
            drawn = drawn.changed(ORDER, copy)
            texts = [f"{TITLES[ORDER]} {copy}"]
        for position, (name, source) in zip(row, sources.items(), strict=True):
            if name == ORDER or name in fixed:  # another order, and the same steps, in all
                continue
            value = source.at(float(position))
            drawn = drawn.changed(name, value)
            texts.append(f"{TITLES[name]} {value_text(name, value)}")
        yield drawn._replace(value="; ".join(texts))


def random_positions(names: Iterable[str], draws: int, seed: int) -> np.ndarray:
    """Draw positions (draws, sources) in [0, 1) of the values of sources, as a Latin hypercube."""
    columns = []
    for name in names:
        random = generator(seed_of(seed, "range", name))
        columns.append((random.permutation(draws) + random.random(draws)) / draws)
    return np.stack(columns, axis=1)


_PEAKS = {"pristine": "before loading", "current": "as the walls break"}
"""Which soft peaks are meant by the values of this choice of the model."""


def value_text(name: str, value: Any) -> str:
    """Describe the value of a source ``name``, such as "every 2. cell", "draw 1" or "11 (GPa)"."""
    if name == "spacing":
        if value < 1:
            return f"a spacing {1 / value:.0f} times as fine"
        return f"every {value}. cell" if value > 1 else "every cell"
    if name in ("registration", "noise", "resolution", "scale", "holes"):
        return f"random values {value}"
    if name == "breakage":
        resolved = value.breakage == "resolved"
        return f"tolerance {value.tolerance:.3g}" if resolved else "fixed steps"
    if name == "peaks":
        return _PEAKS[value]
    if name in OF_ROCK:
        return f"{value / OF_ROCK[name].size:.4g}{OF_ROCK[name].in_brackets}"
    return value if isinstance(value, str) else f"{value:.3g}"

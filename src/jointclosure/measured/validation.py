"""Validation: mechanisms and constants that are compatible with all measured loadings.

A mechanism acts between the first loading and the later ones. Joints are simulated for each of its
constants, each strength, and each mismatch wavelength of random walls. Such a combination is
compatible if the probability is at least 5 % that one of its joints is as far from the mean of its
joints as the measured joint is, or farther. The distance is Hotelling's over all readings, with the
covariance of surfaces, measurement and numerical error
(`jointclosure.measured.likelihood.likelihood_of`).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Unpack

import numpy as np
import pandas as pd

from jointclosure.inputs import InputError, check_below, check_number, check_positive
from jointclosure.inputs.keywords import takes
from jointclosure.inputs.remarks import caution, without_word
from jointclosure.measured.compared_quantities import about_share, prediction_intervals
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.measured.joint_arguments import JointKeywords, MeasuredJoint, asked_joints
from jointclosure.measured.likelihood import (
    Likelihood,
    Readings,
    likelihood_of,
    log_readings,
    reading_sentences,
)
from jointclosure.measured.simulated_joints import (
    ABOUT_RANGES,
    ADVICE,
    ComparisonJoints,
    LaterLoading,
    numerical_sentence,
)
from jointclosure.parameters import RESOLVED, Numerics, Rock
from jointclosure.statistics.number_texts import percent, significant
from jointclosure.statistics.standard_errors import CONFIDENCE

NUMERICS = RESOLVED._replace(tolerance=0.05)
"""Usual numerics: their error is below the scatter of joints, and counts."""
WAVELENGTHS = 6  # mismatch wavelengths at which joints are simulated
STRENGTHS = 4  # strengths at which joints are simulated
RANGE = (1.0 / 3.0, 2.0)
"""Usual range of tried strengths, over the strength of the rock."""
_ABOUT_CONSTANTS = (
    "a constant is compatible from low to high, among those tried, if the probability is at least "
    f"{100.0 * (1.0 - CONFIDENCE):.0f} % that a joint lies as far from the mean as the curve"
)
NEITHER = "neither"  # name of loadings without a mechanism between them


class Mechanism(NamedTuple):
    """Mechanism that may act between the first loading and later ones."""

    field: str  # of `LaterLoading`
    none: float  # value of the field without the mechanism
    constant: str  # name of the field in words
    unit: str


MECHANISMS = {
    "walls seated anew": Mechanism("shift", 0, "shift of reseating", "cells"),
    "weaker crushed rock": Mechanism(
        "crushed_strength_ratio", 1.0, "strength of crushed rock over rock", "1"
    ),
}
"""Mechanisms that are tried, by their name in words."""


def mechanism_of(later: LaterLoading) -> str:
    """Return the name of the mechanism by which later loadings differ from the first."""
    acts = (name for name, one in MECHANISMS.items() if getattr(later, one.field) != one.none)
    return next(acts, NEITHER)


class Region(NamedTuple):
    """Comparison of a measured curve with joints of all tried constants.

    It has the region of constants that are compatible with the curve, and is valid only for the
    joint that is described by ``assumed``.
    """

    measured: Readings
    curve: MeasuredCurve
    compared: dict[LaterLoading, Likelihood]
    closures: np.ndarray  # [m] since seating, net, of axes as from `ComparisonJoints.closures`
    stresses: np.ndarray  # [Pa]
    error: float  # relative, of measured and simulated closures
    assumed: str
    scanned: bool
    left_out: list[str]  # sentences
    numerical: Mapping[
        str, tuple[float, float]
    ] = {}  # as from `ComparisonJoints.numerical_changes`
    reading: Sequence[str] = ()  # sentences on how the curve was read

    def joints_of(self, mechanism: str) -> dict[LaterLoading, Likelihood]:
        """Return the likelihoods of joints with a mechanism, by each of its constants.

        The first one is of joints without any mechanism.
        """
        wanted = NEITHER, mechanism
        return {
            later: self.compared[later] for later in self.compared if mechanism_of(later) in wanted
        }

    @property
    def mechanisms(self) -> list[str]:
        """Names of the mechanisms that were compared; the first is `NEITHER`, for none."""
        return list(dict.fromkeys(map(mechanism_of, self.compared)))

    def nearest(self, mechanism: str) -> tuple[int, int, int]:
        """Return the indices of the largest p-value of a mechanism.

        They are indices of its constant, in the order of `joints_of`, of the wavelength, and of the
        strength, both on the fine grid of the likelihood.
        """
        p_values = self.p_values(mechanism)
        number, i, j = np.unravel_index(int(p_values.argmax()), p_values.shape)
        return int(number), int(i), int(j)

    def p_values(self, mechanism: str) -> np.ndarray:
        """Return the p-values (constants, wavelengths, strengths) of a mechanism."""
        return np.stack([joints.p_values for joints in self.joints_of(mechanism).values()])

    def table(self) -> pd.DataFrame:
        """Return the compatible range of each constant, in rows by mechanism.

        A constant is compatible if the p-value is at least 5 % with some values of the others.
        ``low`` and ``high`` are NaN if no value is compatible. ``nearest`` is the value at the
        largest ``p_value`` of the mechanism.
        """
        rows: list[dict[str, Any]] = []
        for mechanism in self.mechanisms:
            kinds = self.joints_of(mechanism)
            nearest = self.nearest(mechanism)
            p_values = self.p_values(mechanism)
            fine = next(iter(kinds.values()))
            grids = [("strength", "MPa", 1e-6 * fine.strengths, 2)]
            if not self.scanned:
                grids.append(("mismatch wavelength", "mm", 1e3 * fine.wavelengths, 1))
            if mechanism in MECHANISMS:
                field, _, constant, unit = MECHANISMS[mechanism]
                tried = np.array([getattr(later, field) for later in kinds], float)
                grids.append((constant, unit, tried, 0))
            for constant, unit, tried, axis in grids:
                others = tuple(other for other in range(3) if other != axis)
                allowed = tried[(p_values >= 1.0 - CONFIDENCE).any(axis=others)]
                low, high = (allowed.min(), allowed.max()) if allowed.size else (np.nan, np.nan)
                rows.append({
                    "mechanism": mechanism, "constant": constant, "unit": unit,
                    "low": low, "high": high, "tried_low": tried.min(), "tried_high": tried.max(),
                    "nearest": tried[nearest[axis]], "p_value": p_values[nearest],
                })  # fmt: skip
        return pd.DataFrame(rows)

    def quantities(self) -> pd.DataFrame:
        """Return measured quantities beside 95 % intervals of a joint, in rows by mechanism.

        The joint is one of those nearest to the curve (`place`).
        """
        rows = []
        axis = int(self.scanned)
        for mechanism in self.mechanisms:
            kind, *place = self.place(mechanism)
            joints = np.exp(log_readings(self.closures[kind], self.stresses, self.measured))
            joints = joints.take(place[1 - axis], axis=1 - axis)
            for one, low, high in prediction_intervals(self.measured, joints, self.error):
                about = {"mechanism": mechanism, "quantity": one.name, "unit": one.unit}
                ends = {"low": low[place[axis]], "high": high[place[axis]]}
                rows.append(about | {"measured": float(one.values)} | ends)
        return pd.DataFrame(rows)

    def p_value(self, mechanism: str) -> float:
        """Return the largest p-value of the curve among all tried constants of a mechanism.

        It is the probability that a joint with these constants is as far from the mean of such
        joints as the curve, or farther.
        """
        return float(self.p_values(mechanism).max())

    def compatible(self, mechanism: str) -> bool:
        """Return whether any tried constants of a mechanism are compatible with the curve."""
        return self.p_value(mechanism) >= 1.0 - CONFIDENCE

    def place(self, mechanism: str) -> tuple[int, int, int]:
        """Return the simulated constants next to `nearest`, as indices into `closures`.

        They are indices of the changes of later loadings, the wavelength, and the strength.
        """
        number, *places = self.nearest(mechanism)
        later, joints = list(self.joints_of(mechanism).items())[number]
        kind = list(self.compared).index(later)
        return kind, *joints.nodes(places, self.closures.shape[1:3])

    def sentences(self) -> list[str]:
        """Return sentences on what is compatible with the curve, by mechanism, and on assumptions.

        For a mechanism that is not compatible they name the quantities that its joints miss.
        """
        lines: list[str] = []
        if not any(map(self.compatible, self.mechanisms)):
            lines.append(caution(f"none is compatible with all loadings of this curve; {ADVICE}"))
        rows = self.table()
        quantities = self.quantities()
        for mechanism in self.mechanisms:
            title = "no mechanism between loadings" if mechanism == NEITHER else mechanism
            if self.compatible(mechanism):
                ranges = map(_formatted_range, rows[rows.mechanism == mechanism].itertuples())
                lines.append(f"{title}: compatible with {'; '.join(ranges)}")
                continue
            p_value = self.p_value(mechanism)
            beyond = f"{100.0 * (1.0 - p_value):.3g} %" if p_value > 1e-3 else "more than 99.9 %"
            missed = (
                f"{row.quantity} {significant(row.measured, 3)} {row.unit}".removesuffix(" 1")
                + f" is measured, joints have {significant(row.low, 3)} to "
                f"{significant(row.high, 3)}{about_share(row.unit, row.low)}"
                for row in quantities[quantities.mechanism == mechanism].itertuples()
                if row.measured < row.low or row.measured > row.high
            )
            where = "; ".join(missed) or "each quantity is met by itself, but not all together"
            lines.append(
                f"{title}: not compatible, the curve is farther from the mean of the simulated "
                f"joints that come nearest to it than {beyond} of these joints are: {where}"
            )
        lines += [_ABOUT_CONSTANTS, ABOUT_RANGES, *numerical_sentence(self.numerical)]
        lines += self.reading
        return [*lines, *self.left_out, f"valid only for the assumed joint: {self.assumed}"]

    def __repr__(self) -> str:
        return f"<Region: {'; '.join(self.sentences())}>"


def _formatted_range(row: Any) -> str:
    """Format the compatible range in a row of `Region.table`, such as "strength 80 to 120 MPa".

    An end at the limit of what was tried is followed by "or less" or "or more", unless nothing
    beyond it is possible.
    """
    low, high = (f"{end:.3g}" for end in (row.low, row.high))
    unit = "" if row.unit == "1" else f" {row.unit}"
    if row.low == row.tried_low and row.high == row.tried_high:
        return f"{row.constant} {low} to {high}{unit}, all that was tried"
    less = " or less" if row.low == row.tried_low and row.constant != "shift of reseating" else ""
    more = " or more" if row.high == row.tried_high and row.tried_high != 1.0 else ""
    return f"{row.constant} {low}{less} to {high}{more}{unit}"


@takes(MeasuredJoint)
def validate(
    curve: str | Path | MeasuredCurve,
    *,
    strengths: Sequence[float] | None = None,
    shifts: Sequence[float] | None = (1, 2, 4),
    crushed_strength_ratios: Sequence[float] | None = (0.9, 0.8, 0.6),
    numerics: Numerics = NUMERICS,
    cache: str | Path | None = None,
    workers: int | None = None,
    report: Callable[[str], None] = lambda line: None,
    **joint: Unpack[JointKeywords],
) -> Region:
    """Find the mechanisms and constants that are compatible with all loadings of a measured curve.

    Parameters
    ----------
    strengths : (float, float), optional
        Ends of the range of compressive strengths [Pa], by default a third and twice that of the
        rock. Joints are simulated at 4 of them and, for random walls, at 6 mismatch wavelengths
        from two spacings to the shorter side.
    shifts : sequence of int, optional
        Shifts of the upper wall along x between the first and the later loadings, in cells, besides
        0; none leaves this mechanism out.
    crushed_strength_ratios : sequence of float, optional
        Strengths of crushed rock over that of the rock in later loadings, besides 1; none leaves
        this mechanism out. See `jointclosure.Choices`.
    numerics
        As for `jointclosure.simulate`; by default breakage is resolved to a tolerance of 5 %, which
        counts as an error of the joints. The error of the nearest joints is also measured.
    report : callable, optional
        Receives lines about assumptions, progress and remaining time.
    curve, cache, workers, **joint
        As for `jointclosure.fit`, which also describes the assumptions.

    Returns
    -------
    Region
        Comparison with the curve, whose ``table`` has the compatible range of each constant and
        whose ``sentences`` describe the result.

    Raises
    ------
    InputError
        As `jointclosure.fit`, or if a strength, a shift or a ratio is out of its range.
    TypeError
        If a keyword is unknown, or the rock is missing.
    """
    given = asked_joints(curve, joint, "validate", WAVELENGTHS)
    measured = given.measured
    pair = given.pair
    laters = _tried_laters(
        shifts or (), crushed_strength_ratios or (), given.walls.shape[1], measured.cycles
    )
    ends = _strength_range(strengths, given.rock)
    tried = np.geomspace(*ends, STRENGTHS)
    wavelengths = given.wavelengths
    joints = ComparisonJoints(
        given, given.conditions(numerics, NUMERICS), tuple(tried.tolist()),
        (tried.size, 1, wavelengths.size * tried.size), laters, cache, workers, report,
    )  # fmt: skip
    joints.check(ends)
    assumed = given.assumed(ends)
    assumed += f"; closures measured to {percent(given.joint.closure_error)}, 95 % confidence"
    for line in pair.remarks if pair is not None else [f"assumed: {assumed}"]:
        report(line)
    again = f", and again in {len(laters)} ways" if measured.cycles > 1 else ""
    count = given.joint.surfaces * wavelengths.size * tried.size
    report(f"{count} joints are simulated{again}, except those that are kept")
    closures = joints.closures()
    numerical = numerics.tolerance if numerics.breakage == "resolved" else 0.0
    error = math.hypot(given.joint.closure_error, numerical)
    compared: dict[LaterLoading, Likelihood] = {}
    left_out: list[str] = []
    for later, logs in zip(laters, log_readings(closures, joints.stresses, measured), strict=True):
        try:
            compared[later] = likelihood_of(measured, logs, wavelengths, tried, error)
        except InputError as reason:
            left_out.append(caution(f"{mechanism_of(later)}, {later}: left out, {reason}"))
    if LaterLoading() not in compared:
        name = "curve" if isinstance(curve, MeasuredCurve) else str(curve)
        raise InputError(f"{name}: the joints cannot be compared: {without_word(left_out[0])}")
    kept = [laters.index(later) for later in compared]
    region = Region(
        measured, given.curve, compared, (closures - closures[..., :1, :1])[kept],
        joints.stresses, error, assumed, pair is not None, left_out,
        reading=reading_sentences(given.curve, measured, given.joint.closure_error),
    )  # fmt: skip
    kind, i, j = region.place(max(region.mechanisms, key=region.p_value))
    changes = joints.numerical_changes((kept[kind], i, j), closures)
    return region._replace(numerical=changes)


def _tried_laters(
    shifts: Sequence[float], ratios: Sequence[float], columns: int, cycles: int
) -> tuple[LaterLoading, ...]:
    """Return the changes that are tried after the first loading: first none, then shifts, ratios.

    ``columns`` is the number of cells along x, of which 8 must stay after a shift. A curve of one
    cycle has no change. Raise `InputError` if a shift or a ratio is not allowed.
    """
    for shift in shifts:
        check_number("shifts", shift)
        if not (float(shift).is_integer() and 1 <= shift <= columns - 8):
            raise InputError(
                f"shifts = {shift!r}: must be whole numbers of cells from 1 to {columns - 8}, "
                "so that 8 cells stay"
            )
    for ratio in ratios:
        check_below("crushed_strength_ratios", ratio, 1.0)
    if cycles == 1:
        return (LaterLoading(),)
    seated_anew = [LaterLoading(shift=int(shift)) for shift in sorted(set(shifts))]
    weaker = sorted(set(ratios), reverse=True)
    crushed = [LaterLoading(crushed_strength_ratio=float(ratio)) for ratio in weaker]
    return LaterLoading(), *seated_anew, *crushed


def _strength_range(strengths: Sequence[float] | None, rock: Rock) -> tuple[float, float]:
    """Return the lowest and the highest tried strength [Pa], by default `RANGE` times the rock's.

    Raise `InputError` unless ``strengths`` are two positive numbers in ascending order.
    """
    if strengths is None:
        low, high = (factor * rock.compressive_strength for factor in RANGE)
        return low, high
    if not isinstance(strengths, tuple | list) or len(strengths) != 2:
        raise InputError(f"strengths = {strengths!r} Pa: must be two, the lowest and the highest")
    for strength in strengths:
        check_positive("strengths", strength, "Pa")
    low, high = map(float, strengths)
    if low >= high:
        raise InputError(f"strengths = {strengths!r} Pa: the lower one must come first")
    return low, high

"""Fit of a joint to its measured closure: mismatch wavelength, or strength of scanned walls."""

import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple, Unpack

import numpy as np

from jointclosure.engine.scanned_joint import RESOLVED
from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import caution
from jointclosure.measured.agreement import Agreement, agreements
from jointclosure.measured.calibration import (
    Interval,
    Likelihood,
    Readings,
    Simulated,
    likelihood_of,
    logs_of,
    tried_places,
)
from jointclosure.measured.closing import (
    Closing,
    Joints,
    first_conditions,
    numerical_sentence,
    stresses_of,
)
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.measured.joints import (
    JointKeywords,
    asked_joints,
    check_joints,
    takes_joint,
)
from jointclosure.parameters import Numerics
from jointclosure.statistics.standard_errors import percent, significant

WAVELENGTHS, STRENGTHS = 8, 4
"""Number of wavelengths, and of strengths, at which joints are closed."""
STRENGTH_RANGE = (0.5, 2.0)
"""Range of fitted strengths, over the given strength."""
DOUBTFUL = 0.01
"""Smallest p-value for which a mismatch wavelength explains the curve."""
_CHECK = "check rock, roughness, roll-off, size and units"


class Fit(NamedTuple):
    """Fit of a joint to a measured curve.

    ``mismatch_wavelength`` [m], with the ends of its 95 % interval: 0 if mated walls are not
    excluded, infinite if independent walls are not; of scanned walls it is the measured one.
    ``compressive_strength`` [Pa]: None if it was not fitted. ``p_value``: probability that such a
    joint is at least as far from their mean as the measured one. ``measured`` and ``simulated``:
    readings of the curve and of the joints. ``assumed``: description of the joints, for which alone
    intervals are valid. ``closure_error``: relative error of measured closures. ``scanned``:
    whether the walls are scanned. ``numerical``: relative changes by a finer tolerance, with
    standard errors, of quantities of the nearest joints; empty if the joints were given.
    """

    mismatch_wavelength: Interval
    compressive_strength: Interval | None
    p_value: float
    measured: Readings
    simulated: Simulated
    likelihood: Likelihood
    assumed: str
    closure_error: float = 0.02
    curve: MeasuredCurve | None = None
    scanned: bool = False
    numerical: Mapping[str, tuple[float, float]] = {}

    @property
    def interval_holds(self) -> bool:
        """Whether the model explains the curve, so that intervals are valid."""
        return self.p_value >= DOUBTFUL

    @property
    def reached(self) -> bool:
        """Whether the model explains the curve, and joints have all first-loading readings."""
        return self.interval_holds and not self._missed_first_loading()

    def sentences(self) -> list[str]:
        """Describe the estimates, or that the model does not explain the curve, and assumptions."""
        wavelength, strength = self.mismatch_wavelength, self.compressive_strength
        if not self.interval_holds:
            ends = {0.0: "mates", math.inf: "independent walls"}
            between = f"walls of a mismatch wavelength of {1e3 * wavelength.value:.3g} mm"
            nearest = [f"nearest are {ends.get(wavelength.value, between)}"] * (not self.scanned)
            compared = [*self._compared(), *numerical_sentence(self.numerical)]
            return [self._unexplained(), *nearest, *compared, f"assumed: {self.assumed}"]
        lines: list[str] = []
        if missed := self._missed_first_loading():
            text = (
                f"no simulated joint has the measured {' or the '.join(missed)}: the interval is "
            )
            lines.append(caution(f"{text}that of the nearest joints; {_CHECK}"))
        if not self.scanned:
            lines.append(f"mismatch wavelength {_stated(wavelength, 1e3, 'mm')}")
        if strength is not None:
            tried = self.likelihood.strengths[[0, -1]]
            lines.append(f"compressive strength {_stated(strength, 1e-6, 'MPa', *tried)}")
        if math.isinf(wavelength.high) and not self.scanned:
            lines.append("independent walls are not excluded")
        if wavelength.low == 0.0 and not self.scanned:
            lines.append("mated walls are not excluded")
        far = "of such joints are at least as far from their mean as the measured one"
        lines += [f"{percent(self.p_value)} {far}", *self._compared()]
        lines += numerical_sentence(self.numerical)
        return [*lines, f"valid only for the assumed joint: {self.assumed}"]

    def agreements(self) -> list[Agreement]:
        """Compare closure, stiffness and what stays with single joints, each by itself."""
        return agreements(self.measured, self.simulated.logs, self.likelihood, self.closure_error)

    def _missed_first_loading(self) -> list[str]:
        """Return readings of the first loading that no joint has, in words."""
        return [each.name for each in self.agreements() if each.first_loading and each.missed]

    def _compared(self) -> list[str]:
        """Describe at which wavelengths, or strengths of scanned walls, a reading is met."""
        tried = self.likelihood.strengths if self.scanned else self.likelihood.wavelengths
        scale, unit, what = 1e3, "mm", "mismatch wavelengths"
        if self.scanned:
            scale, unit, what = 1e-6, "MPa", "strengths"
        lines = []
        for one in self.agreements():
            value, least, most = (significant(x, 3) for x in (one.measured, one.least, one.most))
            low, high = (f"{scale * end:.3g}" for end in (one.low, one.high))
            low += " or less" if one.low == tried[0] else ""
            high += f" {unit} or more" if one.high == tried[-1] else f" {unit}"
            where = f"joints have it at {what} from {low} to {high}"
            if one.missed:
                where = f"no joint has it, the nearest have {least} to {most} {one.unit}"
            lines.append(f"{one.name}, measured {value} {one.unit}: {where}")
        return lines

    def _unexplained(self) -> str:
        """Warn that the model does not explain the curve."""
        often = self.p_value > 1e-3
        seldom = f"about 1 in {1.0 / self.p_value:.0f}" if often else "fewer than 1 in 1000"
        text = (
            f"the model does not explain this curve: {seldom} of its joints are as far "
            f"from their mean, and no interval is valid; {_CHECK}"
        )
        others = any(not one.first_loading for one in self.agreements())
        if others and not self._missed_first_loading():
            text += (
                "; joints have each reading of the first loading, which first_loading=True "
                "(--first-loading) fits alone"
            )
        return caution(text)

    def __repr__(self) -> str:
        return f"<Fit: {'; '.join(self.sentences())}>"


@takes_joint
def fit(
    curve: str | Path | MeasuredCurve,
    *,
    fit_strength: bool = False,
    first_loading: bool = False,
    numerics: Numerics = RESOLVED,
    simulated: Simulated | None = None,
    cache: str | Path | None = None,
    workers: int | None = None,
    progress: bool = False,
    **joint: Unpack[JointKeywords],
) -> Fit:
    """Estimate the mismatch wavelength of a joint from its measured closure, or its strength.

    Parameters
    ----------
    curve : path or MeasuredCurve
        CSV with columns stress and closure, in the units of their names (stress_MPa, closure_mm)
        or in those given here, in the order of measurement; and cycle, if there are several, all to
        one largest stress. Closures are those of the joint, without the intact rock's deformation.
    fit_strength : bool
        Whether to fit the compressive strength too, from half to twice that of the rock. Joints are
        closed at 8 wavelengths from two spacings to the shorter side, and at 4 strengths if these
        are fitted. Of scanned walls the strength alone is fitted.
    first_loading : bool
        Whether to fit the loading of the first cycle alone. Many joints lose more closure than the
        model lets them, which their unloading and later cycles show.
    numerics
        As for `jointclosure.simulate`; by default breakage is resolved, as by `jointclosure.close`.
    simulated : Simulated, optional
        Joints of a fit with the same arguments to another curve, of the same cycles and stresses,
        which are then not closed again.
    cache : path, optional
        Folder where closed joints are kept; a run with the same joints closes only what is missing.
    workers : int, optional
        Number of processes, by default that of the processors available to this process. It does
        not affect the result.
    progress : bool
        Whether to print what is assumed before joints are closed, and to show the progress.
    **joint
        Fields of `jointclosure.measured.joints.MeasuredJoint`: rock, roughness or scans, size.

    Raises
    ------
    InputError
        If a file cannot be read as a curve, or a number is out of its range.

    Notes
    -----
    See `jointclosure.measured.calibration`: the likelihood is from the scatter of joints, and
    assumes that the model is right and that rock, roughness and size are known. Closures of the
    model are net of the indentation of the half-spaces
    (`jointclosure.joint.curves.read_along`).
    """
    given = asked_joints(curve, joint, "fit", WAVELENGTHS, first_loading)
    measured, wavelengths, pair = given.measured, given.wavelengths, given.pair
    fit_strength = fit_strength or pair is not None
    usual = given.rock.compressive_strength
    ends = [factor * usual for factor in (STRENGTH_RANGE if fit_strength else (1.0,))]
    assumed = given.assumed(ends) + ("; only the first loading is fitted" if first_loading else "")
    if progress and pair is not None:
        print("\n".join(f"- {line}" for line in pair.report))
    elif progress:
        print(f"assumed (--jrc, --size or --cells, --spacing and others change it): {assumed}")
    conditions = first_conditions(given, numerics)
    conditions.checked()
    factors = np.geomspace(*STRENGTH_RANGE, STRENGTHS) if fit_strength else np.ones(1)
    strengths = usual * factors
    surfaces, closure_error = given.joint.surfaces, given.joint.closure_error
    check_joints(given, strengths.size)
    closing = Closing(
        conditions, measured.cycles, tuple(strengths.tolist()), stresses_of(measured),
        (surfaces * strengths.size, surfaces, 1),
    )  # fmt: skip
    report = partial(print, flush=True) if progress else lambda line: None
    joints = Joints(closing, given, cache, workers, report)
    closures, stresses = None, np.array(closing.stresses)
    if simulated is None:
        closures = joints.closures()
        logs = logs_of(closures[0], stresses, measured)
        simulated = Simulated(logs, (closures - closures[..., :1, :1])[0], stresses)
    expected = wavelengths.size, strengths.size, surfaces, measured.values.size
    if simulated.logs.shape != expected:
        raise InputError(f"simulated: of shape {simulated.logs.shape}, must be {expected}")
    likelihood = likelihood_of(measured, simulated.logs, wavelengths, strengths, closure_error)
    wavelength = likelihood.interval(0) if pair is None else Interval(*pair.mismatch)
    strength = likelihood.interval(1) if fit_strength else None
    changes: Mapping[str, tuple[float, float]] = {}
    if closures is not None:
        nearest = divmod(int(likelihood.log.argmax()), likelihood.strengths.size)
        place = 0, *tried_places(nearest, likelihood, expected[:2])
        changes = joints.numerical_changes(place, closures)
    of_joints = measured, simulated, likelihood, assumed, closure_error, given.curve
    return Fit(wavelength, strength, likelihood.p_value, *of_joints, bool(pair), changes)


def _stated(
    interval: Interval, scale: float, unit: str, least: float = 0.0, most: float = math.inf
) -> str:
    """Format an estimate with its interval in a unit, and whether it is at an end of the range."""
    value, low, high = (f"{scale * part:.3g}" for part in interval)
    if interval.low <= least and interval.high >= most:
        return "is not bounded: no simulated value is excluded"
    at_end = "95 % interval; the most likely value is at the end of the simulated range"
    if interval.value <= least:
        return f"below {high} {unit} ({at_end})"
    if interval.value >= most:
        return f"above {low} {unit} ({at_end})"
    low += " or less" if 0.0 < interval.low <= least else ""
    high += " or more" if interval.high >= most else ""
    high = high if math.isfinite(interval.high) else "no end"
    return f"{value} {unit} (95 % interval {low} to {high})"

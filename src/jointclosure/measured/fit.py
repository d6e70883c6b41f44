"""Fit of a joint to its measured closure: mismatch wavelength, or strength of scanned walls."""

import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple, Unpack

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.inputs.keywords import takes
from jointclosure.inputs.remarks import caution
from jointclosure.measured.compared_quantities import about_share, prediction_intervals
from jointclosure.measured.curves import MeasuredCurve
from jointclosure.measured.joint_arguments import JointKeywords, MeasuredJoint, asked_joints
from jointclosure.measured.likelihood import (
    Interval,
    Likelihood,
    Readings,
    Simulated,
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
from jointclosure.parameters import RESOLVED, Numerics
from jointclosure.statistics.number_texts import percent, significant

WAVELENGTHS = 8  # mismatch wavelengths at which joints are simulated
STRENGTHS = 4  # strengths at which joints are simulated, if they are fitted
STRENGTH_RANGE = (0.5, 2.0)
"""Range of fitted strengths, over the given strength."""
DOUBTFUL = 0.01
"""Smallest p-value with which the model is taken to explain a measured curve."""


class Agreement(NamedTuple):
    """Range of the fitted parameter at which simulated joints have one measured quantity."""

    name: str
    unit: str
    measured: float
    low: float  # wavelength [m], or strength [Pa] if the wavelength is known; NaN if there is none
    high: float
    least: float  # ends of the 95 % interval of a single joint nearest to the measured value
    most: float
    first_loading: bool

    @property
    def missed(self) -> bool:
        """Whether the measured quantity is outside of the intervals at all tried values."""
        return math.isnan(self.low)


class Fit(NamedTuple):
    """Fit of a joint to a measured closure curve, as `jointclosure.fit` returns it.

    Its intervals are valid only for the joint that is described by ``assumed``, and only if the
    model explains the curve (`interval_holds`).
    """

    mismatch_wavelength: Interval  # [m], 95 %: from 0 mates, to infinity independent, are allowed
    compressive_strength: Interval | None  # [Pa]
    p_value: float  # probability that such a joint is as far from their mean as the measured one
    measured: Readings
    simulated: Simulated
    likelihood: Likelihood
    assumed: str
    closure_error: float  # relative
    curve: MeasuredCurve
    scanned: bool
    numerical: Mapping[str, tuple[float, float]]  # as from `ComparisonJoints.numerical_changes`

    @property
    def interval_holds(self) -> bool:
        """Whether the model explains the curve, so that intervals are valid."""
        return self.p_value >= DOUBTFUL

    @property
    def reached(self) -> bool:
        """Whether the model explains the curve, and joints have all quantities of first loading."""
        return self.interval_holds and not self._missed_first_loading()

    def sentences(self) -> list[str]:
        """Return the sentences on a fit: estimates, agreement with the curve, and assumptions.

        If the model does not explain the curve, a caution stands in place of the estimates.
        """
        wavelength = self.mismatch_wavelength
        strength = self.compressive_strength
        compared = [*self._agreement_sentences(), ABOUT_RANGES, *numerical_sentence(self.numerical)]
        compared += reading_sentences(self.curve, self.measured, self.closure_error)
        missed = self._missed_first_loading()
        if not self.interval_holds:
            ends = {0.0: "mated walls", math.inf: "independent walls"}
            between = f"walls of a mismatch wavelength of {1e3 * wavelength.value:.3g} mm"
            which = ends.get(wavelength.value, between)
            nearest = [f"the likeliest of the simulated joints have {which}"] * (not self.scanned)
            return [
                self._unexplained_caution(missed),
                *nearest,
                *compared,
                f"assumed: {self.assumed}",
            ]
        lines: list[str] = []
        if missed:
            which = f"no simulated joint has the measured {' or the '.join(missed)}"
            likeliest = "the interval is that of the likeliest joints"
            lines.append(caution(f"{which}: {likeliest}; {ADVICE}"))
        if not self.scanned:
            lines.append(f"mismatch wavelength {_formatted_estimate(wavelength, 1e3, 'mm')}")
        if strength is not None:
            tried = self.likelihood.strengths[[0, -1]]
            lines.append(
                f"compressive strength {_formatted_estimate(strength, 1e-6, 'MPa', *tried)}"
            )
        if not self.scanned:
            lines += ["independent walls are not excluded"] * math.isinf(wavelength.high)
            lines += ["mated walls are not excluded"] * (wavelength.low == 0.0)
        far = "of such joints are at least as far from their mean as the measured one"
        lines += [f"{percent(self.p_value)} {far}", *compared]
        return [*lines, f"valid only for the assumed joint: {self.assumed}"]

    def agreements(self) -> list[Agreement]:
        """Return at which values of the fitted parameter joints have each measured quantity.

        The parameter is the mismatch wavelength, or the strength for scanned walls; the other one
        of the two has its most likely value. A joint has a quantity if the measured value is within
        the 95 % interval of a single joint.
        """
        axis = int(self.scanned)
        logs = self.simulated.logs
        likelihood = self.likelihood
        fine = (likelihood.wavelengths, likelihood.strengths)[axis]
        other = likelihood.nodes(likelihood.best, logs.shape[:2])[1 - axis]
        joints = np.exp(logs.take(other, axis=1 - axis))
        result = []
        nodes = np.linspace(0.0, 1.0, len(joints))
        at = np.linspace(0.0, 1.0, fine.size)
        for one, *ends in prediction_intervals(self.measured, joints, self.closure_error):
            value = float(one.values)
            least, most = (np.interp(at, nodes, end) for end in ends)
            apart = np.maximum(np.maximum(least - value, value - most), 0.0)
            within = np.flatnonzero(apart == 0.0)
            nearest = int(apart.argmin())
            low, high = fine[within[[0, -1]]].tolist() if within.size else (math.nan, math.nan)
            result.append(Agreement(
                one.name, one.unit, value, low, high,
                float(least[nearest]), float(most[nearest]), one.first_loading,
            ))  # fmt: skip
        return result

    def _missed_first_loading(self) -> list[str]:
        """Return the names of the quantities of the first loading that no simulated joint has."""
        return [each.name for each in self.agreements() if each.first_loading and each.missed]

    def _agreement_sentences(self) -> list[str]:
        """Return a sentence on each measured quantity, with the values at which joints have it.

        They are mismatch wavelengths, or strengths for scanned walls.
        """
        likelihood = self.likelihood
        what, tried, scale, unit = (
            ("mismatch wavelengths", likelihood.wavelengths, 1e3, "mm"),
            ("strengths", likelihood.strengths, 1e-6, "MPa"),
        )[self.scanned]
        lines = []
        for one in self.agreements():
            value, least, most = (significant(x, 3) for x in (one.measured, one.least, one.most))
            low, high = (f"{scale * end:.3g}" for end in (one.low, one.high))
            low += " or less" if one.low == tried[0] else ""
            high += f" {unit} or more" if one.high == tried[-1] else f" {unit}"
            where = f"reached by simulated joints at {what} of {low} to {high}"
            if one.missed:
                where = "reached by no simulated joint; those whose values come nearest to it have "
                where += f"{least} to {most}"
                where += f" {one.unit}".removesuffix(" 1") + about_share(one.unit, one.least)
            value += f" {one.unit}".removesuffix(" 1")
            lines.append(f"{one.name}, measured {value}: {where}")
        return lines

    def _unexplained_caution(self, missed: list[str]) -> str:
        """Return the caution that the model does not explain the curve, and what to check.

        ``missed`` are the quantities of the first loading that no joint has.
        """
        beyond = (
            f"{100.0 * (1.0 - self.p_value):.3g} %" if self.p_value > 1e-3 else "more than 99.9 %"
        )
        text = (
            f"the model does not explain this curve, which is farther from the mean of the "
            f"simulated joints than {beyond} of them are, and no interval is valid; {ADVICE}"
        )
        if not missed and not all(one.first_loading for one in self.agreements()):
            text += (
                "; joints have each reading of the first loading, which first_loading=True "
                "(--first-loading) fits alone"
            )
        return caution(text)

    def __repr__(self) -> str:
        return f"<Fit: {'; '.join(self.sentences())}>"


@takes(MeasuredJoint)
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
        simulated at 8 wavelengths from two spacings to the shorter side, and at 4 strengths if
        these are fitted. For scanned walls the strength alone is fitted.
    first_loading : bool
        Whether to fit the loading of the first cycle alone. Many joints have larger permanent
        closures than in the model, which affects their unloading and later cycles.
    numerics
        As for `jointclosure.simulate`; by default breakage is resolved, as by `jointclosure.close`.
    simulated : Simulated, optional
        Joints of a fit with the same arguments to another curve, of the same cycles and stresses,
        which are then not simulated again.
    cache : path, optional
        Folder where simulated joints are kept. A run with the same joints simulates only those that
        are missing.
    workers : int, optional
        Number of processes, by default that of the processors available to this process. It does
        not affect the result.
    progress : bool
        Whether to print the assumptions before joints are simulated, and to show the progress.
    **joint
        Fields of `jointclosure.measured.joint_arguments.MeasuredJoint`: rock, roughness or scans,
        size.

    Returns
    -------
    Fit
        Estimates with 95 % intervals, the p-value of the curve, and the simulated joints.
        ``sentences`` describes the result.

    Raises
    ------
    InputError
        If a file cannot be read as a curve, a number is out of its range, or too few joints could
        be read.
    TypeError
        If a keyword is unknown, or the rock is missing.

    Notes
    -----
    See `jointclosure.measured.likelihood`: the likelihood is from the scatter of joints, and
    assumes that the model is right and that rock, roughness and size are known. Closures of the
    model are net of the indentation of the half-spaces
    (`jointclosure.joint.history.History.net`).
    """
    given = asked_joints(curve, joint, "fit", WAVELENGTHS, first_loading)
    measured = given.measured
    wavelengths = given.wavelengths
    pair = given.pair
    fit_strength = fit_strength or pair is not None
    usual = given.rock.compressive_strength
    surfaces = given.joint.surfaces
    strengths = usual * (np.geomspace(*STRENGTH_RANGE, STRENGTHS) if fit_strength else np.ones(1))
    assumed = given.assumed(np.unique(strengths[[0, -1]]).tolist())
    assumed += "; only the first loading is fitted" if first_loading else ""
    if progress and pair is not None:
        print("\n".join(f"- {line}" for line in pair.remarks))
    elif progress:
        print(f"assumed (--jrc, --size or --cells, --spacing and others change it): {assumed}")
    joints = ComparisonJoints(
        given, given.conditions(numerics), tuple(strengths.tolist()),
        (surfaces * strengths.size, surfaces, 1), (LaterLoading(),), cache, workers,
        partial(print, flush=True) if progress else lambda line: None,
    )  # fmt: skip
    joints.check([usual])
    closures = None
    if simulated is None:
        closures = joints.closures()
        net = (closures - closures[..., :1, :1])[0]
        logs = log_readings(closures[0], joints.stresses, measured)
        simulated = Simulated(logs, net, joints.stresses)
    expected = wavelengths.size, strengths.size, surfaces, measured.values.size
    if simulated.logs.shape != expected:
        raise InputError(f"simulated: of shape {simulated.logs.shape}, must be {expected}")
    error = given.joint.closure_error
    likelihood = likelihood_of(measured, simulated.logs, wavelengths, strengths, error)
    wavelength = likelihood.interval(0) if pair is None else Interval(*pair.mismatch)
    strength = likelihood.interval(1) if fit_strength else None
    changes: Mapping[str, tuple[float, float]] = {}
    if closures is not None:
        place = likelihood.nodes(likelihood.best, expected[:2])
        changes = joints.numerical_changes((0, *place), closures)
    return Fit(
        mismatch_wavelength=wavelength,
        compressive_strength=strength,
        p_value=likelihood.p_value,
        measured=measured,
        simulated=simulated,
        likelihood=likelihood,
        assumed=assumed,
        closure_error=error,
        curve=given.curve,
        scanned=bool(pair),
        numerical=changes,
    )


def _formatted_estimate(
    interval: Interval, scale: float, unit: str, least: float = 0.0, most: float = math.inf
) -> str:
    """Format an estimate with its 95 % interval in a unit, such as "12 mm (95 % interval ...)".

    Values are multiplied by ``scale``. ``least`` and ``most`` are the ends of the simulated range:
    an estimate at one of them is given as a bound, an interval over all as "not bounded".
    """
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

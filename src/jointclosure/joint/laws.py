"""Empirical laws of closure fitted to a joint's curves, with their errors and ranges.

Closure D is net and counts from the seating stress s, as in laboratories. Hyperbolic (Bandis,
Lumsden & Barton 1983): sigma - s = kni D/(1 - D/Vm); semi-logarithmic (Bandis et al. 1983,
mismatched joints): log10(sigma) = p + q D; power (Swan 1983): D = c (sigma - s)^m. The law of
Barton and Bandis for mated joints is there for comparison; it is not measured data.
"""

import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from jointclosure.inputs import InputError, check_length
from jointclosure.joint.history import history_of
from jointclosure.joint.status import BRANCHES, LOADING

POINTS = 60  # evenly spaced stresses at which a law is fitted, with equal weights
BENDS = 10.0
"""Largest Vm of a hyperbola over the largest closure; a curve does not determine a larger Vm.

At that ratio the curve ends at a tenth of Vm, and its stiffness has increased by a quarter there.
"""
_STRAIGHT = 1e3  # largest Vm in a fit over the largest closure, for curves straighter than that
FAILS = 0.05  # largest error of a law within its range, over the largest closure
_COLUMNS = [
    *("cycle", "branch", "law", "parameter", "value", "standard_error"),
    *("r_squared", "rms_mm", "holds_from_MPa", "holds_to_MPa"),
]


class Law(NamedTuple):
    """Empirical law of closure over stress, which `fit_law` fits.

    ``parameters`` are names and units of the law's parameters, by their columns in tables.
    ``closure(stress, seating, *parameters)`` is the closure [mm] since a seating stress [MPa], at
    stresses [MPa]. ``guess(stress, closure, seating)`` are the parameters from which the fit
    starts.
    """

    parameters: dict[str, tuple[str, str]]
    closure: Callable[..., np.ndarray]
    guess: Callable[..., Any]


def _hyperbola(stress: np.ndarray, seating: float, kni: float, vm: float) -> np.ndarray:
    above = stress - seating
    return above * vm / (kni * vm + above)


def _guess_hyperbola(stress, closure, seating) -> tuple[float, ...]:
    # (sigma - s)/D = kni + (sigma - s)/Vm is a straight line
    known = (stress > seating) & (closure > 0.0)
    if known.sum() < 2:
        raise ValueError("too few points")
    above = stress[known] - seating
    slope, kni = np.polyfit(above, above / closure[known], 1)
    return max(kni, 1e-9), 1.0 / max(slope, 1e-9)


def _guess_power(stress, closure, seating) -> tuple[float, ...]:
    known = (stress > seating) & (closure > 0.0)
    m, c = np.polyfit(np.log(stress[known] - seating), np.log(closure[known]), 1)
    return float(np.exp(c)), m


_KNI, _VM = ("initial stiffness kni", "MPa/mm"), ("largest closure Vm", "mm")
LAWS = {
    "hyperbolic": Law({"kni_MPa_per_mm": _KNI, "vm_mm": _VM}, _hyperbola, _guess_hyperbola),
    "semi_logarithmic": Law(
        {"p": ("p", "log10 MPa"), "q_per_mm": ("q", "1/mm")},
        lambda stress, seating, p, q: (np.log10(stress) - p) / q,
        lambda stress, closure, seating: np.polyfit(closure, np.log10(stress), 1)[::-1],
    ),
    "power": Law(
        {"c_mm": ("c", "mm/MPa^m"), "m": ("m", "")},
        lambda stress, seating, c, m: c * (stress - seating) ** m,
        _guess_power,
    ),
}


def law_curves(joint: xr.Dataset) -> dict[tuple[int, str], tuple[np.ndarray, np.ndarray]]:
    """Read stresses (n,) [MPa] and net closures since seating (n,) [mm], by (cycle, branch).

    Loadings beyond a former maximum are left out, and so are branches that do not reach all
    stresses.
    """
    history = history_of(joint)
    read = {}
    for index, cycle in enumerate(history.cycles):
        levels = history.stress_levels(POINTS, cycle.number)
        closures = history.net.at(levels)[index]
        for branch, closure in zip(cycle.branches, closures, strict=True):
            loads = branch.name == LOADING
            beyond = loads and history.former_maxima[index] > 0.0
            if beyond or not np.isfinite(closure).all():
                continue
            # without a seating stress: since the start of a loading, or the end of an unloading
            end = branch.steps[0 if loads else -1]
            start = closure[0] if history.seating_stress > 0.0 else history.net.values[end]
            read[cycle.number, branch.name] = 1e-6 * levels, 1e3 * (closure - start)
    return read


def fitted_laws(
    joint: xr.Dataset, laws: Sequence[str] = tuple(LAWS), branches: Sequence[str] = BRANCHES
) -> pd.DataFrame:
    """Fit laws to each cycle and branch by least squares of closure; return a row per parameter.

    ``joint`` is a Dataset of `simulate` or `close`. ``laws`` are names of `LAWS`, ``branches``
    names of `BRANCHES`. The columns are `_COLUMNS`; the errors and the range of a fit are as in
    `fit_law`.
    """
    seating = 1e-6 * history_of(joint).seating_stress
    rows = []
    for (cycle, branch), (stress, closure) in law_curves(joint).items():
        for name in laws if branch in branches else ():
            law = LAWS[name]
            values, errors, fit = fit_law(law, stress, closure, seating)
            about = {"cycle": cycle, "branch": branch, "law": name}
            rows += [
                about | {"parameter": parameter, "value": value, "standard_error": error} | fit
                for parameter, value, error in zip(law.parameters, values, errors, strict=True)
            ]
    return pd.DataFrame(rows, columns=_COLUMNS)


def fit_law(law: Law, stress: np.ndarray, closure: np.ndarray, seating: float):
    """Fit a law to closures (n,) [mm] since a seating stress [MPa], at stresses (n,) [MPa].

    Return the values of its parameters, their standard errors, and the quality of the fit by
    column: ``r_squared``, the root mean square error ``rms_mm``, and the range of stress in which
    the law holds. It is the longest run of stresses at which the error is at most `FAILS` of the
    largest closure. All are NaN if the law cannot be fitted.

    kni or Vm of a hyperbola is undetermined, and NaN, if its standard error exceeds it. Vm is so
    too if it exceeds `BENDS` times the largest closure, because the curve does not bend.
    """

    def predicted(stress: np.ndarray, *parameters: float) -> np.ndarray:
        return law.closure(stress, seating, *parameters)

    names = _COLUMNS[-4:]
    try:
        with warnings.catch_warnings():  # errors that cannot be estimated are infinite
            warnings.simplefilter("ignore", scipy.optimize.OptimizeWarning)
            start = law.guess(stress, closure, seating)
            fitted = scipy.optimize.curve_fit(predicted, stress, closure, start, maxfev=20_000)
            most = np.array([np.inf, _STRAIGHT * closure.max()])
            if law.closure is _hyperbola and not ((fitted[0] > 0.0) & (fitted[0] <= most)).all():
                bounds = np.zeros(2), most  # straighter than any hyperbola
                start = tuple(np.clip(start, 1e-9, 0.5 * bounds[1]))
                fitted = scipy.optimize.curve_fit(predicted, stress, closure, start, bounds=bounds)
    except (RuntimeError, ValueError, np.linalg.LinAlgError):  # a law that cannot be fitted has NaN
        nothing = np.full(len(law.parameters), np.nan)
        return nothing, nothing, dict.fromkeys(names, np.nan)
    values, covariance = fitted
    miss = predicted(stress, *values) - closure
    square = float(np.sum(miss**2))
    held, _ = scipy.ndimage.label(np.abs(miss) <= FAILS * closure.max())
    runs = (run for (run,) in scipy.ndimage.find_objects(held))
    longest = max(runs, key=lambda run: run.stop - run.start, default=None)
    explained = 1.0 - square / float(np.sum((closure - closure.mean()) ** 2))
    ends = stress[longest][[0, -1]].tolist() if longest else (np.nan, np.nan)
    fit = explained, float(np.sqrt(square / closure.size)), *ends
    errors = np.sqrt(np.diag(covariance))
    if law.closure is _hyperbola:
        most = np.array([np.inf, BENDS * closure.max()])
        values[~((errors < values) & (values <= most))] = np.nan
        errors[np.isnan(values)] = np.nan
    return values, errors, dict(zip(names, fit, strict=True))


def loading_hyperbolas(joint: xr.Dataset, cycles: Iterable[int]) -> pd.DataFrame:
    """Return ``kni_MPa_per_mm`` and ``vm_mm`` of the hyperbola of each loading, a row per cycle.

    They are NaN in cycles whose loading was not fitted.
    """
    fits = fitted_laws(joint, ["hyperbolic"], [LOADING])
    values = {name: rows.set_index("cycle").value for name, rows in fits.groupby("parameter")}
    return pd.DataFrame(values, list(cycles), list(LAWS["hyperbolic"].parameters), dtype=float)


class BartonBandis(NamedTuple):
    """Law of Barton and Bandis for the closure of a joint in one cycle.

    Its constants are the mechanical ``aperture`` a_j [m], the ``largest_closure`` V_m [m], and the
    ``initial_stiffness`` K_ni [Pa/m].
    """

    aperture: float
    largest_closure: float
    initial_stiffness: float

    def closure(self, normal_stress: float | np.ndarray) -> Any:
        """Return the law's closure [m] at stresses sigma [Pa], sigma V_m / (K_ni V_m + sigma)."""
        stress = np.asarray(normal_stress, dtype=float)
        return _hyperbola(stress, 0.0, self.initial_stiffness, self.largest_closure)

    def since(self, normal_stress: float) -> "BartonBandis":
        """Return this law with stress and closure counted from a normal stress [Pa], not from 0."""
        rise = 1.0 + normal_stress / (self.initial_stiffness * self.largest_closure)
        left = self.largest_closure - float(self.closure(normal_stress))
        return BartonBandis(self.aperture, left, self.initial_stiffness * rise**2)

    def results(self, normal_stress: float, seating: float = 0.0) -> dict[str, float]:
        """Return the law's results of a loading to a normal stress [Pa], by names as of the model.

        They are K_ni [Pa/m], V_m [m], the chord stiffness [Pa/m] from half of the stress to the
        stress, and the closure [m] at the stress. The law counts from the ``seating`` stress [Pa].
        """
        half, whole = self.closure(np.array([0.5, 1.0]) * normal_stress - seating)
        return {
            "kni_net": self.initial_stiffness,
            "vm_net": self.largest_closure,
            "stiffness_net": 0.5 * normal_stress / float(whole - half),
            "max_closure_seated_net": float(whole),
        }


# A, B, C, D of V_m = A + B JRC + C (JCS/a_j)^D [mm, MPa]. Those of cycle 3 stand in `bartonBandis`
# of the MATLAB Reservoir Simulation Toolbox too; those of cycle 2 are quoted from memory, and no
# public source of them was seen.
_CONSTANTS = {
    1: (-0.2960, -0.0056, 2.2410, -0.2450),
    2: (-0.1005, -0.0073, 1.0082, -0.2301),
    3: (-0.1032, -0.0074, 1.1350, -0.2510),
}
CYCLES = tuple(_CONSTANTS)


LAB_LENGTH = 0.1
"""Usual length [m] of laboratory joints, to which JRC0 and JCS0 refer: that of the profiles of
Barton & Choubey (1977)."""


def scaled_to(
    length: float, jrc: float, strength: float, lab_length: float = LAB_LENGTH
) -> tuple[float, float]:
    """Return JRC and JCS [Pa] of a joint of a ``length`` [m] from those of a laboratory joint.

    ``jrc`` JRC_0 and ``strength`` JCS_0 [Pa] are those of a joint of ``lab_length`` [m]. Barton &
    Bandis 1982, 1990 (Eqs. 9, 10): JRC_n = JRC_0 (L_n/L_0)^(-0.02 JRC_0) and JCS_n = JCS_0
    (L_n/L_0)^(-0.03 JRC_0).
    """
    ratio = length / lab_length
    return jrc * ratio ** (-0.02 * jrc), strength * ratio ** (-0.03 * jrc)


def check_joint_lengths(joint_length: float | None = None, lab_length: float = LAB_LENGTH) -> None:
    """Raise `InputError` unless the lengths [m] of a joint and of the laboratory joint are allowed.

    It is raised also if the joint is shorter than the laboratory joint, because JRC and JCS are
    scaled to longer joints only. A ``joint_length`` of None is not checked.
    """
    check_length("lab_length", lab_length)
    if joint_length is None:
        return
    check_length("joint_length", joint_length)
    if joint_length < lab_length:
        raise InputError(
            f"joint_length = {1e3 * joint_length:g} mm: must be at least lab_length = "
            f"{1e3 * lab_length:g} mm, as JRC and JCS are scaled to longer joints only"
        )


def law_holds(jrc: float) -> bool:
    """Return whether a JRC is in the range of the law of Barton and Bandis, 5 to 15."""
    return 5.0 <= jrc <= 15.0


def barton_bandis(
    jrc: float, compressive_strength: float, strength_ratio: float, cycle: int
) -> BartonBandis:
    """Return the law of Barton and Bandis of a joint in one of `CYCLES`, from zero stress.

    ``compressive_strength`` is sigma_c [Pa], ``strength_ratio`` sigma_c/JCS. Bandis, Lumsden &
    Barton 1983 and Barton, Bandis & Bakhtar 1985: a_j = (JRC/5)(0.2 sigma_c/JCS - 0.1) mm, K_ni =
    -7.15 + 1.75 JRC + 0.02 JCS/a_j MPa/mm, V_m as for `_CONSTANTS`. No range is checked
    (`law_holds`).
    """
    a, b, c, d = _CONSTANTS[cycle]
    wall_strength = compressive_strength / strength_ratio * 1e-6
    aperture = jrc / 5.0 * (0.2 * strength_ratio - 0.1)
    largest = a + b * jrc + c * (wall_strength / aperture) ** d
    stiffness = -7.15 + 1.75 * jrc + 0.02 * wall_strength / aperture
    return BartonBandis(aperture * 1e-3, largest * 1e-3, stiffness * 1e9)


class JointLaws(NamedTuple):
    """Laws of Barton and Bandis of a joint by cycle, counted from the ``seating`` stress [Pa].

    ``jrc`` and ``strength`` are JRC and JCS [Pa] of the laboratory joint, of ``lab_length`` [m].
    With a ``joint_length`` [m] the laws are those of a joint of this length, to which both are
    scaled.
    """

    jrc: float
    strength: float
    seating: float
    by_cycle: dict[int, BartonBandis]
    joint_length: float | None = None
    lab_length: float = LAB_LENGTH

    @property
    def scaled(self) -> tuple[float, float]:
        """JRC and JCS [Pa] of the joint, scaled to its length if this is stated."""
        if self.joint_length is None:
            return self.jrc, self.strength
        return scaled_to(self.joint_length, self.jrc, self.strength, self.lab_length)

    def from_zero(self, cycle: int) -> BartonBandis:
        """Return the law of a cycle with stress and closure counted from zero stress.

        The laws `by_cycle` count from the seating stress.
        """
        jrc, wall_strength = self.scaled
        return barton_bandis(jrc, self.strength, self.strength / wall_strength, cycle)

    def sentence(self) -> str:
        """Describe the laws of Barton and Bandis, and their constants from zero stress."""
        jrc, wall_strength = self.scaled
        at_length = "" if self.joint_length is None else f" at {1e3 * self.joint_length:g} mm"
        is_scaled = bool(at_length)
        at_lab = f"{1e3 * self.lab_length:g} mm"
        if not self.by_cycle:
            left_out = f"Barton-Bandis: left out, as it holds for JRC 5 to 15, not for {jrc:.2g}"
            scaled_from = f"{at_length}, scaled from {self.jrc:.2g} at {at_lab}"
            return left_out + scaled_from if is_scaled else left_out
        strength = f"JCS {1e-6 * wall_strength:.3g} MPa"
        of_lab = ""
        constants = f"JRC {jrc:.2g} (by the slope of both walls) and {strength}, the strength"
        if is_scaled:
            constants = f"JRC {jrc:.2g}{at_length} (scaled) and {strength}"
            of_lab = (
                f"; at the laboratory length of {at_lab} JRC is {self.jrc:.2g} and JCS "
                f"{1e-6 * self.strength:.3g} MPa (scale corrections of Barton & Bandis 1982)"
            )
        first = self.from_zero(1)
        return (
            f"Barton-Bandis: empirical law of mated joints for {constants}, from "
            f"{1e-6 * self.seating:g} MPa on; from 0 MPa on its first cycle has kni "
            f"{1e-9 * first.initial_stiffness:.2g} MPa/mm and Vm "
            f"{1e3 * first.largest_closure:.2g} mm{of_lab}"
        )

    def record(self) -> dict[str, Any]:
        """Return JRC, JCS, lengths and the constants of each cycle, with units in their names.

        The constants of cycles count from zero stress.
        """
        jrc, wall_strength = self.scaled
        record = {
            "jrc": jrc,
            "jcs_MPa": 1e-6 * wall_strength,
            "lab_jrc": self.jrc,
            "lab_jcs_MPa": 1e-6 * self.strength,
            "lab_length_mm": 1e3 * self.lab_length,
            "joint_length_mm": 1e3 * (self.joint_length or self.lab_length),
        }
        return record | {
            f"cycle {cycle}": {
                "kni_MPa_per_mm": 1e-9 * law.initial_stiffness,
                "vm_mm": 1e3 * law.largest_closure,
                "aperture_mm": 1e3 * law.aperture,
            }
            for cycle in self.by_cycle
            for law in [self.from_zero(cycle)]
        }


def laws_of_joint(
    jrc: float,
    strength: float,
    seating: float,
    cycles: int,
    joint_length: float | None = None,
    lab_length: float = LAB_LENGTH,
) -> JointLaws:
    """Return the laws of Barton and Bandis of a joint, from its JRC and compressive strength [Pa].

    JCS is the ``strength``, as of walls that are not weathered. The laws are those of the first
    ``cycles``, at most three, and count from the ``seating`` stress [Pa]. A cycle is left out if
    one of its constants is not positive, and all cycles are if the scaled JRC is out of range
    (`law_holds`). With a ``joint_length`` [m] JRC and JCS are scaled to it from the ``lab_length``
    [m].
    """
    laws = JointLaws(jrc, strength, seating, {}, joint_length, lab_length)
    known = CYCLES[: cycles if law_holds(laws.scaled[0]) else 0]
    of_cycles = {cycle: laws.from_zero(cycle) for cycle in known}
    since = {cycle: law.since(seating) for cycle, law in of_cycles.items() if min(law) > 0.0}
    return laws._replace(by_cycle=since)

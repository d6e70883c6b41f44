"""Hyperbola fitted to a loading, and to the ends of its band of closure, for other programs."""

from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.exports.loading import CHOICES, ENDS, End, known_loadings, loading_by_ending
from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import caution
from jointclosure.joint.history import history_of
from jointclosure.joint.interpolation import cubic_over
from jointclosure.joint.laws import BENDS, LAWS, fit_law, law_curves
from jointclosure.joint.status import LOADING
from jointclosure.statistics.number_texts import percent

_PROGRAMS = "PorePy, UDEC, 3DEC"
"""Programs that receive constants of fitted hyperbolas."""
MISFIT = 0.5
"""Relative difference of the stiffness of a hyperbola from that of the joint, beyond which a
warning says so. A program that receives the hyperbola then has another joint."""


class Hyperbola(NamedTuple):
    """Hyperbola of a loading: kni [Pa/m], Vm [m] and mean aperture at seating [m]."""

    stiffness: float
    largest_closure: float
    aperture: float


def _hyperbolas(
    joint: xr.Dataset, curves: pd.DataFrame, cycle: int
) -> tuple[dict[str, Hyperbola], list[str], dict[str, float]]:
    """Return the hyperbolas of a loading by endings of constants, and remarks on ends without one.

    The last value is how far closures of each hyperbola are off at most, over the largest closure.

    They are net, because programs deform the rock themselves, and count from the seating stress,
    at which all have the aperture of the joint. That of the joint is the one of `fitted_laws`;
    those of a band are fitted at the same stresses. Raise `InputError` if the joint has none.
    """
    history = history_of(joint)
    seating = 1e-6 * history.seating_stress
    law = LAWS["hyperbolic"]
    loadings = loading_by_ending(joint, curves, cycle)
    former = history.former_maxima[cycle - 1]
    if former:
        raise InputError(
            f"the loading of cycle {cycle} goes beyond its former maximum, "
            f"{1e-6 * former:.3g} MPa, which is no hyperbola"
        )
    aperture = 1e3 * history.curve("mean_aperture").seat(cycle, LOADING)
    stress, closure = law_curves(joint)[cycle, LOADING]
    hyperbolas = {}
    misses: dict[str, float] = {}
    remarks: list[str] = []

    def leave_out(end: End, reason: str) -> None:
        """Note why an end of the band has no constants; without those of the joint raise this."""
        if not end.ending:
            raise InputError(reason)
        remarks.append(
            f"{_PROGRAMS}: not written: {end.joint} (end of the band of closure): {reason}"
        )

    for of_band, rows in loadings.items():
        end = ENDS[of_band]
        if rows.closure_net_since_seating_mm.isna().any():  # with other choices of the model
            leave_out(end, "its closure is not known at every stress")
            continue
        more = _difference_at(stress, rows, loadings[""], seating)
        (stiffness, largest), _, _ = fit_law(law, stress, closure + more, seating)
        if not np.isfinite([stiffness, largest]).all():
            reason = (
                f"the loading of cycle {cycle} hardly bends: Vm is undetermined, more than "
                f"{BENDS:g} times its largest closure or less than its standard error"
            )
            if np.isnan(stiffness):
                reason = (
                    f"the loading of cycle {cycle} does not determine kni, which is less than its "
                    "standard error"
                )
            leave_out(end, reason)
            continue
        if not (stiffness > 0.0 and largest > 0.0 and aperture > 0.0):
            leave_out(
                end,
                f"the hyperbola of cycle {cycle} has kni = {stiffness:g} MPa/mm and Vm "
                f"= {largest:g} mm at a mean aperture of {aperture:g} mm: all must be positive",
            )
            continue
        miss = law.closure(stress, seating, stiffness, largest) - (closure + more)
        misses[end.ending] = float(np.abs(miss).max() / (closure + more).max())
        hyperbolas[end.ending] = Hyperbola(1e9 * stiffness, 1e-3 * largest, 1e-3 * aperture)
    return hyperbolas, remarks, misses


class FittedLoading(NamedTuple):
    """Hyperbolas of a loading by endings of constants, or the ``reason`` why the joint has none.

    ``remarks`` name the ends of the band that have none, and state the ``misfit``: how far the
    stiffness of the hyperbola is from that of the joint.
    """

    hyperbolas: dict[str, Hyperbola]
    remarks: list[str]
    reason: str = ""
    misfit: str = ""

    def required_by(self, programs: str) -> dict[str, Hyperbola]:
        """Return the hyperbolas; raise `InputError`, which names programs, if there are none."""
        if self.reason:
            raise InputError(f"{programs}: {self.reason}")
        return self.hyperbolas


def fitted_loading(joint: xr.Dataset, curves: pd.DataFrame, cycle: int) -> FittedLoading:
    """Fit hyperbolas to a loading, and to the ends of its band of closure (`_hyperbolas`)."""
    try:
        hyperbolas, remarks, misses = _hyperbolas(joint, curves, cycle)
    except InputError as error:
        return FittedLoading({}, [], str(error))
    loadings = known_loadings(joint, curves)
    seating = history_of(joint).seating_stress
    misfit, largest = _tangent_misfit(hyperbolas[""], loadings[loadings.cycle == cycle], seating)
    remark = f"{_PROGRAMS}, of cycle {cycle}: the stiffness of the fitted hyperbola {misfit}"
    remark += f"; its closures are off by up to {percent(misses[''])} of the largest"
    if of_choices := [miss for ending, miss in misses.items() if ending.endswith(CHOICES)]:
        remark += f", with other choices of the model by up to {percent(max(of_choices))}"
    if largest > MISFIT:
        remark = caution(
            f"{remark}; joint_stiffness.dat has the stiffness of the joint itself, for programs "
            "that read tables"
        )
    remarks.append(remark)
    return FittedLoading(hyperbolas, remarks, misfit=misfit)


def _difference_at(
    stress: np.ndarray, rows: pd.DataFrame, of_joint: pd.DataFrame, seating: float
) -> np.ndarray:
    """Return how much more an end of a band closes than the joint (n,) [mm] at stresses [MPa]."""
    column = "closure_net_since_seating_mm"
    known = rows.normal_stress_MPa.to_numpy()
    more = (rows[column] - of_joint[column]).to_numpy()
    if seating == 0.0:  # the first known stress is above seating, from which closures count
        known = np.insert(known, 0, 0.0)
        more = np.insert(more, 0, 0.0)
    return cubic_over(known, more - more[0])(np.clip(stress, known[0], known[-1]))


def _tangent_misfit(law: Hyperbola, loading: pd.DataFrame, seating: float) -> tuple[str, float]:
    """Say how far the stiffness of a hyperbola is from that of its loading, above seating [Pa].

    The second value is the largest relative difference [1], 0 where the loading is not known.
    """
    rows = loading[1e6 * loading.normal_stress_MPa > seating]
    rows = rows.dropna(subset="normal_stiffness_net_MPa_per_mm")
    if rows.empty:
        return "is not compared with that of the loading, which is not known", 0.0
    stress = rows.normal_stress_MPa.to_numpy()
    above = 1e6 * stress - seating
    tangent = law.stiffness * (1.0 + above / (law.stiffness * law.largest_closure)) ** 2
    apart = 1e-9 * tangent / rows.normal_stiffness_net_MPa_per_mm.to_numpy() - 1.0
    text = (
        "differs from that of the joint "
        f"(answer.csv) by {percent(apart.min())} to {percent(apart.max())} at {stress.min():.3g} "
        f"to {stress.max():.3g} MPa"
    )
    return text, float(np.abs(apart).max())

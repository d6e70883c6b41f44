"""Hyperbolas fitted to a loading and to the limits of its band of closure, for other programs."""

from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.exports.loading import (
    BAND_LIMITS,
    CHOICES,
    BandLimit,
    known_loadings,
    loading_by_suffix,
)
from jointclosure.inputs import InputError
from jointclosure.inputs.remarks import caution
from jointclosure.joint.history import history_of
from jointclosure.joint.interpolation import cubic_over
from jointclosure.joint.laws import BENDS, LAWS, fit_law, law_curves
from jointclosure.joint.status import LOADING
from jointclosure.statistics.number_texts import percent

_PROGRAMS = "PorePy, UDEC, 3DEC"
"""Programs that receive constants of fitted hyperbolas."""
LARGEST_DIFFERENCE = 0.5
"""Relative difference between a fitted law and the joint, in stiffness or in aperture, above which
the remark on it is a warning: a program that receives such a law has another joint."""


class Hyperbola(NamedTuple):
    """Hyperbola fitted to a loading: kni [Pa/m], Vm [m], and the mean aperture at seating [m]."""

    stiffness: float
    largest_closure: float
    aperture: float


def _hyperbolas(
    joint: xr.Dataset, curves: pd.DataFrame, cycle: int
) -> tuple[dict[str, Hyperbola], list[str], dict[str, float]]:
    """Fit hyperbolas to the loading of a cycle, and to the limits of its band of closure.

    Return the hyperbolas, remarks on the limits of the band that have none, and the closure error
    of each hyperbola: the largest difference of its closures from those to which it was fitted,
    over the largest of these closures [1]. Hyperbolas and errors are by the suffix of the names of
    their constants (`BandLimit.suffix`), which is "" for the joint.

    Closures are net, because the programs deform the rock themselves. They count from the seating
    stress, at which every hyperbola has the mean aperture of the joint. The hyperbola of the joint
    is the one of `fitted_laws`; the limits of the band are fitted at the same stresses.

    Raise `InputError` if the loading does not begin at or below the seating stress, if it goes
    beyond the maximum of a former cycle, or if the joint itself has no hyperbola: kni or Vm is
    undetermined or not positive, or the aperture is not positive.
    """
    history = history_of(joint)
    seating = 1e-6 * history.seating_stress
    law = LAWS["hyperbolic"]
    loadings = loading_by_suffix(joint, curves, cycle)
    former = history.former_maxima[cycle - 1]
    if former:
        raise InputError(
            f"the loading of cycle {cycle} goes beyond its former maximum, "
            f"{1e-6 * former:.3g} MPa, which is no hyperbola"
        )
    aperture = 1e3 * history.curve("mean_aperture").seat(cycle, LOADING)
    stress, closure = law_curves(joint)[cycle, LOADING]
    hyperbolas = {}
    closure_errors: dict[str, float] = {}
    remarks: list[str] = []

    def leave_out(limit: BandLimit, reason: str) -> None:
        """Add a remark on a limit of the band without constants; raise it for the joint itself."""
        if not limit.suffix:
            raise InputError(reason)
        remarks.append(
            f"{_PROGRAMS}: not written: {limit.joint} (end of the band of closure): {reason}"
        )

    for suffix_of_columns, rows in loadings.items():
        limit = BAND_LIMITS[suffix_of_columns]
        if rows.closure_net_since_seating_mm.isna().any():  # with other choices of the model
            leave_out(limit, "its closure is not known at every stress")
            continue
        fitted_to = closure + _difference_from_joint(stress, rows, loadings[""], seating)
        (stiffness, largest), _, _ = fit_law(law, stress, fitted_to, seating)
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
            leave_out(limit, reason)
            continue
        if not (stiffness > 0.0 and largest > 0.0 and aperture > 0.0):
            leave_out(
                limit,
                f"the hyperbola of cycle {cycle} has kni = {stiffness:g} MPa/mm and Vm "
                f"= {largest:g} mm at a mean aperture of {aperture:g} mm: all must be positive",
            )
            continue
        error = law.closure(stress, seating, stiffness, largest) - fitted_to
        closure_errors[limit.suffix] = float(np.abs(error).max() / fitted_to.max())
        hyperbolas[limit.suffix] = Hyperbola(1e9 * stiffness, 1e-3 * largest, 1e-3 * aperture)
    return hyperbolas, remarks, closure_errors


class FittedLoading(NamedTuple):
    """Hyperbolas fitted to a loading, or the ``reason`` why none fits the joint.

    ``hyperbolas`` are by the suffix of the names of their constants, "" for the joint. ``remarks``
    name the limits of the band without a hyperbola, and state how well the hyperbola fits the
    joint. ``stiffness_difference`` says in words how far the stiffness of the hyperbola is from the
    stiffness of the joint. If there is a reason, everything else is empty.
    """

    hyperbolas: dict[str, Hyperbola]
    remarks: list[str]
    reason: str = ""
    stiffness_difference: str = ""

    def required_by(self, programs: str) -> dict[str, Hyperbola]:
        """Return the fitted hyperbolas; if none fits the joint, raise `InputError`.

        The message names the ``programs`` that need the constants, and has the `reason`.
        """
        if self.reason:
            raise InputError(f"{programs}: {self.reason}")
        return self.hyperbolas


def fitted_loading(joint: xr.Dataset, curves: pd.DataFrame, cycle: int) -> FittedLoading:
    """Fit hyperbolas to the loading of a cycle, and to the limits of its band of closure.

    ``curves`` is the `stress_table` of the joint, with bands if they are known. If no hyperbola
    fits the joint, nothing is raised: the result then has the ``reason``.
    """
    try:
        hyperbolas, remarks, closure_errors = _hyperbolas(joint, curves, cycle)
    except InputError as error:
        return FittedLoading({}, [], str(error))
    loadings = known_loadings(joint, curves)
    seating = history_of(joint).seating_stress
    words, largest = _stiffness_difference(
        hyperbolas[""], loadings[loadings.cycle == cycle], seating
    )
    remark = f"{_PROGRAMS}, of cycle {cycle}: the stiffness of the fitted hyperbola {words}"
    remark += f"; its closures are off by up to {percent(closure_errors[''])} of the largest"
    of_choices = [error for suffix, error in closure_errors.items() if suffix.endswith(CHOICES)]
    if of_choices:
        remark += f", with other choices of the model by up to {percent(max(of_choices))}"
    if largest > LARGEST_DIFFERENCE:
        remark = caution(
            f"{remark}; joint_stiffness.dat has the stiffness of the joint itself, for programs "
            "that read tables"
        )
    remarks.append(remark)
    return FittedLoading(hyperbolas, remarks, stiffness_difference=words)


def _difference_from_joint(
    stress: np.ndarray, rows: pd.DataFrame, of_joint: pd.DataFrame, seating: float
) -> np.ndarray:
    """Return the closure of a limit of the band less the closure of the joint (n,) [mm].

    It is a monotone cubic between the stresses of the tables ``rows`` (the limit) and ``of_joint``,
    read at stresses (n,) [MPa] and constant beyond the tables. It is 0 at the first stress of the
    tables, or at a ``seating`` stress [MPa] of 0.
    """
    column = "closure_net_since_seating_mm"
    tabulated = rows.normal_stress_MPa.to_numpy()
    difference = (rows[column] - of_joint[column]).to_numpy()
    if seating == 0.0:  # the first tabulated stress is above seating, from which closures count
        tabulated = np.insert(tabulated, 0, 0.0)
        difference = np.insert(difference, 0, 0.0)
    at = np.clip(stress, tabulated[0], tabulated[-1])
    return cubic_over(tabulated, difference - difference[0])(at)


def _stiffness_difference(
    law: Hyperbola, loading: pd.DataFrame, seating: float
) -> tuple[str, float]:
    """Return how far the stiffness of a hyperbola is from the stiffness of the ``loading``.

    The first value says in words the range of the relative differences above the ``seating`` stress
    [Pa], the second is the largest of them in magnitude [1]: 0 if the table of the loading has no
    stiffness there.
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

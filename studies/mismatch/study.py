"""Experiment on mated, natural and non-mated walls: effects of mismatch and shift.

Without a shift, the upper walls of all mismatch wavelengths differ only in their scale. With a
shift they are others, as a longer field is drawn for it. Shifted walls behave as independent ones
from the shift on at which the mean closure since seating of the first cycle is at most a declared
share below that of independent walls.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import scipy
from matplotlib.figure import Figure

from jointclosure.ensembles.quantities import COLUMNS, QUANTITIES
from jointclosure.joint.status import FAILURE
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.statistics.standard_errors import CONFIDENCE, ratio_of_means
from studies.frame.configuration import Configuration
from studies.frame.experiments import Experiment, Tables, at_wavelengths
from studies.frame.joint_tables import grouped, mean_shown
from studies.frame.panels import PanelColumn, Row, panels
from studies.frame.settings import Point
from studies.mismatch.section import MismatchSection

CLOSURE, RESIDUAL = "max_closure_seated_net", "residual_closure_seated_net"
MEANS = ("max_closure", CLOSURE, RESIDUAL, "hysteresis", "mean_aperture_at_seating")
"""Quantities whose means over surfaces are columns of the table."""
SHOWN = (CLOSURE, "stiffness_net", RESIDUAL, "hysteresis")
"""Quantities of the figure."""
RESAMPLES = 2000


def mismatch_jobs(study: Configuration) -> dict[str, list[Point]]:
    """Make a job for each rock and wavelength, with all shifts; independent walls have none."""
    section = study.section(MismatchSection)
    jobs = {}
    for rock, name, wavelength, settings in at_wavelengths(study, section.wavelength):
        surface = settings.surface
        points = []
        for shift in section.shift_in_cells if np.isfinite(wavelength) else (0,):
            at = {"rock": rock, "wavelength": wavelength}
            at["shift"] = study.grid.spacing * shift
            moved = settings._replace(surface=surface._replace(shift_in_cells=shift))
            points.append(Point(at, moved))
        jobs[f"{rock}.{name}"] = points
    return jobs


def tabulate_mismatch(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Compute means over surfaces with standard errors; quantities that are NaN are left out."""
    rows = []
    for at, part in grouped(joints, "rock", "wavelength", "shift", "cycle"):
        closed = part[part.status < FAILURE]
        share, error = ratio_of_means(closed[RESIDUAL].to_numpy(), closed[CLOSURE].to_numpy())
        row = at | {"samples": len(closed)}
        for name in (*MEANS, "stiffness_net"):
            column = COLUMNS[name][0]
            row[column], row[f"{column}_error"] = mean_shown(name, closed[name].to_numpy())
        rows.append(row | {"residual_share_net": share, "residual_share_net_error": error})
    return pd.DataFrame(rows)


def draw_mismatch(tables: Tables, settings: Mapping[str, Any]) -> Figure:
    """Draw the first rock: both cycles over the wavelength, and the first cycle over the shift."""
    mismatch = tables["mismatch"]
    table = mismatch[mismatch.rock == mismatch.rock.iloc[0]]
    # the hysteresis of mated walls is unresolved, and may be far below 0
    axes: dict[str, dict[str, Any]] = {
        "stiffness_net": {"yscale": "log"},
        "hysteresis": {"ylim": (-0.1, 1.05)},
    }
    rows = [
        Row(QUANTITIES[name].heading, table, column, f"{column}_error", axes.get(name, {}))
        for name in SHOWN
        for column in [COLUMNS[name][0]]
    ]
    free = {"wavelength_mm": np.inf}
    columns = [
        PanelColumn("wavelength_mm", "cycle", {"shift_mm": 0.0}, "log", "without a shift"),
        PanelColumn("shift_mm", "wavelength_mm", {"cycle": 1}, "symlog", "shifted, cycle 1", free),
    ]
    return panels(rows, columns, {"wavelength_mm": {0.0: "0 (mated)", np.inf: "independent"}})


def find_independence(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Find the shift from which on walls behave as independent ones, by mismatch wavelength.

    ``shift_mm`` is infinite if no shift suffices; ``low`` and ``high`` are the ends of its 95 %
    interval by bootstrap over surfaces. Mean closures are first made to increase with the shift by
    isotonic regression. ``apertures`` is the shift over the mean aperture of independent walls at
    seating.
    """
    tolerance = settings["tolerance"]
    root_seed = settings["root_seed"]
    rows = []
    first = joints[joints.cycle == joints.cycle.min()]
    tail = 0.5 - 0.5 * CONFIDENCE
    for rock, run in first.groupby("rock", sort=False):
        independent = np.isinf(run.wavelength)
        aperture = float(run.mean_aperture_at_seating[independent].mean())
        _, (free, *_) = _closures(run[independent])
        for wavelength, part in run[~independent].groupby("wavelength"):
            shifts, samples = _closures(part)
            random = generator(seed_of(root_seed, "mismatch", rock, f"{wavelength:.9g}"))
            shift, *drawn = (
                _shift_at(shifts, (1.0 - tolerance) * independent_mean, means)
                for independent_mean, *means in _drawn_means([free, *samples], random)
            )
            low, high = np.quantile(drawn, [tail, 1.0 - tail], method="nearest")
            row = {"rock": rock, "wavelength_mm": 1e3 * wavelength, "shift_mm": 1e3 * shift}
            row |= {"low": 1e3 * low, "high": 1e3 * high, "apertures": shift / aperture}
            rows.append(row)
    return pd.DataFrame(rows)


def _closures(joints: pd.DataFrame) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the shifts [m] with closures, and the closures [m] of all surfaces at each of them."""
    known = joints[np.isfinite(joints[CLOSURE])].groupby("shift")[CLOSURE]
    return np.array(list(known.groups)), [values.to_numpy() for _, values in known]


def _drawn_means(samples: list[np.ndarray], random: np.random.Generator):
    """Generate the means of all samples, first as they are, then `RESAMPLES` times resampled."""
    yield [values.mean() for values in samples]
    for _ in range(RESAMPLES):
        yield [values[random.integers(len(values), size=len(values))].mean() for values in samples]


def _shift_at(shifts: np.ndarray, level: float, means: list[float]) -> float:
    """Return the shift at which the isotonic regression of means reaches a level, or infinity."""
    fitted = scipy.optimize.isotonic_regression(np.array(means)).x
    enough = np.flatnonzero(fitted >= level)
    if not enough.size:
        return np.inf
    after = int(enough[0])
    if after == 0:
        return float(shifts[0])
    part = (level - fitted[after - 1]) / (fitted[after] - fitted[after - 1])
    return float(shifts[after - 1] + part * (shifts[after] - shifts[after - 1]))


EXPERIMENT = Experiment(
    title="effects of mismatch and of a shift of the walls",
    quantities=(*MEANS, "stiffness_net", "initial_aperture"),
    jobs=mismatch_jobs,
    tables={"mismatch.csv": tabulate_mismatch, "mismatch_shifts.csv": find_independence},
    figures={"mismatch": draw_mismatch},
    settings=lambda study: {
        "root_seed": study.study.root_seed,
        "tolerance": study.section(MismatchSection).tolerance,
    },
)

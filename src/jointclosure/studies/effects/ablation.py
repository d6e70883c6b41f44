"""What each effect adds to closure, and what it costs: all scenes on the same joints.

The conditions are those of the configuration's ``ablation`` section: rocks,
roughnesses, stresses. Every well-posed scene closes the same surfaces at every
condition.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.config.typed import Ablation
from jointclosure.engineering.curves import hysteresis
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.surfaces import walls_of
from jointclosure.ensemble.timing import timed_simulation
from jointclosure.loading import largest_stress
from jointclosure.parameters import Effects, scene_name, well_posed_scenes
from jointclosure.protocol import FAILURE

TARGETS = ("max_closure", "residual_closure", "hysteresis")


class Contribution(NamedTuple):
    """An effect, and the scenes with and without it that tell what it adds."""

    effect: str
    with_it: Effects
    without_it: Effects


FULL = Effects()
CONTRIBUTIONS = (
    # the substrate's is that to a scene without interaction, which needs it
    Contribution("substrate", FULL._replace(interaction=False), Effects(False, False)),
    Contribution("interaction", FULL, FULL._replace(interaction=False)),
    Contribution("breakage", FULL, FULL._replace(breakage=False, gouge=False)),
    Contribution("gouge", FULL, FULL._replace(gouge=False)),
    Contribution("soft_peaks", FULL, FULL._replace(soft_peaks=False)),
)


SCENES = {scene_name(effects): effects for effects in well_posed_scenes()}


def close_scene(
    conditions: list[ClosureSettings],
    design: Ablation,
    effects: Effects,
    report: Callable[[str], None] = lambda line: None,
) -> xr.Dataset:
    """Close the surfaces of a rock in one scene, at every condition.

    Parameters
    ----------
    conditions : list of ClosureSettings
        As from `jointclosure.studies.effects.design.conditions_of`; their effects do not count.
    design : Ablation
        That they are of.
    effects : Effects
        Of the scene.
    report : callable
        Receives a line for each condition.

    Returns
    -------
    Dataset
        Over (jrc, stress, realization, cycle): ``max_closure`` and
        ``residual_closure`` [m]; ``hysteresis``, the share of the work of loading
        that unloading does not give back; ``status``, and times [s].
    """
    cycles, realizations = conditions[0].cycles, conditions[0].surfaces.realizations
    shape = (len(design.jrc), len(design.stress), realizations)
    values = {name: np.full((*shape, cycles), np.nan) for name in TARGETS}
    status = np.zeros(shape, np.int16)
    seconds, pairs = np.zeros(shape), np.zeros(shape)
    for number, settings in enumerate(conditions):
        at = divmod(number, len(design.stress))
        told = settings.with_effects(effects).conditions()
        for realization, walls in enumerate(walls_of(settings.surfaces)):
            here = (*at, realization)
            timed = timed_simulation(walls, told)
            values["max_closure"][here] = timed.closed.max_closure
            values["residual_closure"][here] = timed.closed.residual_closure
            values["hysteresis"][here] = hysteresis(timed.closed)
            status[here] = timed.closed.status
            seconds[here], pairs[here] = timed.seconds, timed.pair
        report(
            f"JRC {settings.case.jrc:g}, {1e-6 * largest_stress(told.max_normal_stress):g} MPa: "
            f"{seconds[at].mean():.2f} s a simulation, statuses {np.unique(status[at]).tolist()}"
        )
    dimensions = ("jrc", "stress", "realization")
    units = {"max_closure": "m", "residual_closure": "m", "hysteresis": "1"}
    return xr.Dataset(
        {
            name: ((*dimensions, "cycle"), values[name], {"units": unit})
            for name, unit in units.items()
        }
        | {
            "status": (dimensions, status),
            "timing_simulation": (dimensions, seconds, {"units": "s"}),
            "timing_pair": (dimensions, pairs, {"units": "s"}),
        },
        coords={
            "jrc": list(design.jrc),
            "stress": ("stress", list(design.stress), {"units": "Pa"}),
            "cycle": np.arange(1, cycles + 1),
        },
    )


def effect_table(runs: Mapping[tuple[str, str], xr.Dataset]) -> pd.DataFrame:
    """What each effect adds at each condition, and what it costs.

    Parameters
    ----------
    runs : mapping
        Datasets as from `close_scene` by (rock, scene).

    Returns
    -------
    DataFrame
        For each rock, roughness, stress, effect and cycle: of each of `TARGETS`
        the mean with and without the effect, the change that the effect makes
        (closures in percent of the mean with it, hysteresis in percent of the
        work) with the standard error of the paired differences, and the time
        with the effect over that without, in FFT pairs.
    """
    rows = []
    for rock in dict.fromkeys(rock for rock, _ in runs):
        for effect, with_it, without_it in CONTRIBUTIONS:
            one, two = (runs[rock, scene_name(effects)] for effects in (with_it, without_it))
            for jrc in one.jrc.values:
                for stress in one.stress.values:
                    on, off = (part.sel(jrc=jrc, stress=stress) for part in (one, two))
                    about = {"rock": rock, "jrc": jrc, "stress_MPa": 1e-6 * stress}
                    about |= {"effect": effect} | _cost(on, off)
                    for cycle in one.cycle.values.tolist():
                        rows.append(about | {"cycle": cycle} | _added(on, off, cycle))
    return pd.DataFrame(rows)


def _cost(one: xr.Dataset, two: xr.Dataset) -> dict:
    pairs = [float(np.median(part.timing_simulation / part.timing_pair)) for part in (one, two)]
    return {"pairs_with": pairs[0], "pairs_without": pairs[1], "time_ratio": pairs[0] / pairs[1]}


def _added(one: xr.Dataset, two: xr.Dataset, cycle: int) -> dict:
    """Changes by an effect at one condition and cycle, over the surfaces that both closed."""
    good = ((one.status < FAILURE) & (two.status < FAILURE)).values
    row: dict = {"samples": int(good.sum()), "failed_without": int((two.status >= FAILURE).sum())}
    for target in TARGETS:
        a, b = (part[target].sel(cycle=cycle).values[good] for part in (one, two))
        scale = 1e3 if target != "hysteresis" else 1.0
        base = a.mean() if target != "hysteresis" and a.size else 1.0
        row[f"{target}_with"] = scale * a.mean() if a.size else np.nan
        row[f"{target}_without"] = scale * b.mean() if b.size else np.nan
        change = 100.0 * (a - b) / base
        row[f"{target}_added_percent"] = change.mean() if a.size else np.nan
        enough = change.size > 1
        row[f"{target}_standard_error"] = (
            change.std(ddof=1) / np.sqrt(change.size) if enough else np.nan
        )
    return row

"""What each effect adds to closure, and what it costs: all scenes on the same joints.

The conditions are those of the configuration's ``ablation`` section: rocks,
roughnesses, stresses. Every well-posed scene closes the same surfaces at every
condition.
"""

import itertools
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.config.configuration import Configured
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.points import Point, gridded
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.experiments import Design, Experiment
from jointclosure.joint.protocol import FAILURE
from jointclosure.parameters import Effects, scene_name, well_posed_scenes
from jointclosure.plotting.effects import effect_figure

TARGETS = {"max_closure": "closure", "residual_closure": "residual", "hysteresis": "hysteresis"}
"""Quantities that an effect may change, by their names in columns of the table."""
QUANTITIES = (*TARGETS.values(), "fft_pair")


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


def effects_design(configured: Configured) -> Design:
    """A job for each rock and scene: every roughness and stress of the section ``ablation``."""
    configuration = configured.typed
    conditions, block = configuration.ablation, range(configuration.study.realizations)
    assert conditions is not None  # the section is there
    jobs = {}
    for (rock, of_rock), (scene, effects) in itertools.product(
        configuration.rocks.items(), SCENES.items()
    ):
        base = base_case(rock, of_rock)
        points = []
        for jrc, stress in itertools.product(conditions.jrc, conditions.stress):
            case = base._replace(jrc=jrc, max_normal_stress=stress, effects=effects)
            surfaces = surface_settings(configuration, case, block)
            # nothing is read from seating on, and an elastic curve needs no point there
            settings = closure_settings(configuration, case, surfaces)._replace(seating_stress=0.0)
            at = {"rock": rock, "scene": scene, "jrc": jrc, "stress": stress}
            points.append(Point(at, settings))
        jobs[f"{rock}.{scene}"] = points
    return Design(jobs, ("effects",), ("effects",), {})


def effect_table(joints: pd.DataFrame) -> pd.DataFrame:
    """What each effect adds at each condition, and what it costs.

    Parameters
    ----------
    joints : DataFrame
        As from `jointclosure.ensemble.points.close_points`, with the columns ``rock``, ``scene``,
        ``jrc`` and ``stress`` [Pa].

    Returns
    -------
    DataFrame
        For each rock, roughness, stress, effect and cycle: of each of `TARGETS`
        the mean with and without the effect, the change that the effect makes
        (closures in percent of the mean with it, hysteresis in percent of the
        work) with the standard error of the paired differences, and the time
        with the effect over that without, in FFT pairs.
    """
    runs = {
        at: gridded(part, ("jrc", "stress", "realization"), QUANTITIES)
        for at, part in joints.groupby(["rock", "scene"])
    }
    rows = []
    for rock in joints.rock.unique():
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
    pairs = [float(np.median(part.seconds / _pairs(part))) for part in (one, two)]
    return {"pairs_with": pairs[0], "pairs_without": pairs[1], "time_ratio": pairs[0] / pairs[1]}


def _pairs(part: xr.Dataset) -> xr.DataArray:
    """Seconds of an FFT pair beside each joint."""
    return part.fft_pair.isel(cycle=0)


def _added(one: xr.Dataset, two: xr.Dataset, cycle: int) -> dict:
    """Changes by an effect at one condition and cycle, over the surfaces that both closed."""
    good = ((one.status < FAILURE) & (two.status < FAILURE)).values
    row: dict = {"samples": int(good.sum()), "failed_without": int((two.status >= FAILURE).sum())}
    for target, quantity in TARGETS.items():
        a, b = (part[quantity].sel(cycle=cycle).values[good] for part in (one, two))
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


EXPERIMENT = Experiment(
    title="what each effect adds and costs",
    quantities=QUANTITIES,
    design=effects_design,
    tabulate=lambda joints, parameters: {"effects": effect_table(joints)},
    draw=lambda name, tables, parameters: effect_figure(tables[name]),
)

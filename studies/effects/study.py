"""Ablation study: contribution of each effect to closure, and its cost.

The section ``ablation`` of the configuration has the roughnesses and stresses. Every well-posed
scene closes the same surfaces at every condition.
"""

import itertools
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.engine.points import Point
from jointclosure.engine.quantities import COLUMNS
from jointclosure.joint.protocol import FAILURE
from jointclosure.parameters import Effects, scene_name, well_posed_scenes
from studies.effects.figures import effect_figure
from studies.effects.section import Ablation
from studies.frame.config.configuration import Configured
from studies.frame.ensemble.cases import base_case
from studies.frame.experiments import Design, Experiment, settings_of
from studies.frame.summary import grouped

TARGETS = ("max_closure", "residual_closure", "hysteresis")
"""Quantities that an effect may change, which are columns of the table."""
QUANTITIES = (*TARGETS, "fft_pair")


class Contribution(NamedTuple):
    """Effect, and the scenes with and without it, whose difference is its contribution."""

    effect: str
    with_it: Effects
    without_it: Effects


FULL = Effects()
CONTRIBUTIONS = (
    # the interaction needs the substrate: its contribution is to a scene without interaction
    Contribution("substrate", FULL._replace(interaction=False), Effects(False, False)),
    Contribution("interaction", FULL, FULL._replace(interaction=False)),
    Contribution("breakage", FULL, FULL._replace(breakage=False, gouge=False)),
    Contribution("gouge", FULL, FULL._replace(gouge=False)),
    Contribution("soft_peaks", FULL, FULL._replace(soft_peaks=False)),
)


SCENES = {scene_name(effects): effects for effects in well_posed_scenes()}


def effects_design(configured: Configured) -> Design:
    """Make a job for each rock and scene: all roughnesses and stresses of ``ablation``."""
    configuration = configured.typed
    conditions = configuration.section(Ablation)
    jobs = {}
    for rock, scene in itertools.product(configuration.rocks, SCENES):
        base = base_case(rock, configuration.rocks[rock])._replace(effects=SCENES[scene])
        jobs[f"{rock}.{scene}"] = [
            Point(
                {"rock": rock, "scene": scene, "jrc": jrc, "stress": stress},
                # no quantity counts from seating, and an elastic curve needs no point there
                settings_of(
                    configuration, base._replace(jrc=jrc, max_normal_stress=stress)
                )._replace(seating_stress=0.0),
            )
            for jrc, stress in itertools.product(conditions.jrc, conditions.stress)
        ]
    return Design(jobs, ("effects",), ("effects",), {})


def effect_table(joints: pd.DataFrame) -> pd.DataFrame:
    """Compute the contribution of each effect at each condition, and its cost.

    For each rock, roughness, stress, effect and cycle: of each of `TARGETS`
    the mean with and without the effect, the change due to the effect
    (closures in percent of the mean with it, hysteresis in percent of the
    work) with the standard error of the paired differences, and the time
    with the effect over that without, in FFT pairs.
    """
    scenes = dict(list(joints.groupby(["rock", "scene"])))
    rows = []
    for rock, contribution in itertools.product(joints.rock.unique(), CONTRIBUTIONS):
        on, off = (scenes[rock, scene_name(effects)] for effects in contribution[1:])
        pairs = on.merge(off, on=["rock", "jrc", "stress", "realization", "cycle"])
        for at, condition in grouped(pairs, "rock", "jrc", "stress"):
            at |= {"effect": contribution.effect} | _cost(condition[condition.cycle == 1])
            for cycle, part in condition.groupby("cycle"):
                rows.append(at | {"cycle": cycle} | _contribution(part))
    return pd.DataFrame(rows)


def _cost(pairs: pd.DataFrame) -> dict:
    """Compute median times with and without an effect [FFT pairs], and their ratio."""
    on, off = (float(np.median(pairs[f"seconds{of}"] / pairs[f"fft_pair{of}"])) for of in _BOTH)
    return {"pairs_with": on, "pairs_without": off, "time_ratio": on / off}


_BOTH = ("_x", "_y")
"""Endings of columns with and without an effect, as `pandas.merge` gives them."""


def _contribution(pairs: pd.DataFrame) -> dict:
    """Compute changes by an effect at one condition and cycle, on surfaces closed with both."""
    failed = pairs.status_y >= FAILURE
    closed = pairs[(pairs.status_x < FAILURE) & ~failed]
    row = {"samples": len(closed), "failed_without": int(failed.sum())}
    for target in TARGETS:
        on, off = (closed[f"{target}{of}"] for of in _BOTH)
        scale, base = COLUMNS[target][1], 1.0 if target == "hysteresis" else on.mean()
        change = 100.0 * (on - off) / base
        row[f"{target}_with"] = scale * on.mean()
        row[f"{target}_without"] = scale * off.mean()
        row[f"{target}_added_percent"] = change.mean()
        row[f"{target}_standard_error"] = change.sem()
    return row


EXPERIMENT = Experiment(
    title="contribution of each effect to closure, and its cost",
    quantities=QUANTITIES,
    design=effects_design,
    tabulate=lambda joints, parameters: {"effects": effect_table(joints)},
    draw=lambda name, tables, parameters: effect_figure(tables[name]),
)

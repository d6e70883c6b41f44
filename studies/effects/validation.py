"""Benchmark of selected effects at random conditions, against the full model and the best scene.

Rock, roughness, stress and size are random. Every well-posed scene is closed on the same surfaces,
so that the best one is known: the fastest whose mean maximum closures keep the tolerance. All
selections, for every tolerance and number of joints, are made and judged on these closures. Where
effects are selected, the interaction may also be left out of the first loading to the tolerance
(`Numerics.idle_interaction`).

Regret is the time of the selection, with its pilot, over that of the best scene. The effectivity
index is the estimated error over the true one, which is the change of the mean over all surfaces.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.choice import JOINTS, SceneChoice, choose_among
from jointclosure.engine.pilot import Close, Closed, Pilot, closing, max_closures
from jointclosure.engine.points import as_dataset
from jointclosure.engine.settings import Grid, Surface
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.parameters import Choices, Effects, Numerics, Rock, scene_name, well_posed_scenes
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.synthesis import wall_pair
from studies.effects.section import Ablation, Validation
from studies.frame.config.model import Configuration

SHARED_BY = (JOINTS, 180, 540)
"""Joints that share a selection: of a case of the paper's study, and of all cases of a rock."""
LEFT_OUT = {
    "breakage": Effects(breakage=False, gouge=False),
    "interaction": Effects(interaction=False),
    "substrate": Effects(interaction=False, substrate=False),
    "gouge": Effects(gouge=False),
    "soft_peaks": Effects(soft_peaks=False),
}
"""Scenes without an effect, and without those that need it, by the effect."""
_MAY_IDLE = (Effects(), Effects(soft_peaks=False))
"""Scenes that may be selected and in which the interaction may be left out at first."""
_FIRST = (1, 3)
"""Numbers of surfaces after which a scene is given up that fails, takes `_SLOWER` times as long as
all effects, or changes a closure by more than `_HOPELESS`."""
_SLOWER = 1.5
_HOPELESS = 3.0
"""Largest change of the mean closure of the first surfaces, over the largest tolerance."""


class RandomConditions(NamedTuple):
    """Rock, roughness, maximum stress [Pa], and number of cells along a square joint."""

    rock: Rock
    jrc: float
    max_normal_stress: float
    cells: int


class ValidationSettings(NamedTuple):
    """Settings that the random conditions of a study depend on."""

    design: Validation
    root_seed: int
    cycles: int
    grid: Grid
    surface: Surface
    choices: Choices
    numerics: Numerics


def validation_settings(configuration: Configuration) -> ValidationSettings:
    """Return the settings of the random conditions of a study."""
    study, ablation = configuration.study, configuration.section(Ablation)
    if ablation.validation is None:
        raise InputError("ablation.validation = null: must be given for random conditions")
    return ValidationSettings(
        ablation.validation,
        study.root_seed,
        study.cycles,
        configuration.grid,
        configuration.surface,
        configuration.choices,
        configuration.numerics,
    )


def random_scene(settings: ValidationSettings, number: int) -> RandomConditions:
    """Return the conditions of a number, from the ranges of the design.

    Young's modulus, strength and stress are uniform in their logarithm. The stress is at most the
    strength.
    """
    random = generator(seed_of(settings.root_seed, "conditions", number))

    def uniform(name: str, logarithmic: bool = False) -> float:
        low, high = getattr(settings.design, name)
        if logarithmic:
            return float(np.exp(random.uniform(np.log(low), np.log(high))))
        return float(random.uniform(low, high))

    rock = Rock(
        uniform("youngs_modulus", True),
        uniform("poisson_ratio"),
        uniform("compressive_strength", True),
    )
    jrc, stress = uniform("jrc"), uniform("stress", True)
    cells = round(uniform("cells"))
    return RandomConditions(rock, jrc, min(stress, rock.compressive_strength), cells)


class _Runs:
    """Closures of the surfaces of a scene, each made once."""

    def __init__(self, settings: ValidationSettings, number: int, scene: RandomConditions):
        self.count = settings.design.realizations
        conditions = _in_full(settings, scene)
        walls = _walls(settings, number, scene)
        self._close: dict[float, Close] = {}
        for idle in (0.0, *settings.design.tolerances):
            numerics = conditions.numerics._replace(idle_interaction=idle)
            self._close[idle] = closing(walls, conditions._replace(numerics=numerics))
        self._known: dict[tuple, Closed | None] = {}

    def close(self, number: int, effects: Effects, idle: float = 0.0) -> Closed | None:
        """Close a pair with some effects; the interaction may be idle to a tolerance."""
        key = (number, effects, idle if effects.interaction else 0.0)
        if key not in self._known:
            closed = self._close[key[2]](number, effects)
            # where interaction always acts, times would differ by noise only
            same = key[2] > 0.0 and closed is not None and not int(closed.dataset.idle_steps)
            self._known[key] = self.close(number, effects) if same else closed
        return self._known[key]

    def mean(self, effects: Effects, idle: float = 0.0, count: int = 0) -> "_Mean":
        """Close the first, or all, surfaces with some effects and with all, and compare."""
        rows = []
        for number in range(count or self.count):
            with_all, closed = self.close(number, Effects()), self.close(number, effects, idle)
            assert with_all is not None  # the surface is there
            assert closed is not None
            rows.append(
                (
                    max_closures(with_all.dataset),
                    max_closures(closed.dataset),
                    with_all.seconds,
                    closed.seconds,
                )
            )
        full, maxima, full_seconds, seconds = map(np.array, zip(*rows, strict=True))
        good = np.isfinite(full).all(axis=1)
        failed = int((~np.isfinite(maxima[good])).any(axis=1).sum())
        off = np.inf
        if good.any() and not failed:
            off = float(np.abs(maxima[good].mean(axis=0) / full[good].mean(axis=0) - 1.0).max())
        return _Mean(off, float(seconds.sum()), float(full_seconds.sum()), int(good.sum()), failed)


class _Mean(NamedTuple):
    """Error of mean closures [1], times [s], and numbers of surfaces that count and that failed."""

    error: float
    seconds: float
    full_seconds: float
    samples: int
    failed: int


def validate(
    settings: ValidationSettings, number: int, report: Callable[[str], None] = lambda line: None
) -> pd.DataFrame:
    """Select effects at random conditions, and compare with all effects and with the best scene.

    For each tolerance and number of ``joints`` that share a selection: the conditions, the
    ``chosen`` effects, ``estimated_percent`` and ``actual_percent`` (the largest change of a
    cycle's mean maximum closure), ``holds``; ``full_s``, ``chosen_s`` and ``best_s``, times of
    as many joints with all effects, with the chosen ones, and of the fastest scene
    (``best``) that keeps the tolerance; ``pilot_s``, the time of closures that no result
    uses; ``saved_percent`` and ``best_saved_percent`` of the full time, the former with the
    pilot; ``regret`` and ``effectivity``. Times are processor times. Surfaces on which the full
    model fails are left out (``samples`` remain). If the selected effects fail on others
    (``failed``), there is no error, and ``holds`` is false. ``without_<effect>_percent`` is the
    change of the mean maximum closure without an effect, on the first surfaces at least.
    """
    scene = random_scene(settings, number)
    report(f"conditions {number}: {scene}")
    runs = _Runs(settings, number, scene)
    design = settings.design
    scenes, changes = _means(runs, design.tolerances)
    about = {"scene": number} | scene.rock._asdict() | scene._asdict() | changes
    del about["rock"]
    rows = []
    for tolerance in design.tolerances:
        idle = {scene: runs.mean(scene, tolerance) for scene in _MAY_IDLE}
        for joints in SHARED_BY:
            pilot = Pilot(_limited(runs, tolerance), Effects(), joints)
            choice = choose_among(pilot, tolerance, report)
            chosen = runs.mean(choice.effects, tolerance)
            options = {scene_name(Effects()): runs.mean(Effects())}
            options |= {name: mean for name, mean in scenes.items() if mean.error <= tolerance}
            options |= {
                f"{scene_name(scene)}, idle interaction": mean
                for scene, mean in idle.items()
                if mean.error <= tolerance
            }
            rows.append(
                {"tolerance": tolerance, "joints": joints}
                | about
                | _judged(choice, chosen, options, joints / runs.count, tolerance)
            )
        report(f"tolerance {tolerance:g}: {rows[-1]}")
    return pd.DataFrame(rows)


def validated_scene(
    settings: ValidationSettings, number: int, report: Callable[[str], None]
) -> xr.Dataset:
    """Return `validate` as a dataset (`jointclosure.engine.points.as_dataset`)."""
    return as_dataset(validate(settings, number, report))


def _limited(runs: _Runs, tolerance: float) -> Close:
    """Return a function that closes the surfaces of a scene, as a study to a tolerance does."""

    def close(number: int, effects: Effects) -> Closed | None:
        return runs.close(number, effects, tolerance) if number < runs.count else None

    return close


def _means(runs: _Runs, tolerances: tuple[float, ...]) -> tuple[dict[str, _Mean], dict[str, float]]:
    """Return the scenes that may be best by their names, and changes without each effect [%].

    Every pair of walls is closed in all scenes before the next pair, so that a slower machine
    affects all of them.
    """
    candidates = list(well_posed_scenes())
    means: dict[Effects, _Mean] = {}
    for number in range(runs.count):
        for idle in (0.0, *tolerances):
            for effects in _MAY_IDLE:
                runs.close(number, effects, idle)
        for effects in candidates:
            runs.close(number, effects)
        if number + 1 in (*_FIRST, runs.count):
            means |= {effects: runs.mean(effects, count=number + 1) for effects in candidates}
            candidates = [one for one in candidates if _may_be_best(means[one], max(tolerances))]
    changes = {}
    for name, effects in LEFT_OUT.items():
        changes[f"without_{name}_percent"] = 100.0 * means[effects].error
        changes[f"without_{name}_time"] = means[effects].seconds / means[effects].full_seconds
    return {scene_name(effects): means[effects] for effects in candidates}, changes


def _may_be_best(mean: _Mean, tolerance: float) -> bool:
    """Return whether a scene may be the fastest within a tolerance, from the first surfaces."""
    return mean.seconds <= _SLOWER * mean.full_seconds and mean.error <= _HOPELESS * tolerance


def _judged(
    choice: SceneChoice, chosen: _Mean, options: dict[str, _Mean], scale: float, tolerance: float
) -> dict:
    """Compare a choice with the full model and with the best of the scenes that hold."""
    best = min(options, key=lambda name: options[name].seconds)
    full_s, chosen_s, best_s = (
        scale * seconds for seconds in (chosen.full_seconds, chosen.seconds, options[best].seconds)
    )
    spent = chosen_s + choice.lost_seconds
    # an error of 0 has no ratio; so has one that is only due to the idle interaction
    compared = choice.error > 0.0 and 0.0 < chosen.error < np.inf
    return {
        "chosen": scene_name(choice.effects),
        "best": best,
        "samples": chosen.samples,
        "failed": chosen.failed,
        "estimated_percent": 100.0 * choice.error,
        "actual_percent": 100.0 * chosen.error if np.isfinite(chosen.error) else np.nan,
        "holds": bool(chosen.error <= tolerance),
        "full_s": full_s,
        "chosen_s": chosen_s,
        "pilot_s": choice.lost_seconds,
        "best_s": best_s,
        "saved_percent": 100.0 * (1.0 - spent / full_s),
        "best_saved_percent": 100.0 * (1.0 - best_s / full_s),
        "regret": spent / best_s,
        "effectivity": choice.error / chosen.error if compared else np.nan,
    }


def _walls(
    settings: ValidationSettings, number: int, scene: RandomConditions
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the surface pairs of a scene."""
    return [
        wall_pair(
            scene.jrc,
            (scene.cells, scene.cells),
            settings.grid.spacing,
            seed_of(settings.root_seed, "conditions", number, realization),
            **settings.surface._asdict(),
        )
        for realization in range(settings.design.realizations)
    ]


def _in_full(settings: ValidationSettings, scene: RandomConditions) -> Conditions:
    """Return the conditions of a scene with all effects."""
    return Conditions(
        settings.grid.spacing,
        scene.rock,
        scene.max_normal_stress,
        settings.cycles,
        0.0,
        Effects(),
        settings.choices,
        settings.numerics._replace(idle_interaction=0.0),
    )


def validation_summary(table: pd.DataFrame) -> pd.DataFrame:
    """Summarise validation, for each tolerance and number of joints that share a selection.

    ``changed`` scenes are those in which an effect was left out; in the others at most the idle
    interaction was left out. ``held_percent`` is the share of all scenes within the tolerance,
    ``held_of_changed_percent`` that of the changed ones. ``saved_percent`` is relative to the time
    of all scenes together, and ``mean_saved_percent`` the mean over scenes; both include pilots,
    and scenes beyond the tolerance save nothing.
    ``best_saved_percent`` and ``best_mean_saved_percent`` are those of the best scenes,
    ``share_of_best_percent`` and ``mean_share_of_best_percent`` the ratios of the two.
    ``least_saved_percent`` is that of the scene with the smallest value, ``largest_lost_percent``
    the largest share of a pilot among scenes that keep all effects. ``median_regret`` and
    ``effectivity`` are medians, ``effectivity_good_percent`` is the share of the changed scenes
    with an index from 1 to 5, ``effectivity_below_percent`` that with a true error above the
    estimate.
    """
    rows = []
    for (tolerance, joints), part in table.groupby(["tolerance", "joints"]):
        is_changed = part.chosen != scene_name(Effects())
        changed, unchanged = part[is_changed], part[~is_changed]
        saved = part.full_s - part.pilot_s - part.chosen_s.where(part.holds, part.full_s)
        best = part.full_s - part.best_s
        index = changed.effectivity.dropna()
        row = {
            "tolerance": tolerance,
            "joints": joints,
            "scenes": len(part),
            "changed": len(changed),
            "held_percent": 100.0 * part.holds.mean(),
            "held_of_changed_percent": 100.0 * changed.holds.mean() if len(changed) else np.nan,
            "largest_error_percent": part.actual_percent.max(),
            "scenes_without_error": int(part.actual_percent.isna().sum()),
            "saved_percent": 100.0 * saved.sum() / part.full_s.sum(),
            "best_saved_percent": 100.0 * best.sum() / part.full_s.sum(),
            "share_of_best_percent": 100.0 * saved.sum() / (best.sum() or np.nan),
            "mean_saved_percent": 100.0 * (saved / part.full_s).mean(),
            "best_mean_saved_percent": part.best_saved_percent.mean(),
            "mean_share_of_best_percent": 1e4
            * (saved / part.full_s).mean()
            / (part.best_saved_percent.mean() or np.nan),
            "least_saved_percent": 100.0 * (saved / part.full_s).min(),
            "largest_lost_percent": 100.0 * (unchanged.pilot_s / unchanged.full_s).max(),
            "median_regret": part.regret.median(),
            "effectivity": index.median(),
            "effectivity_good_percent": 100.0 * index.between(1.0, 5.0).mean(),
            "effectivity_below_percent": 100.0 * (index < 1.0).mean(),
        }
        rows.append(row)
    return pd.DataFrame(rows)

"""Validation of selected effects against the full model, at random conditions.

Rock, roughness, stress and size are random. The surfaces are closed with all effects, and with
those that `choose_among` selects at each tolerance. In the second case the interaction may also be
left out of the first loading to this tolerance (`Numerics.idle_interaction`). The change of the
mean is the error of the selection.
"""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd

from jointclosure.config.typed import Configuration, Grid, Surface, Validation
from jointclosure.effects.choice import choose_among, max_closures
from jointclosure.ensemble.closing import close_walls
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.parameters import Choices, Effects, Numerics, Rock, scene_name
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.surface.synthesis import wall_pair

_REPETITIONS = 2


class RandomScene(NamedTuple):
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
    """Return the settings of the random conditions of a study.

    Raises
    ------
    InputError
        If the study has no ``ablation.validation``.
    """
    study, ablation = configuration.study, configuration.ablation
    if ablation is None:
        raise InputError(
            "ablation = null: must be given for a study of effects (config/effects.yaml)"
        )
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


def random_scene(settings: ValidationSettings, number: int) -> RandomScene:
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
    return RandomScene(rock, jrc, min(stress, rock.compressive_strength), cells)


def validate(
    settings: ValidationSettings, number: int, report: Callable[[str], None] = lambda line: None
) -> pd.DataFrame:
    """Close joints at random conditions with all and with selected effects, at every tolerance.

    Returns
    -------
    DataFrame
        For each tolerance: the conditions, the ``chosen`` effects, ``estimated_percent``
        and ``actual_percent`` (the largest change of a cycle's mean maximum closure),
        ``holds``; ``full_s`` and ``chosen_s``, times of all surfaces; ``pilot_s``, time of runs of
        the pilot that no result uses: those without effects, and also those with all effects if
        any is left out; ``saved_percent`` of the full time, including the pilot. Times are
        processor times. Surfaces on which the full model fails are left out (``samples`` remain).
        If the selected effects fail on others (``failed``), there is no error, and ``holds`` is
        false.
    """
    scene = random_scene(settings, number)
    report(f"conditions {number}: {scene}")
    design = settings.design
    walls, conditions = _walls(settings, number, scene), _in_full(settings, scene)
    for effects in (Effects(), Effects(breakage=False, gouge=False)):
        close_walls(
            *walls[0], conditions._replace(effects=effects)
        )  # load kernels before times are measured
    choices, all_conditions = [], [conditions]
    for tolerance in design.tolerances:
        numerics = conditions.numerics._replace(idle_interaction=tolerance)
        selected = conditions._replace(numerics=numerics)
        choices.append(choose_among(walls, selected, tolerance, report))
        all_conditions.append(selected._replace(effects=choices[-1].effects))
    (full, full_seconds), *chosen = _closed_in_turn(walls, all_conditions)
    about = scene.rock._asdict() | scene._asdict()
    del about["rock"]
    rows = []
    for tolerance, choice, (maxima, seconds) in zip(
        design.tolerances, choices, chosen, strict=True
    ):
        pilot = choice.trial_seconds
        if choice.effects != Effects():
            pilot += sum(pair.seconds for pair in choice.closed)
        good = np.isfinite(full).all(axis=1)
        failed = int((~np.isfinite(maxima[good])).any(axis=1).sum())
        off = np.abs(maxima[good].mean(axis=0) / full[good].mean(axis=0) - 1.0).max()
        rows.append(
            {"scene": number, "tolerance": tolerance}
            | about
            | {
                "chosen": scene_name(choice.effects),
                "samples": int(good.sum()),
                "failed": failed,
                "estimated_percent": 100.0 * choice.error,
                "actual_percent": 100.0 * off,
                "holds": bool(off <= tolerance),
                "full_s": full_seconds,
                "chosen_s": seconds,
                "pilot_s": pilot,
                "saved_percent": 100.0 * (1.0 - (seconds + pilot) / full_seconds),
            }
        )
        report(f"tolerance {tolerance:g}: {rows[-1]}")
    return pd.DataFrame(rows)


def _walls(
    settings: ValidationSettings, number: int, scene: RandomScene
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


def _in_full(settings: ValidationSettings, scene: RandomScene) -> Conditions:
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


def _closed_in_turn(walls: list, conditions: list[Conditions]) -> list[tuple[np.ndarray, float]]:
    """Return maximum closures (realization, cycle) [m] at each of the conditions, and seconds.

    Closures are NaN if a simulation failed. Each pair of walls is closed at all conditions before
    the next pair, so that a slower machine affects all of them. This is done twice, and the shorter
    time counts.
    """
    closures: list[list] = [[] for _ in conditions]
    seconds = np.zeros(len(conditions))
    for upper, lower in walls:
        least = np.full(len(conditions), np.inf)
        for repetition in range(_REPETITIONS):
            for number, conditions_of_turn in enumerate(conditions):
                start = time.process_time()
                maxima = max_closures(close_walls(upper, lower, conditions_of_turn))
                least[number] = min(least[number], time.process_time() - start)
                if repetition == 0:
                    closures[number].append(maxima)
        seconds += least
    return [(np.array(rows), float(spent)) for rows, spent in zip(closures, seconds, strict=True)]


def validation_summary(table: pd.DataFrame) -> pd.DataFrame:
    """Summarise validation at each tolerance: share of scenes within it, and time saved.

    ``changed`` scenes are those in which an effect was left out; in the others at most the idle
    interaction was left out. ``held_percent`` is the share of all scenes within the tolerance,
    ``held_of_changed_percent`` that of the changed ones. ``saved_percent`` is relative to the time
    of all scenes together, ``saved_where_changed_percent`` to that of the changed ones and
    ``saved_where_unchanged_percent`` to that of the others; all include pilots.
    ``least_saved_percent`` is that of the scene with the smallest value. ``pilot_percent`` is the
    share of the pilots in the full time, ``largest_pilot_percent`` the largest share among scenes
    that keep all effects, where it is lost. ``timing_scatter_percent`` is the standard deviation
    of the saved times, without pilots, in scenes where both runs did the same (all effects, equal
    closures): the uncertainty of the times.
    """
    rows = []
    for tolerance, part in table.groupby("tolerance"):
        is_changed = part.chosen != scene_name(Effects())
        changed, unchanged = part[is_changed], part[~is_changed]
        row = {"tolerance": tolerance, "scenes": len(part), "changed": len(changed)}
        row["held_percent"] = 100.0 * part.holds.mean()
        row["held_of_changed_percent"] = 100.0 * changed.holds.mean() if len(changed) else np.nan
        row["largest_error_percent"] = part.actual_percent.max()
        row["scenes_without_error"] = int(part.actual_percent.isna().sum())
        for name, some in (
            ("saved_percent", part),
            ("saved_where_changed_percent", changed),
            ("saved_where_unchanged_percent", unchanged),
        ):
            spent = (some.chosen_s + some.pilot_s).sum()
            row[name] = 100.0 * (1.0 - spent / some.full_s.sum()) if len(some) else np.nan
        row["least_saved_percent"] = part.saved_percent.min()
        row["pilot_percent"] = 100.0 * part.pilot_s.sum() / part.full_s.sum()
        row["largest_pilot_percent"] = 100.0 * (unchanged.pilot_s / unchanged.full_s).max()
        same = unchanged[unchanged.actual_percent == 0.0]
        row["timing_scatter_percent"] = 100.0 * (same.chosen_s / same.full_s).std()
        rows.append(row)
    return pd.DataFrame(rows)

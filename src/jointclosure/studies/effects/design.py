"""What the jobs of a study of effects need of its configuration."""

import itertools

from jointclosure.config.typed import Ablation, Configuration
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.settings import ClosureSettings
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.inputs import InputError
from jointclosure.studies.effects.validation import ValidationSettings


def conditions_of(configuration: Configuration, rock: str) -> list[ClosureSettings]:
    """Settings of a rock's closures at every roughness and stress of the design, in that order.

    Raises
    ------
    InputError
        The study has no ``ablation``.
    """
    design, base = _design(configuration), base_case(rock, configuration.rocks[rock])
    block = range(configuration.study.realizations)
    found = []
    for jrc, stress in itertools.product(design.jrc, design.stress):
        case = base._replace(jrc=jrc, max_normal_stress=stress)
        surfaces = surface_settings(configuration, case, block)
        # nothing is read from seating on, and an elastic curve needs no point there
        settings = closure_settings(configuration, case, surfaces)
        found.append(settings._replace(seating_stress=0.0))
    return found


def validation_settings(configuration: Configuration) -> ValidationSettings:
    """Settings of the random conditions of a study.

    Raises
    ------
    InputError
        The study has no ``ablation.validation``.
    """
    study, validation = configuration.study, _design(configuration).validation
    if validation is None:
        raise InputError("ablation.validation = null: the study has no random conditions")
    return ValidationSettings(
        validation,
        study.root_seed,
        study.cycles,
        configuration.grid,
        configuration.surface,
        configuration.choices,
        configuration.numerics,
    )


def _design(configuration: Configuration) -> Ablation:
    if configuration.ablation is None:
        raise InputError("ablation = null: the study is none of effects (config/effects.yaml)")
    return configuration.ablation

"""What the jobs of a study of effects need of its configuration."""

from jointclosure.config.typed import Ablation, Configuration
from jointclosure.effects.validation import ValidationSettings
from jointclosure.inputs import InputError


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

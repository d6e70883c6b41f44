"""Settings of the jobs of a study of effects, from its configuration."""

from jointclosure.config.typed import Ablation, Configuration
from jointclosure.effects.validation import ValidationSettings
from jointclosure.inputs import InputError


def validation_settings(configuration: Configuration) -> ValidationSettings:
    """Return the settings of the random conditions of a study.

    Raises
    ------
    InputError
        If the study has no ``ablation.validation``.
    """
    study, validation = configuration.study, _design(configuration).validation
    if validation is None:
        raise InputError("ablation.validation = null: must be given for random conditions")
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
        raise InputError(
            "ablation = null: must be given for a study of effects (config/effects.yaml)"
        )
    return configuration.ablation

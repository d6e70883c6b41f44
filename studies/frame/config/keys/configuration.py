"""All keys of a configuration's file.

The only place that says what a key may be: the JSON schema, the table of keys (config/README.md)
and the checks of a file follow from it. Values and their sources are in ``default.yaml``; what a
key is in the library is in `studies.frame.config.typed`.
"""

from pydantic import create_model

from studies.frame.config.keys.accuracy import AccuracyKeys
from studies.frame.config.keys.effects import AblationKeys
from studies.frame.config.keys.entries import Keys, Name, entry
from studies.frame.config.keys.global_sensitivity import GlobalSensitivityKeys
from studies.frame.config.keys.measured_joints import MeasuredJointsKeys
from studies.frame.config.keys.misalignment import MisalignmentKeys
from studies.frame.config.keys.mismatch import MismatchKeys
from studies.frame.config.keys.model import ChoiceKeys, EffectKeys
from studies.frame.config.keys.numerics import NumericsKeys
from studies.frame.config.keys.rocks import RockKeys
from studies.frame.config.keys.size import SizeKeys
from studies.frame.config.keys.study import (
    GridKeys,
    OutputKeys,
    StatisticsKeys,
    StudyKeys,
    SurfaceKeys,
)


class _StudyKeys(Keys):
    """Configuration of a study."""

    study: StudyKeys = entry(StudyKeys.__doc__)
    rocks: dict[Name, RockKeys] = entry(
        "Rocks by name; a study's own file may add some.", min_length=1
    )
    grid: GridKeys = entry(GridKeys.__doc__)
    surface: SurfaceKeys = entry(SurfaceKeys.__doc__)
    seating_stress_MPa: float = entry(
        "Stress from which seated closures count [MPa]; it changes what is read, never what "
        "happens.",
        ge=0,
    )
    effects: EffectKeys = entry(EffectKeys.__doc__)
    flow: bool = entry(
        "Whether hydraulic apertures are found too, by Reynolds' equation at every step "
        "(docs/export.md#flow); it changes nothing else.",
        False,
    )
    choices: ChoiceKeys = entry(ChoiceKeys.__doc__)
    numerics: NumericsKeys = entry(NumericsKeys.__doc__)
    statistics: StatisticsKeys = entry(StatisticsKeys.__doc__)
    output: OutputKeys = entry(OutputKeys.__doc__)


OF_EXPERIMENTS = {
    "accuracy": ("accuracy", AccuracyKeys),
    "effects": ("ablation", AblationKeys),
    "global_sensitivity": ("global_sensitivity", GlobalSensitivityKeys),
    "mismatch": ("mismatch", MismatchKeys),
    "size": ("size", SizeKeys),
    "misalignment": ("misalignment", MisalignmentKeys),
    "measured_joints": ("measured_joints", MeasuredJointsKeys),
}
"""By the name of an experiment: the section of the configuration that it needs, and its keys."""
SECTIONS = {name: section for name, (section, _) in OF_EXPERIMENTS.items()}
"""The section of the configuration that each experiment needs, by the experiment's name."""
ConfigurationKeys = create_model(
    "ConfigurationKeys",
    __base__=_StudyKeys,
    __doc__=_StudyKeys.__doc__,
    **{
        section: (keys | None, entry(keys.__doc__, None))
        for section, keys in OF_EXPERIMENTS.values()
    },
)

"""Experiments by name, and the points at which a study and its experiments simulate joints.

An experiment is a folder of `studies`: ``section.py`` has its section of the configuration, and
``study.py`` has a constant ``EXPERIMENT``.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from jointclosure.ensembles.quantities import QUANTITIES
from jointclosure.inputs import InputError, did_you_mean
from studies.frame.cases import base_case, block_settings
from studies.frame.configuration import Configuration, sections
from studies.frame.settings import Case, ClosureSettings, Point

if TYPE_CHECKING:  # drawing takes long to import
    import pandas as pd
    from matplotlib.figure import Figure


Jobs = Mapping[str, Sequence[Point]]
"""Points by the name of the job that closes them; names are never parsed."""
Tables = Mapping[str, "pd.DataFrame"]
"""Tables of an experiment by name, without their suffix."""


class Experiment(NamedTuple):
    """Description of an experiment.

    ``quantities`` (names in `QUANTITIES`) are read of the joints at the points of ``jobs``.
    ``tables`` are functions of a table of all joints and of ``settings``, by name of the file in
    ``tables/``. ``figures`` are functions of the tables and the settings, by name of the file in
    ``figures/`` without its suffix. ``check`` raises `InputError` for a study that cannot be run;
    it contains checks that are too slow for `StudySection.problems`.
    """

    title: str
    quantities: tuple[str, ...]
    jobs: Callable[[Configuration], Jobs]
    tables: Mapping[str, "Callable[[pd.DataFrame, Mapping[str, Any]], pd.DataFrame | str]"]
    figures: Mapping[str, "Callable[[Tables, Mapping[str, Any]], Figure]"]
    settings: Callable[[Configuration], Mapping[str, Any]] = lambda study: {}
    check: Callable[[Configuration], None] = lambda study: None


def experiment_named(name: str) -> Experiment:
    """Return the experiment of a folder.

    Raises
    ------
    InputError
        If no experiment has this name, or if it reads a quantity that does not exist.
    """
    if name not in sections():
        known = ", ".join(sections())
        raise InputError(f"{name}: must be an experiment ({known}){did_you_mean(name, sections())}")
    experiment = import_module(f"studies.{name}.study").EXPERIMENT
    for quantity in experiment.quantities:
        if quantity not in QUANTITIES:
            raise InputError(
                f"studies/{name}/study.py: quantities: {quantity!r}: must be a name of QUANTITIES "
                f"(src/jointclosure/ensembles/quantities.py){did_you_mean(quantity, QUANTITIES)}"
            )
    return experiment


def case_point(study: Configuration, case: Case, block: range) -> Point:
    """Return the point of a case, for a block of its realisations."""
    about = ("rock", "parameter", "level", "value")
    at = {"case": case.label} | {name: getattr(case, name) for name in about}
    return Point(at, block_settings(study, case, block))


def settings_of(study: Configuration, case: Case, **surface: Any) -> ClosureSettings:
    """Return the settings of all realisations of a case, with changed keys of the surfaces."""
    settings = block_settings(study, case, range(study.study.realizations))
    return settings._replace(surface=settings.surface._replace(**surface))


def at_wavelengths(
    study: Configuration, wavelengths: Iterable[float]
) -> Iterator[tuple[str, str, float, ClosureSettings]]:
    """Generate rock, name, wavelength [m] and settings of base cases at mismatch wavelengths [m].

    The last ones of each rock have independent walls: their wavelength is infinite, in the settings
    None.
    """
    for rock in study.rocks:
        case = base_case(study, rock)
        for length in (*wavelengths, None):
            name = "independent" if length is None else f"{1e6 * length:.15g}um"
            settings = settings_of(study, case, mismatch_wavelength=length)
            yield rock, name, math.inf if length is None else length, settings

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
"""Points by the name of the job that simulates their joints; names of jobs are never parsed."""
Tables = Mapping[str, "pd.DataFrame"]
"""Tables of an experiment, by the names of their files without suffix."""


class Experiment(NamedTuple):
    """Description of an experiment.

    ``jobs`` is a function that makes the points of a study, and ``quantities`` are the names (in
    `QUANTITIES`) of the results that are read of their joints. ``tables`` has functions that make a
    table, or a text, from the table of all joints and from ``settings`` of the study, by the name
    of the file in ``tables/``. ``figures`` has functions that draw a figure from the tables and the
    settings, by the name of the file in ``figures/`` without its suffix. ``check`` raises
    `InputError` for a study that cannot be run; it has the checks that are too slow for
    `StudySection.problems`.
    """

    title: str
    quantities: tuple[str, ...]
    jobs: Callable[[Configuration], Jobs]
    tables: Mapping[str, "Callable[[pd.DataFrame, Mapping[str, Any]], pd.DataFrame | str]"]
    figures: Mapping[str, "Callable[[Tables, Mapping[str, Any]], Figure]"]
    settings: Callable[[Configuration], Mapping[str, Any]] = lambda study: {}
    check: Callable[[Configuration], None] = lambda study: None


def experiment_named(name: str) -> Experiment:
    """Return the description of an experiment by the name of its folder.

    Raises
    ------
    InputError
        If no experiment has this name, or if one of its quantities does not exist.
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
    """Return the point at which the joints of a case are simulated, for a block of realisations."""
    about = ("rock", "parameter", "level", "value")
    at = {"case": case.label} | {name: getattr(case, name) for name in about}
    return Point(at, block_settings(study, case, block))


def settings_of(study: Configuration, case: Case, **surface: Any) -> ClosureSettings:
    """Return the settings of the joints of a case, for all realisations of the study.

    ``surface`` are fields of `Synthesis` [SI] that replace those of the study.
    """
    settings = block_settings(study, case, range(study.study.realizations))
    return settings._replace(surface=settings.surface._replace(**surface))


def at_wavelengths(
    study: Configuration, wavelengths: Iterable[float]
) -> Iterator[tuple[str, str, float, ClosureSettings]]:
    """Generate the settings of each rock's base case at each of the mismatch wavelengths [m].

    Before the settings stand the rock, a name for the wavelength, and the wavelength [m]. The last
    settings of each rock are those of independent walls: their wavelength is infinite, and None in
    the settings.
    """
    for rock in study.rocks:
        case = base_case(study, rock)
        for length in (*wavelengths, None):
            name = "independent" if length is None else f"{1e6 * length:.15g}um"
            settings = settings_of(study, case, mismatch_wavelength=length)
            yield rock, name, math.inf if length is None else length, settings

"""The configuration of a study as the library has it: typed, complete, and in SI.

`studies.frame.config.configuration.configured` makes it from files, once.
"""

from typing import NamedTuple

from jointclosure.engine.settings import Grid, Surface, Walls
from jointclosure.parameters import (
    Choices,
    Effects,
    Numerics,
    Rock,
)


class Study(NamedTuple):
    """Rocks, cases and numbers of realisations of a study; keys of ``study``."""

    name: str
    rocks: tuple[str, ...]
    realizations: int
    cycles: int
    root_seed: int
    draws: str
    pool: int | None
    surfaces_of: str | None
    realizations_per_job: int | None
    unusual_values: str


class MeasuredFile(NamedTuple):
    """Where a measured closure curve is, and units that its header does not say."""

    file: str
    stress_unit: str | None
    closure_unit: str | None


class StudyRock(NamedTuple):
    """A rock of a study: its properties, roughness and load [SI].

    ``levels`` has, for each varied parameter, all values in ascending order, the rock's own
    among them. ``jrc`` is NaN where ``walls`` are scanned ones.
    """

    title: str
    intact: Rock
    jrc: float
    max_normal_stress: float
    max_normal_stress_is_assumed: bool
    effects: Effects
    levels: dict[str, tuple[float, ...]]
    walls: Walls | None
    measured: MeasuredFile | None


class Statistics(NamedTuple):
    """Settings of the indifference intervals."""

    significance: float
    bootstrap_resamples: int
    bootstrap_confidence: float
    repetitions: int
    control_variates: int | None = None


class Output(NamedTuple):
    """Settings of stored and drawn curves; ``largest_stress`` [Pa] ends their axis."""

    wall_strength_ratio: float
    stress_points: int
    largest_stress: float


class Validation(NamedTuple):
    """Random conditions: how many, and the ranges (low, high) of what is drawn [SI]."""

    scenes: int
    realizations: int
    tolerances: tuple[float, ...]
    cells: tuple[float, ...]
    youngs_modulus: tuple[float, ...]
    poisson_ratio: tuple[float, ...]
    compressive_strength: tuple[float, ...]
    jrc: tuple[float, ...]
    stress: tuple[float, ...]


class Ablation(NamedTuple):
    """Conditions at which every scene of effects is closed: JRC, maximum stress [Pa]."""

    jrc: tuple[float, ...]
    stress: tuple[float, ...]
    validation: Validation | None


class MismatchDesign(NamedTuple):
    """Mismatch wavelengths [m] and shifts at which walls are closed, ascending.

    ``tolerance``: share by which closures of shifted walls may be below those of independent ones.
    """

    wavelength: tuple[float, ...]
    shift_in_cells: tuple[int, ...]
    tolerance: float


class SizeSpectrum(NamedTuple):
    """Hurst exponent and roll-off wavelength [m] (None for none) of walls."""

    hurst: float
    roll_off: float | None


class SizeDesign(NamedTuple):
    """Side lengths and spacings [m] at which nested patches are closed, ascending.

    ``most_cells`` along a side, but for patches at the spacing of the grid; ``spectra`` by name.
    """

    patch: tuple[float, ...]
    spacing: tuple[float, ...]
    most_cells: int
    spectra: dict[str, SizeSpectrum]


class Configuration(NamedTuple):
    """All of a study. ``rocks`` are those of the study, in its order.

    ``effects_chosen_to`` is the tolerance by which a pilot chooses effects, None where
    they are as configured; ``flow`` whether hydraulic apertures are found. The design of an
    accuracy study is many configurations: `studies.accuracy.design`.
    """

    study: Study
    rocks: dict[str, StudyRock]
    grid: Grid
    surface: Surface
    seating_stress: float
    effects_chosen_to: float | None
    choices: Choices
    numerics: Numerics
    statistics: Statistics
    output: Output
    ablation: Ablation | None
    flow: bool
    mismatch: MismatchDesign | None = None
    size: SizeDesign | None = None

"""The configuration of a study as the library has it: typed, complete, and in SI.

`jointclosure.config.configuration.configured` makes it from files, once. What a job
needs of it goes through a rule's parameters by `jointclosure.config.plain`.
"""

from typing import NamedTuple

from jointclosure.parameters import (
    Choices,
    Effects,
    Numerics,
    Rock,
)

SIDES = ("upper", "lower")


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


class Walls(NamedTuple):
    """Scanned walls of a rock: files or words for partners, and how they are read."""

    upper: str
    lower: str
    units: str | None
    spacing: float | None
    variable: str | None
    missing: str
    largest_filled_share: float
    inverted: tuple[str, ...]
    bring_together: bool = False
    orientation: str | None = None
    shift: str | None = None
    spikes: str = "cut"


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


class Grid(NamedTuple):
    """Cells of both walls, and their spacing [m]."""

    cells_x: int
    cells_y: int
    spacing: float

    @property
    def shape(self) -> tuple[int, int]:
        """Cells (y, x)."""
        return self.cells_y, self.cells_x


class Surface(NamedTuple):
    """How walls are made from a JRC; arguments of `jointclosure.wall_pair`."""

    hurst: float
    jrc_relation: str
    normalise: str
    correlation: float
    shift_in_cells: int
    mismatch_wavelength: float | None
    rule: str
    roll_off: float | None


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
    accuracy study is many configurations: `jointclosure.experiments.accuracy.design`.
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

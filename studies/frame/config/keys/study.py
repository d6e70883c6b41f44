"""Keys of what is studied: surfaces, grid, statistics and what is stored."""

from typing import Literal

from jointclosure.walls.roughness import RELATIONS
from jointclosure.walls.synthesis import RULES
from studies.frame.config.keys.entries import Keys, Name, entry


class StudyKeys(Keys):
    """Rocks, cases and numbers of realisations of a study."""

    name: Name = entry("Name of the study; results are written to results/<name>/.")
    rocks: list[str] = entry(
        "Rocks of the study, from `rocks`, in the order of the tables.",
        min_length=1,
        json_schema_extra={"uniqueItems": True},
    )
    realizations: int = entry("Random surface pairs per case.", ge=2, le=1_000_000)
    realizations_per_job: int | None = entry(
        "Realisations of a case that one job does; null for all. It changes no result.", None, ge=1
    )
    cycles: int = entry("Load-unload cycles.", ge=1, le=1000)
    root_seed: int = entry("Seed from which every random number follows.", ge=0)
    draws: Literal["common", "independent"] = entry(
        "independent: each case has its own surfaces, and Table 3 has the unpaired t test (the "
        "paper's); common: a realisation has the same noise in all cases of a rock, and the test "
        "is paired."
    )
    pool: int | None = entry(
        "Random surface pairs of every rock on which all of its cases are closed besides, for what "
        "is true of the model and what repetitions of the study would publish (pool.nc); null: "
        "none, the study's own serve.",
        ge=2,
        le=1_000_000,
    )
    surfaces_of: Name | None = entry(
        "Study whose random surfaces are drawn, so that two studies can be compared surface by "
        "surface; null: its own."
    )
    unusual_values: Literal["refuse", "allow"] = entry(
        "Whether numbers are refused that are not usual of rock, which often are a slip of units.",
        "refuse",
    )


class GridKeys(Keys):
    """The regular grid of both walls."""

    cells_x: int = entry("Cells along x.", ge=3, le=4096)
    cells_y: int = entry("Cells along y.", ge=3, le=4096)
    spacing_mm: float = entry("Grid spacing h [mm].", gt=0)


class SurfaceKeys(Keys):
    """How walls are made from a JRC."""

    hurst: float = entry("Hurst exponent H of the self-affine walls.", gt=0, le=1)
    jrc_relation: Literal[tuple(RELATIONS)] = entry(
        "Published relation of JRC and Z2, with its sampling interval."
    )
    normalise: Literal["wall", "expectation"] = entry(
        "wall: every wall has exactly the Z2 of its JRC; expectation: on average."
    )
    correlation: float = entry(
        "Correlation of the lower wall with the negative of the upper: 0 independent, 1 mated.",
        ge=0,
        le=1,
    )
    shift_in_cells: int = entry("Shift of the mated part along x, in cells.", ge=0, le=4096)
    mismatch_wavelength_mm: float | None = entry(
        "Waves longer than this mate, shorter ones are independent [mm]; 0: mates; null: as "
        "correlation says. Where it is given correlation must be 0.",
        ge=0,
    )
    rule: Literal[RULES] = entry(
        "self_affine: profiles have the Hurst exponent; walk: independent slopes along x and y, "
        "projected on the nearest heights, where hurst only carries Z2 to the spacing."
    )
    roll_off_mm: float | None = entry(
        "Wavelength beyond which the power spectrum is flat [mm], at least two spacings; null for "
        "none.",
        gt=0,
    )


class StatisticsKeys(Keys):
    """Settings of the indifference intervals."""

    significance: float = entry("Significance level of the two-sided t test.", gt=0, lt=1)
    bootstrap_resamples: int = entry(
        "Resamples of the surfaces for each confidence interval.", ge=10, le=100_000
    )
    bootstrap_confidence: float = entry("Confidence of these intervals.", gt=0, lt=1)
    repetitions: int = entry(
        "Repetitions of the study that are drawn for what it would publish.", ge=100, le=1_000_000
    )
    control_variates: int | None = entry(
        "Surfaces that are made, and not closed, to tell the means of depths of the summed "
        "heights, by which means and intervals are adjusted (docs/accuracy.md); null: none are.",
        None,
        ge=100,
        le=1_000_000,
    )


class OutputKeys(Keys):
    """Settings of stored curves."""

    wall_strength_ratio: float = entry(
        "Compressive strength of the rock over that of the joint's walls (JCS), for the "
        "Barton-Bandis law in the figures of closure.",
        ge=1,
    )
    stress_points: int = entry(
        "Points of the common stress axis of closure curves.", ge=2, le=10_000
    )
    largest_stress_MPa: float | None = entry(
        "End of the common stress axis [MPa], at least every rock's maximum stress; null for the "
        "largest of these.",
        gt=0,
    )

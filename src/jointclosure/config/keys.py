"""The keys of a configuration's file: types, bounds and descriptions, with units in their names.

The only place that says what a key may be: the JSON schema, the table of keys
(config/README.md) and the checks of a file follow from it. Values and their sources are
in ``default.yaml``; what a key is in the library is in `jointclosure.config.typed`.
"""

from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    StringConstraints,
    Tag,
    create_model,
)

from jointclosure.config.units import in_unit
from jointclosure.parameters import OF_ROCK, PROPERTIES, Effects, Rock, key_of
from jointclosure.solvers.registry import SOLVERS
from jointclosure.surface.registration import ORIENTATIONS, SHIFTS
from jointclosure.surface.roughness import RELATIONS
from jointclosure.surface.synthesis import RULES

NAME = r"^[a-z][a-z0-9_]{0,40}$"

Name = Annotated[str, StringConstraints(pattern=NAME)]
Text = Annotated[str, StringConstraints(min_length=1)]
SectionKey = Annotated[str, StringConstraints(pattern=r"^[a-z]+[.][A-Za-z_]+$")]
Positive = Annotated[float, Field(gt=0)]
Share = Annotated[float, Field(gt=0, lt=1)]
Jrc = Annotated[float, Field(**PROPERTIES["jrc"].bounds)]
Poisson = Annotated[float, Field(**PROPERTIES["poisson_ratio"].bounds)]


def entry(description: str, default: Any = ..., **bounds):
    """A key with what it is; one with a default may be left out."""
    return Field(default, description=description, **bounds)


class Keys(BaseModel):
    """Keys that stand together; closed: an unknown one is an error."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


class StudyKeys(Keys):
    """What is studied, and how often."""

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


LevelKeys = create_model(
    "LevelKeys",
    __base__=Keys,
    __doc__="For each parameter to be varied, its values besides the rock's own, ascending.",
    **{
        key_of(name): (
            list[Annotated[float, Field(**about.bounds)]] | None,
            entry(
                "At least two values, strictly ascending; with the rock's own they make three "
                "levels or more; null for none.",
                None,
                min_length=2,
            ),
        )
        for name, about in PROPERTIES.items()
    },
)


RockEffectKeys = create_model(
    "RockEffectKeys",
    __base__=Keys,
    __doc__="Effects of this rock's cases, over those of the study.",
    **{name: (bool | None, entry("As in effects.", None)) for name in Effects._fields},
)


_WALL = entry(
    "A file, relative to where the study is run (or absolute); or, where the other wall is a file: "
    "rotated (that wall, turned by 180 degrees), mirrored, or synthetic (a wall of its slope "
    "and Hurst exponent, independent of it)."
)


class WallKeys(Keys):
    """Scanned walls instead of a JRC, docs/measured_walls.md."""

    upper: Text = _WALL
    lower: Text = _WALL
    units: Literal["m", "mm", "um", "nm"] | None = entry(
        "Of heights and distances, where the file does not say them.", None
    )
    spacing_mm: float | None = entry("Of a grid, where its file does not say it [mm].", None, gt=0)
    variable: str | None = entry(
        "Name of the array in an npz or netCDF file, or of a channel; needed where there are "
        "several.",
        None,
    )
    missing: Literal["refuse", "avoid", "nearest", "linear"] = entry(
        "What is done about cells without a height: refuse (an error, the default); avoid (joints "
        "are cut where none is missing); nearest, linear (filled).",
        "refuse",
    )
    largest_filled_share: float = entry(
        "Share of a wall's cells that may be filled; 0.05 unless given.", 0.05, ge=0, le=1
    )
    inverted: list[Literal["upper", "lower"]] = entry(
        "Walls (upper, lower) whose heights in the file point into the rock, as those of an upper "
        "wall in the lower one's frame; none unless given.",
        [],
        json_schema_extra={"uniqueItems": True},
    )
    bring_together: bool = entry(
        "Whether two files are brought together first: orientation checked, spikes cut, the common "
        "plane removed, the overlap found; false unless given: they are taken cell by cell.",
        False,
    )
    orientation: Literal[tuple(ORIENTATIONS)] | None = entry(
        "Of the upper file, where walls are brought together; null: the one that fits, if it is "
        "clear.",
        None,
    )
    shift: Literal[SHIFTS] | None = entry(
        "Where walls are brought together: scanned (left where they were) or mated (the upper one "
        "moved to where they fit best); null: scanned in a common frame, else mated.",
        None,
    )
    spikes: Literal["keep", "cut"] = entry(
        "Points that stand out from all but one of their neighbours, where walls are brought "
        "together: cut unless given.",
        "cut",
    )


class MeasuredKeys(Keys):
    """A measured closure curve of this rock's joint, drawn in fig_5_closure with its best fit."""

    file: Text = entry(
        "CSV file with columns stress, closure (units in their names, as stress_MPa,closure_mm) "
        "and cycle; a path from the project's folder."
    )
    stress_unit: Literal["Pa", "MPa", "GPa"] | None = entry(
        "Unit of the stresses, where the column's name has none.", None
    )
    closure_unit: Literal["m", "mm", "um"] | None = entry(
        "Unit of the closures, where the column's name has none.", None
    )


def intact_keys(base: type[BaseModel]) -> type[BaseModel]:
    """Keys of the properties of an intact rock; one with a default may be left out."""
    keys: dict[str, Any] = {}
    for name, about in OF_ROCK.items():
        unit = "" if about.unit == "1" else f" [{about.unit}]"
        default = Rock._field_defaults.get(name, ...)
        if default is not ...:
            default = float(in_unit(default, about.unit))
        keys[key_of(name)] = (
            float,
            entry(
                f"{about.title} {about.symbol} of the intact rock{unit}"
                + ("." if default is ... else f"; {default:g} unless given."),
                default,
                **about.bounds,
            ),
        )
    return create_model("IntactKeys", __base__=base, **keys)


class _TitledKeys(Keys):
    title: Text = entry("Name in tables and figures.")


class RockKeys(intact_keys(_TitledKeys)):
    """A rock; a study's own file may add some."""

    jrc: float | None = entry(
        "Joint roughness coefficient; left out (or null) where `walls` are given.",
        None,
        **PROPERTIES["jrc"].bounds,
    )
    max_normal_stress_MPa: float = entry(
        "Maximum nominal normal stress of every cycle [MPa].", gt=0
    )
    max_normal_stress_is_assumed: bool = entry(
        "Whether that stress is an assumption, to be flagged where it is shown; false unless "
        "given.",
        False,
    )
    effects: RockEffectKeys = entry(RockEffectKeys.__doc__, RockEffectKeys())
    levels: LevelKeys = entry(LevelKeys.__doc__)
    walls: WallKeys | None = entry(WallKeys.__doc__, None)
    measured: MeasuredKeys | None = entry(MeasuredKeys.__doc__, None)


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


class EffectKeys(Keys):
    """Effects that act; interaction needs substrate, gouge needs breakage."""

    substrate: bool = entry("Substrates deform, Eqs. (6) and (7).")
    interaction: bool = entry("Contacts displace each other, Eqs. (17) and (18).")
    breakage: bool = entry("Overloaded asperities break.")
    gouge: bool = entry("Broken material fills the valleys around.")
    soft_peaks: bool = entry("Peaks have a lower modulus than the rock.")
    auto: float | None = entry(
        "Relative change of a mean maximum closure below which an effect that is true is left out, "
        "decided for each rock by a pilot; null: none is. `effects: auto` is short for all effects "
        "and 0.02.",
        gt=0,
        lt=1,
    )


class ChoiceKeys(Keys):
    """What the paper leaves open."""

    base_radius_in_cells: float = entry(
        "Base radius r of an asperity over the grid spacing.", gt=0, le=1
    )
    peak_modulus_ratio: float = entry("Young's modulus of a peak over the rock's.", gt=0, le=1)
    concave: Literal["magnitude", "flat"] = entry(
        "How valleys and saddles count. magnitude: by the size of their curvature; flat: such a "
        "cell of a wall is level, and only the other wall's asperity gives the pair a curvature."
    )
    peaks: Literal["pristine", "current"] = entry(
        "Whether peaks are those of the walls before loading, or of the walls as they are."
    )
    largest_radius_mm: float | None = entry(
        "Upper bound of each wall's Gaussian radius [mm]; null for none, the paper's.", gt=0
    )
    tie_tolerance: float = entry(
        "Difference in height that counts as lower, over the walls' rms height.", gt=0, lt=0.001
    )


class WantedKeys(Keys):
    """The accuracy of a result: chooses preset, number of surfaces and control variates, and
    `make study` adds surfaces until it is reached (docs/accuracy.md)."""

    of: Literal["mean", "interval"] = entry(
        "mean: every case's mean maximum closure; interval: every indifference interval."
    )
    within: Share = entry(
        "Total error that is wanted, relative: bias and half the 95 % confidence interval."
    )
    most: int = entry("Surfaces a case beyond which none are added.", 200, ge=10, le=1_000_000)
    surfaces: int | None = entry(
        "Surfaces a case; null: as many as are predicted. `make study` sets it.", None, ge=10
    )


Accuracy = Annotated[
    Annotated[WantedKeys, Tag("wanted")] | Annotated[Share, Tag("number")],
    Discriminator(lambda value: "wanted" if isinstance(value, dict) else "number"),
]


class NumericsKeys(Keys):
    """Solver, steps and tolerances."""

    preset: str | None = entry(
        "A word for the other keys, as measured by the study of accuracy: quick, paper, accurate "
        "or converged.",
        None,
    )
    accuracy: Accuracy | None = entry(
        "What mean maximum closures may be off by, relative: takes the cheapest numerics that were "
        "found to reach it (needs choices.largest_radius_mm where anything breaks). Or the "
        "accuracy of a result, {of: mean, within: 0.05}.",
        None,
    )
    solver: Literal[tuple(SOLVERS)] = entry(
        "fast, or reference: the paper's own loop, for small grids."
    )
    breakage: Literal["fixed_step", "resolved"] = entry(
        "fixed_step: contacts break by the breakage steps (the paper's); resolved: by what brings "
        "them back to their strength, in steps controlled by an error estimate (fast solver)."
    )
    tolerance: float = entry(
        "What mean closures may be off by, relative, where breakage is resolved.", gt=0, le=0.1
    )
    displacement_step_um: float = entry("Displacement step of the first loading [um].", gt=0)
    breakage_step_um: float = entry(
        "Breakage step of the first loading [um]; smaller than the displacement step.", gt=0
    )
    later_displacement_step_um: float = entry(
        "Displacement step of every branch after the first loading [um].", gt=0
    )
    later_breakage_step_um: float = entry(
        "Breakage step of every branch after the first loading [um].", gt=0
    )
    target: Literal["equilibrate", "interpolate"] = entry(
        "equilibrate: repeat the last step, smaller, until the stress is met; interpolate: the "
        "paper's."
    )
    stress_tolerance: float = entry(
        "Relative distance to the maximum stress that counts as met.", gt=0, lt=1
    )
    force_tolerance: float = entry(
        "Relative residual of equilibrium that the fast solver reaches.", gt=0, lt=1
    )
    sweep_tolerance: float = entry(
        "Largest relative change of a force between two sweeps at which the reference stops.",
        gt=0,
        lt=1,
    )
    curve_points: int = entry(
        "Stresses of a closure curve, evenly spaced up to the maximum, where nothing breaks (fast "
        "solver).",
        ge=1,
        le=100_000,
    )
    most_steps: float = entry(
        "Displacement steps of a simulation, beyond which it is refused, or ends as "
        "too_many_steps.",
        ge=1,
    )
    most_breakage_steps: float = entry(
        "Breakage steps of a simulation for each of its cells, beyond which it is refused, or "
        "ends as breakage_not_at_rest.",
        ge=1,
    )
    replay: bool = entry(
        "Whether a cycle like the one before, whose unloading broke nothing, is that unloading's "
        "curve, up and down; false: it is closed again."
    )
    idle_interaction: float | None = entry(
        "The interaction is left out of the first loading while it would displace no contact by "
        "more than this share of the closure; 0: never; null: effects.auto, where that is given.",
        ge=0,
        lt=1,
    )


class StatisticsKeys(Keys):
    """Of the indifference intervals."""

    significance: float = entry("Significance level of the two-sided t test.", gt=0, lt=1)
    bootstrap_resamples: int = entry(
        "Resamples of the surfaces for each confidence interval.", ge=10, le=100_000
    )
    bootstrap_confidence: float = entry("Confidence of these intervals.", gt=0, lt=1)
    repetitions: int = entry(
        "Repetitions of the study that are drawn for what it would publish.", ge=100, le=1_000_000
    )
    jrc_half_widths: list[Positive] = entry(
        "Half-widths of a JRC that is known to a range only (target jrc_range).", [1.0, 2.0]
    )
    control_variates: int | None = entry(
        "Surfaces that are made, and not closed, to tell the means of depths of the summed "
        "heights, by which means and intervals are adjusted (docs/accuracy.md); null: none are.",
        None,
        ge=100,
        le=1_000_000,
    )


class OutputKeys(Keys):
    """What is stored."""

    wall_strength_ratio: float = entry(
        "Compressive strength of the rock over that of the joint's walls (JCS), for the "
        "Barton-Bandis law in fig_5_closure.",
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


class PointKeys(Keys):
    """A knob and its value."""

    knob: str = entry("Its name.")
    value: float | str = entry("Its value.")


class SceneKeys(Keys):
    """A variant of the model in an accuracy study: sections that are merged over the study's."""

    study: dict[str, Any] = entry("Merged over study.", {})
    effects: dict[str, Any] = entry("Merged over effects.", {})
    choices: dict[str, Any] = entry("Merged over choices.", {})
    numerics: dict[str, Any] = entry("Merged over numerics.", {})
    grid: dict[str, Any] = entry("Merged over grid.", {})
    surface: dict[str, Any] = entry("Merged over surface.", {})
    rocks: dict[str, Any] = entry("Merged over rocks.", {})
    finest: PointKeys = entry(
        "Knob and value that the other settings of the variant are held against; knob `base` for "
        "none turned."
    )
    cross: PointKeys | None = entry(
        "The finest setting of another integrator, that the variant's own is held against.", None
    )


class NamedValueKeys(Keys):
    """A value of a knob that stands for settings."""

    value: str = entry("Its name.")
    set: dict[str, Any] = entry("Settings that it stands for.")


KnobValue = Annotated[
    Annotated[NamedValueKeys, Tag("named")] | Annotated[float | str, Tag("plain")],
    Discriminator(lambda value: "named" if isinstance(value, dict) else "plain"),
]


class KnobKeys(Keys):
    """A knob: ``key`` is set to each value, or ``scale`` multiplied, or a value brings its own."""

    scenes: list[str] = entry("Variants of the model in which it is turned.", min_length=1)
    other_joints: bool = entry(
        "Whether it changes the joints themselves: a difference there is no numerical error.",
        False,
    )
    set: dict[str, Any] = entry("Settings that hold at all values.", {})
    key: SectionKey | None = entry("What is set, as section.key.", None)
    scale: list[SectionKey] | None = entry(
        "What is multiplied, as section.key.", None, min_length=1
    )
    values: list[KnobValue] = entry(
        "Numbers or words; or, without key and scale, a name (`value`) and settings (`set`) each.",
        min_length=1,
    )


class TotalErrorKeys(Keys):
    """The diagram of total error (`snakemake total_error`): every way to a result, with what a
    finished study says of scatter and control variates."""

    study: Name = entry(
        "Study whose tables are read, of the size and stress of `scene`; `.venv/bin/snakemake "
        "surrogate` has been run on it too."
    )
    scene: str = entry("Variant of the model whose errors of means and times count.")
    methods: dict[Name, PointKeys] = entry(
        "Settings that are compared by name, each a knob and its value in `scene`.", min_length=1
    )
    interval_scene: str = entry("Variant of the model whose errors of intervals count.")
    interval_cycles: list[int] | None = entry(
        "Cycles of whose intervals it is; null: all of which errors are known.", None
    )
    interval_methods: dict[Name, PointKeys] = entry(
        "The same settings in `interval_scene`; one that is left out is taken from `scene`.", {}
    )
    budgets_min: list[Positive] = entry(
        "Core-minutes for which the best split is tabulated.", min_length=1
    )


class AccuracyKeys(Keys):
    """Design of a study of what accuracy costs (config/accuracy.yaml): variants of the model, and
    the knobs that are turned in each."""

    parameter: Literal[Rock._fields] = entry(
        "Rock property at whose levels every run closes the surfaces, and whose indifference "
        "interval is followed."
    )
    resamples: int = entry("Resamples of the surfaces for confidence intervals.", ge=10, le=100_000)
    confidence: float = entry("Confidence of these intervals.", gt=0, lt=1)
    presets: dict[Name, PointKeys] = entry(
        "Words for settings of the numerics (numerics.preset), each a knob and its value."
    )
    scenes: dict[Name, SceneKeys] = entry(
        "Variants of the model by name: sections of a configuration that are merged over the "
        "study's, and `finest`, the knob and value that the others are held against.",
        min_length=1,
    )
    knobs: dict[Name, KnobKeys] = entry(
        "Knobs by name: either `key` (section.key) is set to each value, or each key of `scale` is "
        "multiplied by it, or each value brings the settings that it stands for.",
        min_length=1,
    )
    total: TotalErrorKeys | None = entry(TotalErrorKeys.__doc__, None)


class ValidationKeys(Keys):
    """Random conditions at which the effects that a pilot selects (effects.auto) are held against
    the full model."""

    scenes: int = entry(
        "Number of random conditions: rock, roughness, stress and size.", ge=1, le=100_000
    )
    realizations: int = entry("Surfaces of each.", ge=2, le=100_000)
    tolerances: list[Share] = entry("Tolerances of the selection.", min_length=1)
    cells: list[Annotated[float, Field(ge=3, le=512)]] = entry(
        "Range of the cells along a square joint.", min_length=2, max_length=2
    )
    youngs_modulus_GPa: list[Positive] = entry(
        "Range of Young's modulus [GPa], uniform in its logarithm.", min_length=2, max_length=2
    )
    poisson_ratio: list[Poisson] = entry("Range of Poisson's ratio.", min_length=2, max_length=2)
    compressive_strength_MPa: list[Positive] = entry(
        "Range of the compressive strength [MPa], uniform in its logarithm.",
        min_length=2,
        max_length=2,
    )
    jrc: list[Jrc] = entry("Range of the joint roughness coefficient.", min_length=2, max_length=2)
    stress_MPa: list[Positive] = entry(
        "Range of the maximum normal stress [MPa], uniform in its logarithm; at most the strength.",
        min_length=2,
        max_length=2,
    )


class AblationKeys(Keys):
    """Conditions of a study of what each effect adds (config/effects.yaml); every well-posed
    scene is closed at each."""

    jrc: list[Jrc] = entry("Joint roughness coefficients.", min_length=1)
    stress_MPa: list[Positive] = entry("Maximum normal stresses [MPa].", min_length=1)
    validation: ValidationKeys | None = entry(ValidationKeys.__doc__, None)


class MismatchKeys(Keys):
    """Design of a study of mated, natural and non-mated walls (config/mismatch.yaml)."""

    wavelength_mm: list[Annotated[float, Field(ge=0)]] = entry(
        "Mismatch wavelengths [mm], 0 for mates; independent walls are closed too.",
        min_length=1,
        json_schema_extra={"uniqueItems": True},
    )
    shift_in_cells: list[Annotated[int, Field(ge=0, le=4096)]] = entry(
        "Shifts of the walls along x, in cells; 0 must be among them.",
        min_length=1,
        json_schema_extra={"uniqueItems": True},
    )
    tolerance: float = entry(
        "Shifted walls behave as independent ones where the mean closure since seating of the "
        "first cycle is less below theirs than this share.",
        gt=0,
        lt=1,
    )


class SizeSpectrumKeys(Keys):
    """Spectrum of the walls of a study of the scale effect; as in `surface`."""

    hurst: float = entry("Hurst exponent H.", gt=0, le=1)
    roll_off_mm: float | None = entry(
        "Wavelength beyond which the power spectrum is flat [mm]; null for none.", gt=0
    )


class SizeKeys(Keys):
    """Design of a study of the scale effect (config/size.yaml): patches cut out of larger walls,
    and sampled at several spacings."""

    patch_mm: list[Positive] = entry(
        "Side lengths of the square patches [mm], each a whole number of times in the largest; "
        "that of the grid must be among them.",
        min_length=2,
        json_schema_extra={"uniqueItems": True},
    )
    spacing_mm: list[Positive] = entry(
        "Spacings [mm], whole multiples of the finest; that of the grid must be among them.",
        min_length=1,
        json_schema_extra={"uniqueItems": True},
    )
    most_cells: int = entry(
        "Cells along a side beyond which a patch is closed at the spacing of the grid only.",
        ge=3,
        le=4096,
    )
    spectra: dict[Name, SizeSpectrumKeys] = entry(
        "Spectra of the walls by name, all made of the same noise.", min_length=1
    )


class MisalignmentKeys(Keys):
    """Design of a study of walls that are tilted or rotated (config/misalignment.yaml)."""

    tilt_degrees: list[Annotated[float, Field(ge=0, le=5)]] = entry(
        "Tilts of one wall about an axis in its mean plane [degrees]; 0 must be among them.",
        min_length=1,
        json_schema_extra={"uniqueItems": True},
    )
    rotation_degrees: list[Annotated[float, Field(ge=0, lt=360)]] = entry(
        "Rotations of one wall about the normal [degrees]; 0 must be among them.",
        min_length=1,
        json_schema_extra={"uniqueItems": True},
    )
    mismatch_wavelength_mm: list[Annotated[float, Field(gt=0)]] = entry(
        "Mismatch wavelengths [mm] of walls that are closed besides independent ones.",
        json_schema_extra={"uniqueItems": True},
    )


class ReadingKeys(Keys):
    """A reading of the paper: settings that are merged over the study's."""

    title: Text = entry("Its name in tables and figures.")
    set: dict[str, Any] = entry("Settings that it stands for, merged over the study's.", {})
    closure: Literal["max_closure", "max_closure_seated", "max_closure_net"] = entry(
        "Which closure is read: from first touch, from seating, or net of bulk indentation.",
        "max_closure",
    )
    allowed: bool = entry("Whether the paper's text allows it.", True)


class RoundKeys(Keys):
    """A round of a study of readings: who enters, and how much is spent on each."""

    name: Name = entry("Its name.")
    candidates: Literal["singles", "kept", "pairs"] = entry(
        "singles: all readings (first round); kept: those that the round before kept; pairs: these "
        "and their pairs."
    )
    rocks: list[str] | None = entry(
        "Rocks that are closed; the others are taken to change as these do. null: all.", None
    )
    realizations: int = entry("Surfaces of each case, with those of earlier rounds.", ge=3)
    most: int = entry("How many of those kept may enter, the best first.", 1000, ge=1)
    margin: float = entry(
        "Standard errors by which a reading may be behind the best and still be kept.", gt=0
    )


class ReadingsKeys(Keys):
    """Design of a study of which reading of the paper gives its Table 3
    (config/readings.yaml)."""

    reference_realizations: int = entry(
        "Surfaces of each case of the study as configured, in all rocks.", ge=3
    )
    draws: int = entry("Surfaces of each case in the paper's own study.", ge=2)
    repetitions: int = entry("Repetitions of the paper's study that are drawn.", ge=100)
    groups: int = entry("Groups of surfaces of the jackknife, at most.", ge=2)
    aspects: dict[Name, dict[Name, ReadingKeys]] = entry(
        "Readings by what they are a reading of, and by name; pairs are made of two aspects.",
        min_length=1,
    )
    rounds: list[RoundKeys] = entry("What is closed, in turn.", min_length=1)


class InputKeys(Keys):
    """A key that varies in a study of global sensitivity."""

    title: Text = entry("Its name in tables and figures.")
    key: Annotated[str, StringConstraints(pattern=r"^[a-z]+([.][A-Za-z_]+)+$")] = entry(
        "Its path, as surface.hurst; ROCK stands for the rock, as rocks.ROCK.jrc."
    )
    between: (
        Annotated[str, StringConstraints(pattern="^levels$")]
        | Annotated[list[float], Field(min_length=2, max_length=2)]
        | None
    ) = entry("Ends of its range; levels: the outermost of the rock's own.", None)
    logarithmic: bool = entry("Whether it is uniform in its logarithm.", False)
    values: list[Any] | None = entry("The few values that it has, in place of a range.", None)


class DependentKeys(Keys):
    """Two inputs that depend on each other, for Shapley effects."""

    inputs: list[Name] = entry("Their names.", min_length=2, max_length=2)
    correlation: float = entry("Of the normal variables whose ranks they have.", gt=-1, lt=1)


class GlobalSensitivityKeys(Keys):
    """Design of a study in which properties and open choices vary together
    (config/global_sensitivity.yaml)."""

    rows: int = entry(
        "Rows of the design, a power of 2; each closes two joints at every point, of which there "
        "are two more than inputs.",
        ge=16,
        le=65536,
    )
    rows_per_job: int = entry("Rows that a job closes.", ge=1)
    inputs: dict[Name, InputKeys] = entry("What varies, by name.", min_length=2)
    dependent: list[DependentKeys] = entry("Inputs that depend on each other.", [])


class ConfigurationKeys(Keys):
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
        "(docs/flow.md); it changes nothing else.",
        False,
    )
    choices: ChoiceKeys = entry(ChoiceKeys.__doc__)
    numerics: NumericsKeys = entry(NumericsKeys.__doc__)
    statistics: StatisticsKeys = entry(StatisticsKeys.__doc__)
    output: OutputKeys = entry(OutputKeys.__doc__)
    accuracy: AccuracyKeys | None = entry(AccuracyKeys.__doc__, None)
    ablation: AblationKeys | None = entry(AblationKeys.__doc__, None)
    readings: ReadingsKeys | None = entry(ReadingsKeys.__doc__, None)
    global_sensitivity: GlobalSensitivityKeys | None = entry(GlobalSensitivityKeys.__doc__, None)
    mismatch: MismatchKeys | None = entry(MismatchKeys.__doc__, None)
    size: SizeKeys | None = entry(SizeKeys.__doc__, None)
    misalignment: MisalignmentKeys | None = entry(MisalignmentKeys.__doc__, None)

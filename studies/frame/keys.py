"""Sections of a configuration, their JSON schema, and problems of a file.

A section is checked in the units of its keys, and has SI values once it is read: the key
``spacing_mm`` of a file is the attribute ``spacing`` [m].
"""

import functools
import math
import re
import unicodedata
from collections.abc import Callable, Iterator
from typing import Annotated, Any, Literal, Self, TypeVar, get_args, get_type_hints

import pydantic
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, GetPydanticSchema, Strict
from pydantic_core import core_schema

from jointclosure.inputs import did_you_mean
from jointclosure.inputs.keywords import documented
from jointclosure.parameters import PROPERTIES, SOLVER_NAMES, Choices, Effects, Numerics
from jointclosure.parameters.units import bounds_of, name_and_unit, to_si
from jointclosure.walls.jrc import RELATIONS
from jointclosure.walls.synthesis import RULES
from studies.frame.yaml_files import refuse, short

_LARGEST = 10**300
"""Largest integer that is accepted; larger ones may be no floating-point number in some unit."""
_STEPS = [name for name in Numerics._fields if name.endswith("_step")]
T = TypeVar("T")
_Keys = TypeVar("_Keys", bound=BaseModel)


def must(words: str, holds: Callable[[Any], bool]) -> AfterValidator:
    """Return an annotation by which a value must satisfy ``holds``.

    Otherwise pydantic reports an error that the value "must" do what ``words`` say.
    """

    def checked(value: Any) -> Any:
        if not holds(value):
            raise ValueError(f"must {words}")
        return value

    return AfterValidator(checked)


Several = Annotated[tuple[T, ...], Strict(False)]
Distinct = Annotated[
    Several[T],
    must("not have a value twice", lambda values: len(set(values)) == len(values)),
    Field(json_schema_extra={"uniqueItems": True}),
]
Ascending = Annotated[Distinct[T], AfterValidator(lambda values: tuple(sorted(values)))]
WithZero = Annotated[Ascending[T], must("have 0 among them", lambda values: 0 in values)]
Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,40}$")]
Text = Annotated[
    str, Field(min_length=1), must("not be blank", lambda text: not text or bool(text.strip()))
]
Positive = Annotated[float, Field(gt=0)]
Share = Annotated[float, Field(gt=0, lt=1)]
Jrc = Annotated[float, Field(**PROPERTIES["jrc"].bounds)]


def entry(description: str, default: Any = ..., *, alias: str | None = None, **about: Any) -> Any:
    """Declare a key of a configuration, with its description and its default [SI].

    ``alias`` is the name of the key in files if it differs from that of the attribute, for example
    by a unit at its end. ``about`` are arguments of `pydantic.Field`; bounds among them are in that
    unit. Values are converted to SI after they are checked.
    """

    def in_si(value: Any) -> Any:
        (converted,) = to_si({str(alias): value}).values()
        return tuple(converted) if isinstance(converted, list) else converted

    field = Field(default, description=description, alias=alias, **about)
    if alias is not None and name_and_unit(alias)[1]:
        field.metadata.append(AfterValidator(in_si))
    return field


class Section(BaseModel):
    """Keys that stand together; an unknown one is an error."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)

    def _replace(self, **changes: Any) -> Self:
        """Return a copy with other values [SI], which are not checked."""
        return self.model_copy(update=changes)


def keys_of(fields: Any, **units: str) -> Any:
    """Return the class of a section that has a key for each field of `Choices` or `Numerics`.

    ``units`` has the units in which files state fields, by the name of the field. Descriptions are
    those in the docstring of ``fields``.
    """
    keys: dict[str, Any] = {}
    for name, text in documented(fields).items():
        kind = get_type_hints(fields)[name]
        unit = units.get(name)
        bounds = {}
        if {kind, *get_args(kind)} & {float, int}:
            interval, *_ = getattr(fields.__annotations__[name], "__metadata__", ["(0, inf)"])
            bounds = bounds_of(interval)
        alias = f"{name}_{unit}" if unit else name
        keys[name] = kind, entry(text.replace("None", "null"), alias=alias, **bounds)
    return pydantic.create_model(fields.__name__, __base__=Section, **keys)


def made_of(section: type[Section]) -> GetPydanticSchema:
    """Return the annotation of a named tuple whose fields are read from the keys of a section."""

    def schema(kind: Any, handler: Any) -> Any:
        return core_schema.no_info_after_validator_function(
            # checked with the whole configuration
            lambda read: kind._make(getattr(read, name) for name in kind._fields),
            handler(section),
        )

    return GetPydanticSchema(schema)


OR_NULL = GetPydanticSchema(lambda kind, handler: core_schema.nullable_schema(handler(kind)))
"""Annotation of a value that may be null in a file. The section replaces null by a value when it is
read."""


class Accuracy(Section):
    """Accuracy that is requested of a study: joints are simulated until it is reached."""

    within: Share = entry("Half of the 95 % confidence interval, relative.")
    of: Literal["mean", "interval", "stiffness"] = entry(
        "mean: of every case's mean maximum closure, gross from first touch and net since seating; "
        "interval: of every indifference interval; stiffness: of every case's mean net stiffness.",
        "mean",
    )
    budget_core_minutes: float | None = entry(
        "Processor time that the joints of all cases may take; null: any.", None, gt=0
    )
    most: int = entry("Largest number of realisations of a case.", 200, ge=10, le=1_000_000)


class Study(Section):
    """Rocks, cases and numbers of realisations of a study."""

    name: Name = entry("Name of the study; results are written to results/<name>/.")
    rocks: Distinct[str] = entry(
        "Rocks of the study, from `rocks`, in the order of the tables.", min_length=1
    )
    realizations: int = entry("Random pairs of walls per case.", ge=2, le=1_000_000)
    realizations_per_job: int | None = entry(
        "Realisations of a case in one job; null: as many as take about five minutes. It changes "
        "no result.",
        None,
        ge=1,
    )
    cycles: int = entry("Load-unload cycles.", ge=1, le=1000)
    root_seed: int = entry("Seed from which every random number follows.", ge=0)
    draws: Literal["common", "independent"] = entry(
        "independent: each case has different pairs of walls, and Table 3 has the unpaired t test, "
        "as in the paper; common: a realisation has the same random numbers in all cases of a "
        "rock, and the test is paired."
    )
    pool: int | None = entry(
        "Further random pairs of walls of every rock, which are simulated in all of its cases "
        "(pool.nc). Properties of the model and repetitions of the study follow from them; null: "
        "from the pairs of walls of the study.",
        ge=2,
        le=1_000_000,
    )
    surfaces_of: Name | None = entry(
        "Study whose random pairs of walls are used, so that two studies can be compared joint by "
        "joint; null: those of this study."
    )
    accuracy: Accuracy | None = entry(
        "Requested accuracy: results are corrected by differences to finer numerics on some of the "
        "realisations (docs/accuracy.md); null: none.",
        None,
    )
    unusual_values: Literal["refuse", "allow"] = entry(
        "Whether numbers that are unusual for rock, often in a wrong unit, are refused.",
        "refuse",
    )


class Grid(Section):
    """The regular grid of both walls."""

    cells_x: int = entry("Cells along x.", ge=3, le=4096)
    cells_y: int = entry("Cells along y.", ge=3, le=4096)
    spacing: float = entry("Grid spacing h [mm].", alias="spacing_mm", gt=0)

    @property
    def shape(self) -> tuple[int, int]:
        """Cells (y, x)."""
        return self.cells_y, self.cells_x


class SurfaceSynthesis(Section):
    """Synthesis of random walls from a JRC: spectrum, Hurst exponent, mating and shift."""

    hurst: float = entry("Hurst exponent H of the self-affine walls.", gt=0, le=1)
    jrc_relation: Literal[tuple(RELATIONS)] = entry(  # type: ignore[valid-type]
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
    mismatch_wavelength: float | None = entry(
        "Wavelength [mm] above which the walls mate, and below which they are independent; 0: the "
        "walls mate exactly; null: correlation is used. If it is given, correlation must be 0.",
        alias="mismatch_wavelength_mm",
        ge=0,
    )
    rule: Literal[RULES] = entry(  # type: ignore[valid-type]
        "self_affine: profiles have the Hurst exponent; walk: independent slopes along x and y, "
        "and the heights that are nearest to them (hurst then only converts Z2 to the spacing)."
    )
    roll_off: float | None = entry(
        "Wavelength beyond which the power spectrum is flat [mm], at least two spacings; null for "
        "none.",
        alias="roll_off_mm",
        gt=0,
    )


class StudyEffects(Section):
    """Effects that act; interaction needs substrate, gouge needs breakage."""

    substrate: bool = entry("Substrates deform, Eqs. (6) and (7).")
    interaction: bool = entry("Contacts displace each other, Eqs. (17) and (18).")
    breakage: bool = entry("Overloaded asperities break.")
    gouge: bool = entry("Broken material fills the valleys around.")
    soft_peaks: bool = entry("Peaks have a lower modulus than the rock.")
    auto: float | None = entry(
        "Relative change of a mean closure below which an effect that is true is left out, "
        "decided for each rock; null: none is. `effects: auto` is short for all effects "
        "and 0.02.",
        gt=0,
        lt=1,
    )

    @property
    def acting(self) -> Effects:
        """Effects that act in rocks without separate ones."""
        return Effects._make(getattr(self, name) for name in Effects._fields)


class ChoiceKeys(keys_of(Choices, largest_radius="mm")):  # type: ignore[misc]
    """Decisions that the paper leaves open."""


class NumericsKeys(keys_of(Numerics, **dict.fromkeys(_STEPS, "um"))):  # type: ignore[misc]
    """Solver, steps and tolerances."""

    solver: Literal[SOLVER_NAMES] = entry(  # type: ignore[valid-type]
        "fast, or reference: the paper's own loop, for small grids."
    )
    idle_interaction: float | None = entry(
        "The interaction is left out of the first loading while it would displace no contact by "
        "more than this share of the closure; 0: never; null: effects.auto, where that is given.",
        ge=0,
        lt=1,
    )


class Statistics(Section):
    """Settings of the indifference intervals."""

    significance: float = entry("Significance level of the two-sided t test.", gt=0, lt=1)
    bootstrap_resamples: int = entry(
        "Resamples of the realisations for each confidence interval.", ge=10, le=100_000
    )
    bootstrap_confidence: float = entry("Confidence of these intervals.", gt=0, lt=1)
    repetitions: int = entry(
        "Repetitions of the study that are sampled from the pool.", ge=100, le=1_000_000
    )
    control_variates: int | None = entry(
        "Pairs of walls that are generated but not simulated; their mean depths of the summed "
        "heights adjust means and intervals (docs/accuracy.md#control-variates); null: nothing is "
        "adjusted.",
        None,
        ge=100,
        le=1_000_000,
    )


class Output(Section):
    """Settings of stored curves."""

    wall_strength_ratio: float = entry(
        "Compressive strength of the rock over that of the joint's walls (JCS), for the "
        "Barton-Bandis law in the figures of closure.",
        ge=1,
    )
    stress_points: int = entry(
        "Points of the common stress axis of closure curves.", ge=2, le=10_000
    )
    largest_stress: Annotated[float, OR_NULL] = entry(
        "End of the common stress axis [MPa], at least every rock's maximum stress; null for the "
        "largest of these.",
        gt=0,
        alias="largest_stress_MPa",
    )


@functools.cache
def json_schema(keys: type[BaseModel]) -> dict:
    """Return the JSON schema of a model of keys, with references written out.

    No key is required, as files are merged over the default configuration.
    """
    whole = keys.model_json_schema()
    about = _written_out(whole, whole.pop("$defs", {}))
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | about


def _written_out(schema: dict, parts: dict) -> dict:
    """Return a JSON schema in which references are replaced by the ``parts`` that they name.

    Alternatives (anyOf) are merged into one; titles, defaults and required keys are left out.
    """
    if "$ref" in schema:
        schema = parts[schema["$ref"].rpartition("/")[2]] | schema
    left_out = ("$ref", "title", "default", "required")  # a file overrides defaults
    schema = {k: v for k, v in schema.items() if k not in left_out}
    for kind in (_written_out(option, parts) for option in schema.pop("anyOf", [])):
        of_both = (part.get("type", []) for part in (schema, kind))
        names = [n for names in of_both for n in (names if isinstance(names, list) else [names])]
        schema = kind | schema | ({"type": names if len(names) > 1 else names[0]} if names else {})
        if "enum" in schema and "null" in names and None not in schema["enum"]:
            schema["enum"] = [*schema["enum"], None]
    for pattern, part in schema.pop("patternProperties", {}).items():
        schema |= {"propertyNames": {"pattern": pattern}, "additionalProperties": part}
    for name in ("items", "additionalProperties"):
        if isinstance(schema.get(name), dict):
            schema[name] = _written_out(schema[name], parts)
    if inner := schema.get("properties"):
        schema["properties"] = {name: _written_out(part, parts) for name, part in inner.items()}
    if "description" in schema:
        schema["description"] = " ".join(schema["description"].split())
    return schema


def validated(keys: type[_Keys], settings: dict, what: str = "configuration") -> _Keys:
    """Return nested keys as read and checked by a model.

    Raise `ConfigurationError` that lists each wrong key; ``what`` begins its message.
    """
    refuse(_not_readable(settings), what)
    try:
        return keys.model_validate(settings)
    except pydantic.ValidationError as error:
        refuse(_problems(keys, settings, error.errors(include_url=False)), what)
        raise


def _not_readable(settings: object, path: tuple[str, ...] = ()) -> Iterator[str]:
    """Generate a line for each text or number of nested keys that cannot be shown in results.

    These are invisible characters, and numbers beyond `_LARGEST`. ``path`` leads to the keys.
    """
    where = ".".join(path)
    if isinstance(settings, dict):
        for key, value in settings.items():
            if hidden := _hidden(str(key)):
                yield f"{'.'.join((*path, repr(key)))}: must not have the character {hidden}"
            yield from _not_readable(value, (*path, str(key)))
    elif isinstance(settings, list | tuple):
        for value in settings:
            yield from _not_readable(value, path)
    elif isinstance(settings, str) and (hidden := _hidden(settings)):
        allowed = f"must not have the character {hidden}, which cannot be shown in a line"
        yield f"{where} = {short(settings)}: {allowed}"
    elif isinstance(settings, int) and abs(settings) > _LARGEST:
        yield f"{where} = {short(settings)}: must be a number below 1e300"


def _hidden(text: str) -> str:
    """Return the code point of the first invisible character, such as a line break; "" if none."""
    hidden = (c for c in text if not c.isprintable() and unicodedata.category(c) != "Zs")
    return next((f"U+{ord(character):04X}" for character in hidden), "")


def _problems(keys: type[BaseModel], settings: dict, found: list) -> Iterator[str]:
    """Generate a line for each key of the settings in which pydantic ``found`` errors."""
    by_key: dict[tuple, list] = {}
    lists = {problem["loc"][:-1] for problem in found}
    for problem in found:
        if problem["type"] == "too_short" and problem["loc"] in lists:
            continue  # the list is too short only because wrong values do not count
        path = _path(problem["loc"], settings)
        missing = problem["type"] == "missing"
        # one line for all missing keys of a section
        by_key.setdefault((path[:-1] if missing else path, missing), []).append(problem)
    for (path, missing), errors in by_key.items():
        # a value of a list is named by the list's key
        where = ".".join(part for part in path if isinstance(part, str))
        first = errors[0]
        named = where or "the configuration"
        if missing:
            yield f"{named}: lacks {', '.join(e['loc'][-1] for e in errors)}"
        elif first["type"] == "value_error" and not path:
            yield from str(first["ctx"]["error"]).splitlines()
        else:
            allowed = " or ".join(dict.fromkeys(map(_allowed, errors)))
            if first["type"] == "extra_forbidden":
                known = _known(keys, path[:-1])
                allowed = (
                    f"unknown key{did_you_mean(path[-1], known)} (allowed: {', '.join(known)})"
                )
            elif path == ("effects",):
                allowed = "must be auto, or effects with true or false"
            yield f"{named} = {short(first['input'])}: {allowed}"


def _path(location: tuple, settings) -> tuple:
    """Return the path of keys in ``settings`` to which the location of a pydantic error leads.

    Parts of the location that name types are left out. The last key of the path may be missing in
    the settings.
    """
    path = []
    value = settings
    for number, part in enumerate(location):
        within = isinstance(value, dict) and part in value
        within = within or (isinstance(value, list) and isinstance(part, int) and part < len(value))
        if within:
            path.append(part)
            value = value[part]
        elif number == len(location) - 1 and isinstance(value, dict) and part != "[key]":
            path.append(part)  # a key that is missing
    return tuple(path)


def _allowed(error: dict) -> str:
    """Return in words what is allowed in place of the value of a pydantic error.

    Words are those of pydantic where these are clear.
    """
    kind = error["type"]
    about = error.get("ctx", {})
    value = error["input"]
    if kind == "literal_error":
        words = re.findall(r"'([^']*)'", about["expected"])
        return f"must be one of {', '.join(words)}{did_you_mean(value, words)}"
    if kind == "value_error":  # of a check of the package: "name = value: what is allowed"
        return str(about["error"]).rpartition(": ")[2]
    if kind == "model_type":
        return "must contain keys and values"
    if kind == "string_pattern_mismatch":
        return f"must match {about['pattern']} (letters, digits and underscores)"
    if kind in ("tuple_type", "list_type"):
        return "must be a list of values, such as [1, 2]"
    allowed = re.sub(r"^\w+ should", "must", error["msg"]).replace(" after validation", "")
    if isinstance(value, list) and kind in ("float_type", "int_type"):
        return f"{allowed}, not a list; further values of a property of rock belong to its levels"
    if isinstance(value, str) and kind in ("float_type", "int_type"):
        return "; ".join(filter(None, [allowed, _remark_on_number(value, _unit_of(error))]))
    return allowed


def _remark_on_number(text: str, unit: str) -> str:
    """Say how to write a number that YAML reads as text; "" if the text is no number.

    ``unit`` is that of its key, or "".
    """
    if re.fullmatch(r"[-+]?[0-9]+,[0-9]+", text):
        return f"the decimal sign is a point: write {text.replace(',', '.')}"
    of_key = f"; the key is in {unit}" if unit else ""
    # 1e-3 is a text to YAML, 1.0e-3 is a number
    if match := re.fullmatch(r"([-+]?[0-9]+)([eE])([-+]?)([0-9]+)", text):
        if math.isinf(float(text)):
            return f"{text} is too large for a number"
        digits, e, sign, power = match.groups()
        return f"YAML reads it as text: write {digits}.0{e}{sign or '+'}{power}{of_key}"
    if re.fullmatch(rf"{_NUMBER}\s*[a-zA-Z%°][a-zA-Z0-9/]*", text.strip()):
        return f"write a number without a unit{of_key}"
    return ""


def _unit_of(error: dict) -> str:
    """Return the unit of the key at which an error is, or of the one that contains it; or ""."""
    keys = (part for part in reversed(error["loc"]) if isinstance(part, str))
    return next((unit for _, unit in map(name_and_unit, keys) if unit), "")


_NUMBER = r"[-+]?[0-9]+(?:\.[0-9]*)?(?:[eE][-+]?[0-9]+)?"
"""A number as YAML and Python write it."""


def _known(keys: type[BaseModel], path: tuple) -> list[str]:
    """Return the names of the keys that a model allows at a path of keys."""
    schema = json_schema(keys)
    for part in path:
        within = "items" if isinstance(part, int) else "additionalProperties"
        schema = schema.get("properties", {}).get(part) or schema[within]
    return list(schema["properties"])

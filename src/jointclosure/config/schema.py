"""What keys of a file may be, as a JSON schema, and what a file has against it, one line each."""

import difflib
import math
import re
import types
import typing
from collections.abc import Iterator

import pydantic

_BOUNDS = {
    "greater_than": ("gt", "above"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "below"),
    "less_than_equal": ("le", "at most"),
}
_TYPES = {
    "int_type": "integer",
    "float_type": "number",
    "string_type": "string",
    "bool_type": "boolean",
    "list_type": "array",
    "dict_type": "object",
    "model_type": "object",
}


def json_schema(keys: type[pydantic.BaseModel]) -> dict:
    """JSON schema of a model of keys, all in one: no references."""
    whole = keys.model_json_schema()
    about = _written_out(whole, whole.pop("$defs", {}))
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | about


def problems(keys: type[pydantic.BaseModel], settings: dict) -> list[str]:
    """What settings have against a model of keys, one line for each key."""
    try:
        keys.model_validate(settings)
    except pydantic.ValidationError as error:
        found: dict[tuple, list] = {}
        for each in error.errors(include_url=False):
            path, kind = _path(each["loc"], settings), _kind(each["type"])
            if kind == "missing":  # one line for all that a section lacks
                path = path[:-1]
            found.setdefault((path, kind), []).append(each)
        return [
            line
            for (path, kind), errors in found.items()
            for line in _explained(keys, settings, path, kind, errors)
        ]
    return []


def _written_out(schema: dict, parts: dict) -> dict:
    """A schema with its references put in, and what may be null or missing said in one way."""
    if "$ref" in schema:
        own = {key: value for key, value in schema.items() if key != "$ref"}
        return _written_out(parts[schema["$ref"].rpartition("/")[2]] | own, parts)
    schema = {key: value for key, value in schema.items() if key not in ("title", "default")}
    kinds = [_written_out(each, parts) for each in schema.pop("anyOf", schema.pop("oneOf", []))]
    for kind in kinds:
        names = [*_kinds(schema), *_kinds(kind)]
        schema = kind | schema | ({"type": names if len(names) > 1 else names[0]} if names else {})
        if "enum" in schema and "null" in names and None not in schema["enum"]:
            schema["enum"] = [*schema["enum"], None]
    for name in ("items", "additionalProperties"):
        if isinstance(schema.get(name), dict):
            schema[name] = _written_out(schema[name], parts)
    for pattern, part in schema.pop("patternProperties", {}).items():
        schema |= {"propertyNames": {"pattern": pattern}, "additionalProperties": part}
        schema["additionalProperties"] = _written_out(part, parts)
    if "const" in schema:
        schema["enum"] = [schema.pop("const")]
    if "properties" in schema:
        schema["properties"] = {
            name: _written_out(part, parts) for name, part in schema["properties"].items()
        }
    if "description" in schema:
        schema["description"] = " ".join(schema["description"].split())
    schema.pop("discriminator", None)
    return schema


def _kinds(schema: dict) -> list[str]:
    kind = schema.get("type", [])
    return kind if isinstance(kind, list) else [kind]


def _kind(name: str) -> str:
    return "type" if name in _TYPES else name


def _path(location: tuple, settings) -> tuple:
    """A place of pydantic's without the names of types in it: keys that are there, and the last."""
    path, value = [], settings
    for number, part in enumerate(location):
        within = isinstance(value, dict) and part in value
        within = within or (isinstance(value, list) and isinstance(part, int) and part < len(value))
        if within:
            path.append(part)
            value = value[part]
        elif number == len(location) - 1 and isinstance(value, dict) and part != "[key]":
            path.append(part)  # a key that is missing
    return tuple(path)


def _explained(keys, settings, path: tuple, kind: str, errors: list[dict]) -> Iterator[str]:
    # a value of a list is named by the list's key
    where = ".".join(part for part in path if isinstance(part, str))
    value = errors[0]["input"]
    first = errors[0]
    if kind == "missing":
        yield f"{where or 'the configuration'}: lacks {', '.join(e['loc'][-1] for e in errors)}"
    elif kind == "extra_forbidden":
        known = _known(keys, path[:-1])
        close = difflib.get_close_matches(str(path[-1]), known, n=1)
        meant = f"; did you mean {close[0]}?" if close else ""
        yield f"{where} = {short(value)}: unknown key{meant} (allowed: {', '.join(known)})"
    else:
        yield f"{where or 'the configuration'} = {short(value)}: {_allowed(first, path, errors)}"


_IN_WORDS = {
    ("effects",): "must be auto, or effects with true or false",
    ("numerics", "accuracy"): (
        "must be a number above 0 and below 1, or {of: mean, within: 0.05} (of: mean or interval)"
    ),
}
"""What keys may be whose types do not say it."""


def _allowed(error: dict, path: tuple, errors: list[dict]) -> str:
    kind, about = error["type"], error.get("ctx", {})
    if kind in _BOUNDS:
        name, word = _BOUNDS[kind]
        return f"must be {word} {about[name]:g}"
    if kind in _TYPES:
        if path in _IN_WORDS:
            return _IN_WORDS[path]
        said = f"must be of type {' or '.join(_TYPES[each['type']] for each in errors)}"
        return said + _number_hint(error["input"], said)
    if kind == "finite_number":
        return "must be a finite number"
    if kind == "literal_error":
        words = re.findall(r"'([^']*)'", about["expected"])
        close = difflib.get_close_matches(str(error["input"]), words, n=1)
        meant = f"; did you mean {close[0]}?" if close and isinstance(error["input"], str) else ""
        return f"must be one of {', '.join(words)}{meant}"
    if kind in ("too_short", "string_too_short"):
        return (
            f"needs at least {about['min_length']} values"
            if kind == "too_short"
            else ("must not be empty")
        )
    if kind == "too_long":
        return f"must have at most {about['max_length']} values"
    if kind == "string_pattern_mismatch":
        return f"must match {about['pattern']} (lower-case letters, digits and underscores)"
    return error["msg"]


def _number_hint(value: object, said: str) -> str:
    """1e-3 is a text to YAML, a number is 1.0e-3."""
    if isinstance(value, str) and ("number" in said or "integer" in said):
        with_point = re.fullmatch(r"([-+]?[0-9]+)([eE])([-+]?)([0-9]+)", value)
        if with_point:
            digits, e, sign, power = with_point.groups()
            if math.isinf(float(value)):
                return f"; {value} is too large for a number"
            return f"; YAML takes it for a text: write {digits}.0{e}{sign or '+'}{power}"
    return ""


def _known(keys, path: tuple) -> list[str]:
    """Keys that a model has at a path."""
    kind = keys
    for part in path:
        kind = _models(kind)
        if hasattr(kind, "model_fields"):
            kind = kind.model_fields[part].annotation
        elif typing.get_origin(kind) in (dict, list):
            kind = typing.get_args(kind)[-1]
    kind = _models(kind)
    return list(kind.model_fields)


def _models(kind):
    """The model, or mapping or list, among what a key may be."""
    while typing.get_origin(kind) in (typing.Annotated, typing.Union, types.UnionType):
        parts = typing.get_args(kind)
        inner = [parts[0]] if typing.get_origin(kind) is typing.Annotated else parts
        models = [
            each for each in inner
            if hasattr(each, "model_fields") or typing.get_origin(each) is not None
        ]  # fmt: skip
        kind = models[0]
    return kind


def short(value: object) -> str:
    """A value in a message, in one line and not too long."""
    text = repr(value)
    return text if len(text) <= 100 else f"{text[:97]}..."

"""JSON schema of the keys of a file, and problems of a file, one line each."""

import difflib
import functools
import math
import re
from collections.abc import Iterable, Iterator

import pydantic

_TYPES = {
    "int_type": "integer",
    "float_type": "number",
    "string_type": "string",
    "bool_type": "boolean",
    "list_type": "array",
    "tuple_type": "array",
    "dict_type": "object",
    "model_type": "object",
}
_ALLOWED = {
    "greater_than": "must be above {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be below {lt:g}",
    "less_than_equal": "must be at most {le:g}",
    "finite_number": "must be a finite number",
    "too_short": "needs at least {min_length} values",
    "too_long": "must have at most {max_length} values",
    "string_too_short": "must not be empty",
    "string_pattern_mismatch": (
        "must match {pattern} (lower-case letters, digits and underscores)"
    ),
}
_IN_WORDS = {
    ("effects",): "must be auto, or effects with true or false",
}
"""Allowed values of keys whose types do not state them."""


@functools.cache
def json_schema(keys: type[pydantic.BaseModel]) -> dict:
    """Return the JSON schema of a model of keys, without references."""
    whole = keys.model_json_schema()
    about = _written_out(whole, whole.pop("$defs", {}))
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | about


def _written_out(schema: dict, parts: dict) -> dict:
    """Return a schema with its references inserted, and null or missing values in one form."""
    if "$ref" in schema:
        schema = parts[schema["$ref"].rpartition("/")[2]] | schema
    schema = {k: v for k, v in schema.items() if k not in ("$ref", "title", "default")}
    options = schema.pop("anyOf", schema.pop("oneOf", []))
    for kind in (_written_out(option, parts) for option in options):
        names = [*_kinds(schema), *_kinds(kind)]
        schema = kind | schema | ({"type": names if len(names) > 1 else names[0]} if names else {})
        if "enum" in schema and "null" in names and None not in schema["enum"]:
            schema["enum"] = [*schema["enum"], None]
    for pattern, part in schema.pop("patternProperties", {}).items():
        schema |= {"propertyNames": {"pattern": pattern}, "additionalProperties": part}
    for name in ("items", "additionalProperties"):
        if isinstance(schema.get(name), dict):
            schema[name] = _written_out(schema[name], parts)
    if "const" in schema:
        schema["enum"] = [schema.pop("const")]
    if inner := schema.get("properties"):
        schema["properties"] = {name: _written_out(part, parts) for name, part in inner.items()}
    if "description" in schema:
        schema["description"] = " ".join(schema["description"].split())
    schema.pop("discriminator", None)
    return schema


def _kinds(schema: dict) -> list[str]:
    kind = schema.get("type", [])
    return kind if isinstance(kind, list) else [kind]


def problems(keys: type[pydantic.BaseModel], settings: dict) -> list[str]:
    """List the problems of settings with a model of keys, one line for each key."""
    try:
        keys.model_validate(settings)
    except pydantic.ValidationError as error:
        return explained(keys, settings, error)
    return []


def explained(
    keys: type[pydantic.BaseModel], settings: dict, error: pydantic.ValidationError
) -> list[str]:
    """List the problems of settings that a model of keys refused, one line for each key."""
    by_key: dict[tuple, list] = {}
    found = error.errors(include_url=False)
    lists = {problem["loc"][:-1] for problem in found}
    for problem in found:
        if problem["type"] == "too_short" and problem["loc"] in lists:
            continue  # wrong values are not counted
        path = _path(problem["loc"], settings)
        kind = "type" if problem["type"] in _TYPES else problem["type"]
        if kind == "missing":  # one line for all missing keys of a section
            path = path[:-1]
        by_key.setdefault((path, kind), []).append(problem)
    return [
        line
        for (path, kind), errors in by_key.items()
        for line in _explained(keys, path, kind, errors)
    ]


def _path(location: tuple, settings) -> tuple:
    """Return the existing keys of a pydantic location, and the last one, without names of types."""
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


def _explained(keys, path: tuple, kind: str, errors: list[dict]) -> Iterator[str]:
    # a value of a list is named by the list's key
    where = ".".join(part for part in path if isinstance(part, str))
    first, named = errors[0], where or "the configuration"
    if kind == "missing":
        yield f"{named}: lacks {', '.join(e['loc'][-1] for e in errors)}"
    elif kind == "extra_forbidden":
        known = _known(keys, path[:-1])
        allowed = f"unknown key{did_you_mean(path[-1], known)} (allowed: {', '.join(known)})"
        yield f"{where} = {short(first['input'])}: {allowed}"
    elif kind == "value_error" and not path:
        yield from str(first["ctx"]["error"]).splitlines()
    else:
        yield f"{named} = {short(first['input'])}: {_allowed(first, path, errors)}"


def _allowed(error: dict, path: tuple, errors: list[dict]) -> str:
    kind, about, value = error["type"], error.get("ctx", {}), error["input"]
    if kind in _ALLOWED:
        return _ALLOWED[kind].format(**about)
    if kind in _TYPES:
        allowed = " or ".join(_TYPES[each["type"]] for each in errors)
        return _IN_WORDS.get(path) or f"must be of type {allowed}{_number_hint(value, allowed)}"
    if kind == "literal_error":
        words = re.findall(r"'([^']*)'", about["expected"])
        return f"must be one of {', '.join(words)}{did_you_mean(value, words)}"
    if kind == "value_error":  # of a library's check: name = value: what is allowed
        return str(about["error"]).rpartition(": ")[2]
    return error["msg"]


def _number_hint(value: object, allowed: str) -> str:
    """Explain a text that looks like a number: 1e-3 is a text to YAML, 1.0e-3 is a number."""
    number = isinstance(value, str) and ("number" in allowed or "integer" in allowed)
    match = number and re.fullmatch(r"([-+]?[0-9]+)([eE])([-+]?)([0-9]+)", str(value))
    if not match:
        return ""
    if math.isinf(float(str(value))):
        return f"; {value} is too large for a number"
    digits, e, sign, power = match.groups()
    return f"; YAML reads it as text: write {digits}.0{e}{sign or '+'}{power}"


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Return the addition to a message that names the known word nearest to an unknown one."""
    close = difflib.get_close_matches(word, known, n=1) if isinstance(word, str) else ()
    return f"; did you mean {close[0]}?" if close else ""


def _known(keys: type[pydantic.BaseModel], path: tuple) -> list[str]:
    """Return the keys that a model has at a path."""
    schema = json_schema(keys)
    for part in path:
        within = "items" if isinstance(part, int) else "additionalProperties"
        schema = schema.get("properties", {}).get(part) or schema[within]
    return list(schema["properties"])


def short(value: object) -> str:
    """Format a value for a message, in one line of limited length."""
    text = repr(value)
    return text if len(text) <= 100 else f"{text[:97]}..."

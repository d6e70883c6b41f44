"""JSON schema of the keys of a file, and problems of a file, one line each."""

import difflib
import functools
import math
import re
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
    "tuple_type": "array",
    "dict_type": "object",
    "model_type": "object",
}


@functools.cache
def json_schema(keys: type[pydantic.BaseModel]) -> dict:
    """Return the JSON schema of a model of keys, without references."""
    whole = keys.model_json_schema()
    about = _written_out(whole, whole.pop("$defs", {}))
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | about


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
        path, kind = _path(problem["loc"], settings), _kind(problem["type"])
        if kind == "missing":  # one line for all missing keys of a section
            path = path[:-1]
        by_key.setdefault((path, kind), []).append(problem)
    return [
        line
        for (path, kind), errors in by_key.items()
        for line in _explained(keys, settings, path, kind, errors)
    ]


def _written_out(schema: dict, parts: dict) -> dict:
    """Return a schema with its references inserted, and null or missing values in one form."""
    if "$ref" in schema:
        siblings = {key: value for key, value in schema.items() if key != "$ref"}
        return _written_out(parts[schema["$ref"].rpartition("/")[2]] | siblings, parts)
    schema = {key: value for key, value in schema.items() if key not in ("title", "default")}
    options = schema.pop("anyOf", schema.pop("oneOf", []))
    kinds = [_written_out(option, parts) for option in options]
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
    """Return the path of a pydantic location, without names of types.

    It consists of the existing keys, and the last one.
    """
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
    elif kind == "value_error" and not path:
        yield from str(first["ctx"]["error"]).splitlines()
    else:
        yield f"{where or 'the configuration'} = {short(value)}: {_allowed(first, path, errors)}"


_IN_WORDS = {
    ("effects",): "must be auto, or effects with true or false",
    ("numerics", "accuracy"): (
        "must be a number above 0 and below 1, or {of: mean, within: 0.05} (of: mean or interval)"
    ),
}
"""Allowed values of keys whose types do not state them."""


def _allowed(error: dict, path: tuple, errors: list[dict]) -> str:
    kind, about = error["type"], error.get("ctx", {})
    if kind in _BOUNDS:
        name, word = _BOUNDS[kind]
        return f"must be {word} {about[name]:g}"
    if kind in _TYPES:
        if path in _IN_WORDS:
            return _IN_WORDS[path]
        allowed = f"must be of type {' or '.join(_TYPES[each['type']] for each in errors)}"
        return allowed + _number_hint(error["input"], allowed)
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
    if kind == "value_error":  # of a library's check: name = value: what is allowed
        return str(about["error"]).rpartition(": ")[2]
    return error["msg"]


def _number_hint(value: object, allowed: str) -> str:
    """Explain a text that looks like a number: 1e-3 is a text to YAML, 1.0e-3 is a number."""
    if isinstance(value, str) and ("number" in allowed or "integer" in allowed):
        with_point = re.fullmatch(r"([-+]?[0-9]+)([eE])([-+]?)([0-9]+)", value)
        if with_point:
            digits, e, sign, power = with_point.groups()
            if math.isinf(float(value)):
                return f"; {value} is too large for a number"
            return f"; YAML reads it as text: write {digits}.0{e}{sign or '+'}{power}"
    return ""


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

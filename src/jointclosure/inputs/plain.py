"""Conversion of typed settings to plain data for rules and files, and back."""

import types
import typing


def to_plain(value):
    """Convert named tuples to mappings and tuples to lists, at every level."""
    if hasattr(value, "_asdict"):
        return {name: to_plain(part) for name, part in value._asdict().items()}
    if isinstance(value, dict):
        return {name: to_plain(part) for name, part in value.items()}
    if isinstance(value, tuple | list):
        return [to_plain(part) for part in value]
    return value


def from_plain(kind, value):
    """Convert plain data of `to_plain` back to a type: a named tuple, or a type of its fields.

    A NamedTuple, ``tuple[X, ...]``, ``list[X]``, ``dict[str, X]``, or one of these or None; values
    of other types are not converted. `TypeError` if a field of a named tuple is missing or unknown.
    """
    if isinstance(kind, types.UnionType):
        kinds = [part for part in typing.get_args(kind) if part is not types.NoneType]
        return None if value is None else from_plain(kinds[0], value)
    if hasattr(kind, "_fields"):
        hints = typing.get_type_hints(kind)
        fields = {name: from_plain(hints.get(name), part) for name, part in value.items()}
        fields = kind._field_defaults | fields
        if fields.keys() != set(kind._fields):
            raise TypeError(f"{kind.__name__}: fields {sorted(fields)}, not {kind._fields}")
        return kind._make(fields[name] for name in kind._fields)  # checked before it was plain
    outer, inner = typing.get_origin(kind), typing.get_args(kind)
    if outer is dict:
        return {name: from_plain(inner[1], part) for name, part in value.items()}
    if outer in (tuple, list):
        return outer(from_plain(inner[0], part) for part in value)
    return value

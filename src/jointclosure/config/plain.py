"""Typed settings as plain data, for parameters of rules and attributes of files, and back."""

import types
import typing


def to_plain(value):
    """Named tuples as mappings and tuples as lists, at every level; all else as it is."""
    if hasattr(value, "_asdict"):
        return {name: to_plain(part) for name, part in value._asdict().items()}
    if isinstance(value, dict):
        return {name: to_plain(part) for name, part in value.items()}
    if isinstance(value, tuple | list):
        return [to_plain(part) for part in value]
    return value


def from_plain(kind, value):
    """What `to_plain` made plain, as its kind: a named tuple, or a type of their fields.

    Parameters
    ----------
    kind : type
        A NamedTuple, ``tuple[X, ...]``, ``list[X]``, ``dict[str, X]``, or one of
        these or None; values of other types are taken as they are.
    value : object

    Raises
    ------
    TypeError
        A field that the named tuple does not have, or lacks.
    """
    if isinstance(kind, types.UnionType):
        kinds = [each for each in typing.get_args(kind) if each is not types.NoneType]
        return None if value is None else from_plain(kinds[0], value)
    if hasattr(kind, "_fields"):
        hints = typing.get_type_hints(kind)
        return kind(**{name: from_plain(hints.get(name), part) for name, part in value.items()})
    outer, inner = typing.get_origin(kind), typing.get_args(kind)
    if outer is dict:
        return {name: from_plain(inner[1], part) for name, part in value.items()}
    if outer in (tuple, list):
        return outer(from_plain(inner[0], part) for part in value)
    return value

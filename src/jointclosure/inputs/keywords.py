"""Functions that take the fields of a named tuple as keywords: signature, check, documentation."""

import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from jointclosure.inputs import did_you_mean

Function = TypeVar("Function", bound=Callable[..., Any])


def takes(fields_of: Callable[..., Any], **defaults: Any) -> Callable[[Function], Function]:
    """Return a decorator that lists the fields of a named tuple in the signature of a function.

    It sets ``__signature__``, which `help` and editors show: the function's ``**keywords`` are
    replaced by keyword-only arguments, one for each parameter of ``fields_of``. Calls do not
    change: the function still receives ``**keywords``, and must check them (`check_keywords`) and
    fill in defaults itself. ``defaults`` are the shown defaults, by name, of fields for which the
    function uses another default than the named tuple.
    """

    def decorate(function: Function) -> Function:
        """Set the signature of a function, in place, and return the function."""
        signature = inspect.signature(function)
        shown = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        fields = inspect.signature(fields_of).parameters.values()
        keywords = [
            field.replace(kind=field.KEYWORD_ONLY, default=defaults.get(field.name, field.default))
            for field in fields
        ]
        function.__signature__ = signature.replace(parameters=shown + keywords)  # type: ignore[attr-defined]
        return function

    return decorate


def check_keywords(
    function: str, stated: Iterable[str], allowed: Iterable[str], required: Iterable[str] = (),
    inside: Mapping[str, Iterable[str]] = {},
) -> None:  # fmt: skip
    """Raise `TypeError`, as Python does, for an unknown or a missing keyword of a function.

    ``function`` is its name in the message, and ``stated`` are the names of the given keywords.
    For an unknown one the message suggests a similar one among those ``allowed``. ``inside`` are
    the names of the fields of those keywords that are named tuples; for one of them the message
    names the keyword to which the field belongs.
    """
    stated = list(stated)
    allowed = list(allowed)
    for name in stated:
        if name in allowed:
            continue
        meant = did_you_mean(name, allowed, 0.7)
        for keyword, fields in inside.items():
            if name in fields:
                meant = f"; it is a field of jointclosure.{keyword.capitalize()}, for {keyword}"
        raise TypeError(f"{function}() got an unexpected keyword argument {name!r}{meant}")
    if missing := [name for name in required if name not in stated]:
        raise TypeError(f"{function}() needs the keyword arguments {', '.join(missing)}")


def documented(function: Callable[..., Any]) -> dict[str, str]:
    """Return the description of each parameter of a function, or attribute of a type, by name.

    It is read from the numpy sections Parameters or Attributes of the docstring, in one line, and
    without units in brackets and marks of code. Further sections with such entries, as Raises, are
    included. Without docstrings all descriptions are empty.
    """
    _, *sections = re.split(r"(?:Parameters|Attributes)\n-+\n", inspect.getdoc(function) or "")
    if not sections:  # as python -OO leaves docstrings out
        return dict.fromkeys(inspect.signature(function).parameters, "")
    text = sections[0]
    entries = re.findall(r"^(\S+(?:, \S+)*)(?: : .*)?\n((?:    .*\n?)+)", text, re.MULTILINE)
    texts: dict[str, str] = {}
    for names, about in entries:
        plain = re.sub(r" \[\w+\]| \(`jointc[^)]*\)|`", "", " ".join(about.split()))
        texts |= dict.fromkeys(names.split(", "), plain)
    return texts

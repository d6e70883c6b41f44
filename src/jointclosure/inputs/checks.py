"""Checks of arguments: numbers, lengths, arrays and words."""

import difflib
import math
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike

LENGTHS = (1e-15, 1e15)
"""Smallest and largest allowed grid spacing [m]; the largest is also the largest allowed height."""

SIZES = (1e-100, 1e100)
"""Smallest and largest allowed size of numbers whose squares and products are computed."""


class InputError(ValueError):
    """Error for a value that is not allowed; its message names the value."""


@contextmanager
def naming(where: str) -> Iterator[None]:
    """Put ``where`` in front of the message of any `InputError` that is raised inside."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def real_array(name: str, values: ArrayLike) -> np.ndarray:
    """Convert real, finite, unmasked numbers of any shape to a new float64 array.

    Raise `InputError` for anything else; ``name`` is that of the argument in the message.
    """
    if np.ma.is_masked(values):
        raise InputError(f"{name}: has masked values; fill or crop them first")
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: is not an array of numbers ({error})") from None
    if array.dtype.kind not in "fiu":
        raise InputError(
            f"{name}: values of type {array.dtype}, must be real numbers (floats or integers)"
        )
    with np.errstate(over="ignore"):  # a long double may not fit, and is then not finite
        numbers = np.array(array, dtype=np.float64, order="C")
    bad = np.argwhere(~np.isfinite(numbers))
    if bad.size:
        where = ", ".join(str(index) for index in bad[0])
        axes = " (y, x) =" if numbers.ndim == 2 else ""
        raise InputError(f"{name}: {len(bad)} values are not finite, the first at{axes} ({where})")
    return numbers


def check_count(name: str, value: int, least: int = 1, most: int | None = None) -> None:
    """Raise `InputError` unless a value is a whole number from ``least`` to ``most``, if stated."""
    check_number(name, value, whole=True)
    if value < least:
        raise InputError(f"{name} = {value!r}: must be at least {least}")
    if most is not None and value > most:
        shown = repr(value) if value < 1e18 else "a number of more than 18 digits"
        raise InputError(f"{name} = {shown}: must be at most {most}")


def check_sizes(name: str, values: np.ndarray) -> None:
    """Raise `InputError` if the largest magnitude of some numbers is outside of `SIZES`.

    All of them may be 0.
    """
    largest = float(np.abs(values).max(initial=0.0))
    if largest and not SIZES[0] <= largest <= SIZES[1]:
        raise InputError(
            f"{name}: the largest is {largest:.3g}, and must be from {SIZES[0]:g} to "
            f"{SIZES[1]:g}, as squares must fit in double precision"
        )


def check_below(name: str, value: float, limit: float, about: str = "") -> None:
    """Raise `InputError` unless a value is a number between 0 and a ``limit``, both excluded.

    ``about`` is appended to the message.
    """
    check_number(name, value)
    if not 0.0 < value < limit:
        raise InputError(f"{name} = {value!r}: must lie between 0 and {limit:g}{about}")


def check_number(name: str, value: object, whole: bool = False) -> None:
    """Raise `InputError` unless a value is a real number, or with ``whole`` an integer.

    Booleans are refused, and integers that do not fit in double precision, unless ``whole``. NaN
    and infinity are accepted.
    """
    kinds = (int, np.integer) if whole else (int, float, np.integer, np.floating)
    if isinstance(value, bool | np.bool_) or not isinstance(value, kinds):
        raise InputError(f"{name} = {value!r}: must be a {'whole ' if whole else ''}number")
    if not whole and isinstance(value, int) and abs(value) > sys.float_info.max:
        raise InputError(f"{name} = {value!r}: must be a number that fits in double precision")


def check_length(name: str, value: float) -> None:
    """Raise `InputError` unless a length [m] is positive and within `LENGTHS`."""
    check_positive(name, value, "m")
    if not LENGTHS[0] <= value <= LENGTHS[1]:
        raise InputError(
            f"{name} = {value!r} m: must lie in [{LENGTHS[0]:g}, {LENGTHS[1]:g}] m; beyond, "
            "the twelfth power of a length in the curvature does not fit in double precision"
        )


def check_positive(name: str, value: float, unit: str, may_be_infinite: bool = False) -> None:
    """Raise `InputError` unless a value is a positive number, and finite unless it may be infinite.

    ``unit`` is the unit of the value in the message.
    """
    check_number(name, value)
    if not value > 0.0 or (math.isinf(value) and not may_be_infinite):
        raise InputError(f"{name} = {value!r} {unit}: must be positive and finite")


def check_one_of(name: str, value: str, allowed: tuple[str, ...]) -> None:
    """Raise `InputError` unless a value is one of the allowed words."""
    if not isinstance(value, str) or value not in allowed:
        known = ", ".join(allowed)
        raise InputError(
            f"{name} = {value!r}: must be one of {known}{did_you_mean(value, allowed)}"
        )


def did_you_mean(word: object, known: Iterable[str], least: float = 0.6) -> str:
    """Return "; did you mean ...?" with the known word that is nearest to an unknown one.

    It is appended to a message. It is empty if no known word has at least the similarity ``least``,
    from 0 to 1.
    """
    close = difflib.get_close_matches(word, known, 1, least) if isinstance(word, str) else ()
    return f"; did you mean {close[0]}?" if close else ""

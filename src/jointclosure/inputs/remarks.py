"""Remarks on input and results. Warnings among them have a type of their own, `Caution`."""

from collections.abc import Iterable


class Caution(str):
    """Remark that is a warning, which reports repeat below the result that it concerns."""

    __slots__ = ()


def caution(text: str, about: str = "") -> Caution:
    """Return a warning, preceded by its subject ``about``."""
    return Caution(f"{about}Warning: {text}")


def cautions(remarks: Iterable[str]) -> list[Caution]:
    """Return the warnings among remarks."""
    return [remark for remark in remarks if isinstance(remark, Caution)]

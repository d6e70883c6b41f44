"""Remarks on input and results. Warnings among them have a type of their own, `Caution`."""

from collections.abc import Iterable


class Caution(str):
    """Remark that is a warning, which reports repeat below the result that it concerns."""

    __slots__ = ()


def caution(text: str, about: str = "") -> Caution:
    """Return a warning, preceded by its subject ``about``."""
    return Caution(f"{about}Warning: {text}")


def noted(remark: str) -> str:
    """Return a remark with the word Note before it, unless it has the word Warning."""
    return remark if isinstance(remark, Caution) else f"Note: {remark}"


def without_word(remark: str) -> str:
    """Return a remark without the word Warning, to be put where this is said already."""
    return remark.replace("Warning: ", "", 1) if isinstance(remark, Caution) else remark


def cautions(remarks: Iterable[str]) -> list[Caution]:
    """Return the warnings among remarks."""
    return [remark for remark in remarks if isinstance(remark, Caution)]

"""Remarks on input and results: texts, among which warnings have the type `Caution`."""

from collections.abc import Iterable


class Caution(str):
    """Remark that is a warning, which reports repeat below the result that it concerns."""

    __slots__ = ()


def caution(text: str, about: str = "") -> Caution:
    """Return a remark that is a warning: ``about``, the word Warning, and a text."""
    return Caution(f"{about}Warning: {text}")


def noted(remark: str) -> str:
    """Return a remark with the word Note before it; a warning as it is."""
    return remark if isinstance(remark, Caution) else f"Note: {remark}"


def without_word(remark: str) -> str:
    """Return a warning without the word Warning, for a place that says this already.

    Other remarks are returned as they are.
    """
    return remark.replace("Warning: ", "", 1) if isinstance(remark, Caution) else remark


def cautions(remarks: Iterable[str]) -> list[Caution]:
    """Return the warnings among remarks."""
    return [remark for remark in remarks if isinstance(remark, Caution)]

"""Remarks on what was read and found, and their levels: what warns is known by its type."""

from collections.abc import Iterable


class Caution(str):
    """A remark that warns. It reads as any other, and stands again below what it is about."""

    __slots__ = ()


def caution(text: str, about: str = "") -> Caution:
    """A warning, behind what it is about."""
    return Caution(f"{about}Warning: {text}")


def prefixed(prefix: str, remark: str) -> str:
    """A remark of the same level behind a prefix."""
    return type(remark)(prefix + remark)


def cautions(remarks: Iterable[str]) -> list[Caution]:
    """Remarks that warn."""
    return [remark for remark in remarks if isinstance(remark, Caution)]

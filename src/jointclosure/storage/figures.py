"""Figures as files: whole or absent, whatever happens meanwhile."""

from pathlib import Path
from typing import TYPE_CHECKING

from jointclosure.files import atomically

if TYPE_CHECKING:  # a job that draws nothing does not load it
    from matplotlib.figure import Figure


def save_figure(figure: "Figure", path: str | Path) -> None:
    """Write a figure in the format of its path, without the time of day in it."""
    metadata = {"CreationDate": None} if Path(path).suffix == ".pdf" else None
    atomically(path, lambda temporary: figure.savefig(temporary, metadata=metadata))

"""Figures as files: whole or absent, whatever happens meanwhile."""

from pathlib import Path

from matplotlib.figure import Figure

from jointclosure.files import atomically


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write a figure in the format of its path, without the time of day in it."""
    metadata = {"CreationDate": None} if Path(path).suffix == ".pdf" else None
    atomically(path, lambda temporary: figure.savefig(temporary, metadata=metadata))

"""Figures, and meshes for other programs, written completely or not at all."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from jointclosure.inputs.extras import needs
from jointclosure.storage.files import atomically

if TYPE_CHECKING:  # not loaded by jobs that draw nothing
    from matplotlib.animation import FuncAnimation
    from matplotlib.figure import Figure


def save_figure(figure: "Figure", path: str | Path) -> None:
    """Write a figure in the format of its path, without a time stamp."""
    metadata = {"CreationDate": None} if Path(path).suffix == ".pdf" else None
    atomically(path, lambda temporary: figure.savefig(temporary, metadata=metadata))


def save_animation(animation: "FuncAnimation", path: str | Path) -> None:
    """Write an animation as a GIF."""
    atomically(path, lambda temporary: animation.save(str(temporary), writer="pillow", dpi=100))


def write_vtu(
    points: np.ndarray, triangles: np.ndarray, cell_fields: dict[str, np.ndarray], path: str | Path
) -> None:
    """Write a surface of points (n, 3) [m] and triangles (m, 3), with fields (m,) of these."""
    with needs("exchange", "VTU"):
        import meshio
    mesh = meshio.Mesh(
        points, [("triangle", triangles)], cell_data={k: [v] for k, v in cell_fields.items()}
    )
    atomically(path, lambda temporary: mesh.write(temporary, file_format="vtu"))

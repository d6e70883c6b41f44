"""Meshes for other programs, by meshio: VTU."""

from pathlib import Path

import numpy as np

from jointclosure.inputs.extras import needs
from jointclosure.storage.files import atomically


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

"""Meshes for other programs, by meshio: VTU."""

from pathlib import Path

import numpy as np

from jointclosure.inputs.extras import needs
from jointclosure.storage.files import atomically


def write_vtu(
    points: np.ndarray, triangles: np.ndarray, cell_fields: dict[str, np.ndarray], path: str | Path
) -> None:
    """Write a triangulated surface, completely or not at all.

    Parameters
    ----------
    points : array (n, 3)
        [m].
    triangles : array (m, 3)
        Indices of their points.
    cell_fields : dict
        Values (m,) of each triangle by name.
    path : path
    """
    with needs("exchange", "VTU"):
        import meshio
    mesh = meshio.Mesh(
        points, [("triangle", triangles)], cell_data={k: [v] for k, v in cell_fields.items()}
    )
    atomically(path, lambda temporary: mesh.write(temporary, file_format="vtu"))

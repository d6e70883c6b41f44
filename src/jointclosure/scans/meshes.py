"""Triangulated scans: STL, of which the vertices are the points of the wall."""

from pathlib import Path

import numpy as np

from jointclosure.extras import needs
from jointclosure.inputs import InputError
from jointclosure.scans.contents import Contents
from jointclosure.scans.points import cleaned


def read_stl(path: Path, variable: str | None) -> Contents:
    """Vertices of an STL file, binary or text; the format knows no units."""
    if variable is not None:
        raise InputError(f"variable = {variable!r}: an STL file has none")
    with needs("walls", "STL"):
        import trimesh
    try:
        with path.open("rb") as file:
            mesh = trimesh.load_mesh(file, file_type="stl")
        points = np.array(mesh.vertices, dtype=float)
    except Exception as error:  # of a damaged file the library raises what its bytes lead to
        raise InputError(f"cannot be read as STL ({error})") from None
    if len(points) < 4:
        raise InputError(f"an STL file of {len(points)} vertices: too few for a wall")
    points, remarks = cleaned(points)
    return Contents(points=points, remarks=remarks)

"""Triangulated scans: STL files, whose vertices are the points of the wall."""

from pathlib import Path

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.scans.contents import Contents, check_no_variable, reading_as
from jointclosure.scans.points import contents_of

LARGEST_COVER = 1.05
"""Largest area of the triangles in the plan over that of the points' convex hull; a solid has 2."""


def read_stl(path: Path, variable: str | None) -> Contents:
    """Read the vertices of an STL file, binary or text; the format has no units."""
    check_no_variable(variable)
    with needs("walls", "STL"):
        import trimesh
    with reading_as("STL"), path.open("rb") as file:
        mesh = trimesh.load_mesh(file, file_type="stl")
        points = np.array(mesh.vertices, dtype=float)
    if len(points) < 4:
        raise InputError(f"has {len(points)} vertices: too few for a wall")
    _check_single_sheet(points, np.asarray(mesh.faces))
    return contents_of(points)


def _check_single_sheet(points: np.ndarray, faces: np.ndarray) -> None:
    """Raise `InputError` if triangles (n, 3) of points overlap in the plan.

    The sum of their areas in the plan is then larger than the area of the points' convex hull.
    """
    one, other = (points[faces[:, corner], :2] - points[faces[:, 0], :2] for corner in (1, 2))
    area = 0.5 * float(np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]).sum())
    try:
        hull = scipy.spatial.ConvexHull(points[:, :2]).volume
    except (scipy.spatial.QhullError, ValueError):
        return  # they lie on one line, which `point_distance` reports
    if area > LARGEST_COVER * hull:
        raise InputError(
            f"the surface overlaps itself: its triangles cover {area / hull:.3g} times the plan "
            "of its points; a solid or both walls in one file must be cut to one wall"
        )

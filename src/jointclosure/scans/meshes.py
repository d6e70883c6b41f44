"""Triangulated scans: STL, PLY and OBJ files, whose vertices are the points of the wall."""

from pathlib import Path

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.scans.contents import Contents, check_no_variable, reading_as
from jointclosure.scans.points import contents_of

LARGEST_COVER = 1.05
"""Largest area of the triangles in the plan over that of the points' convex hull; a solid has 2."""


def read_mesh(path: Path, variable: str | None) -> Contents:
    """Read the vertices of all meshes and point clouds of a file; the formats have no units."""
    check_no_variable(variable)
    form = path.suffix.lower().removeprefix(".")
    with needs("walls", form.upper()):
        import trimesh
    points, faces, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=int)], 0
    with reading_as(form.upper()), path.open("rb") as file:
        for part in trimesh.load_scene(file, file_type=form).geometry.values():
            points.append(np.array(part.vertices, dtype=float))
            faces.append(count + np.asarray(getattr(part, "faces", faces[0])))
            count += len(points[-1])
    if count < 4:
        raise InputError(f"has {count} vertices: too few for a wall")
    vertices = np.concatenate(points)
    _check_single_sheet(vertices, np.concatenate(faces))
    return contents_of(vertices)


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

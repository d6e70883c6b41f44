"""Triangulated scans: STL, PLY and OBJ files, whose vertices are the points of the wall."""

import struct
from pathlib import Path

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.scans.contents import Contents, check_no_variable, reading_as
from jointclosure.scans.points import contents_of
from jointclosure.scans.text import is_binary

LARGEST_COVER = 1.05
"""Largest area of the triangles in the plan over that of the points' convex hull; a solid has 2."""


def read_mesh(path: Path, variable: str | None) -> Contents:
    """Read the vertices of all meshes and point clouds of a file; the formats have no units."""
    check_no_variable(variable)
    form = path.suffix.lower().removeprefix(".")
    with needs("walls", form.upper()):
        import trimesh
    points, faces, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=int)], 0
    if form == "obj":
        _check_obj(path)
    elif form == "stl":
        _check_stl(path)
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


def binary_stl_size(start: bytes) -> int | None:
    """Return the size [bytes] that the head of a binary STL file declares; None for a shorter one.

    84 bytes of a head, at whose end the number of triangles is, and 50 for each triangle.
    """
    return 84 + 50 * struct.unpack_from("<I", start, 80)[0] if len(start) >= 84 else None


def _check_stl(path: Path) -> None:
    """Raise `InputError` if a binary STL file is shorter than its head declares."""
    with path.open("rb") as file:
        start = file.read(1024)
    declared, size = binary_stl_size(start), path.stat().st_size
    if start.lstrip().lower().startswith(b"solid") and not is_binary(start):
        return  # its text form
    if declared is None:
        raise InputError(
            f"contains {size} bytes, less than the head of 84: is the file incomplete?"
        )
    if size < declared:
        raise InputError(
            f"declares {(declared - 84) // 50} triangles, {declared} bytes, and contains {size}: "
            "is the file incomplete?"
        )


def _check_obj(path: Path) -> None:
    """Raise `InputError` if an OBJ file has no vertices, or a line that no mesh has."""
    vertices, largest = 0, (0, 0)  # number of a vertex in a face, and its line
    with path.open(encoding="latin-1") as file:
        for number, line in enumerate(file, start=1):
            words = line.split()
            if line.startswith("v "):
                vertices += 1
                if not _numbers(words[1:4]):
                    raise InputError(
                        f"line {number}, {line.strip()[:60]!r}: must be v and the numbers x, y, z"
                    )
            elif line.startswith("f "):
                corners = [word.split("/")[0] for word in words[1:]]
                if len(corners) < 3 or not all(_is_whole(word) for word in corners):
                    raise InputError(
                        f"line {number}, {line.strip()[:60]!r}: must be f and the numbers of three "
                        "or more vertices"
                    )
                largest = max(largest, (max(map(int, corners)), number))
    if not vertices:
        raise InputError("has no vertices (lines 'v x y z')")
    if largest[0] > vertices:
        raise InputError(
            f"line {largest[1]}: a face has vertex {largest[0]}, but there are {vertices} vertices"
        )


def _numbers(words: list[str]) -> bool:
    """Return whether these are three numbers."""
    try:
        return len([float(word) for word in words]) == 3
    except ValueError:
        return False


def _is_whole(word: str) -> bool:
    return word.removeprefix("-").isdecimal()


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

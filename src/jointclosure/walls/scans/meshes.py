"""Triangulated scans: STL, PLY and OBJ files, whose vertices are the points of the wall."""

import itertools
import re
import struct
from pathlib import Path

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.inputs.remarks import caution
from jointclosure.walls.scans.contents import Contents
from jointclosure.walls.scans.points import contents_of
from jointclosure.walls.scans.text import is_binary

LARGEST_COVER = 1.05
"""Largest area of the triangles in the plan over that of the points' convex hull; a solid has 2."""
_HEAD = 65_536
"""Number of bytes in which the head of a PLY file ends."""
_DECLARED = re.compile(r"#\s*(?:vertices\s*:?\s*(\d+)|(\d+)\s+vertices)\s*$", re.IGNORECASE)
"""Comment of an OBJ file that states the number of vertices."""
_LINES = {
    "v": "the numbers x, y, z, as many numbers as in the other vertices",
    "f": "the numbers of three or more vertices",
}
"""Lines of an OBJ file that are read, by their first word."""


def read_mesh(path: Path) -> Contents:
    """Read the vertices of all meshes and point clouds of a file; the formats have no units."""
    form = path.suffix.lower().removeprefix(".")
    vertices, faces, declared = _obj(path) if form == "obj" else _by_trimesh(path, form)
    if declared > len(vertices):
        raise InputError(
            f"declares {declared} vertices, and contains {len(vertices)}: is the file incomplete?"
        )
    if faces.size and faces.max() >= len(vertices):
        raise InputError(
            f"a face has vertex {faces.max() + 1}, but there are {len(vertices)} vertices"
        )
    if len(vertices) < 4:
        raise InputError(f"has {len(vertices)} vertices: too few for a wall")
    _check_single_sheet(vertices, faces)
    contents = contents_of(vertices)
    loose = len(vertices) - len(np.unique(faces))
    if not loose or not len(faces):
        return contents
    used = f"{loose} of {len(vertices)} vertices belong to no face; they were used like the others"
    return contents._replace(remarks=(*contents.remarks, caution(used)))


def _by_trimesh(path: Path, form: str) -> tuple[np.ndarray, np.ndarray, int]:
    """Return vertices (n, 3), merged in STL only, triangles (m, 3), and the declared number."""
    with needs("walls", form.upper()):
        import trimesh
    if form == "stl":
        _check_stl(path)
    points, faces, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=int)], 0
    with path.open("rb") as file:
        meshes = trimesh.load_scene(file, file_type=form, process=form == "stl").geometry
        for part in meshes.values():
            points.append(np.array(part.vertices, dtype=float))
            faces.append(count + np.reshape(getattr(part, "faces", faces[0]), (-1, 3)))
            count += len(points[-1])
    with path.open("rb") as file:
        head = file.read(_HEAD).partition(b"end_header")[0]
    stated = re.search(rb"element\s+vertex\s+(\d+)", head) if form == "ply" else None
    return np.concatenate(points), np.concatenate(faces), int(stated[1]) if stated else 0


def binary_stl_size(start: bytes) -> int | None:
    """Return the bytes that a binary STL declares: a head of 84, 50 a triangle; None if shorter."""
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


def _obj(path: Path) -> tuple[np.ndarray, np.ndarray, int]:
    """Return vertices (n, 3), triangles (m, 3), and the number of vertices in comments."""
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    declared = 0
    with path.open(encoding="latin-1") as file:
        for number, line in enumerate(file, start=1):
            kind, *words = line.split() or [""]
            valid = True
            try:
                if kind == "v":
                    vertices.append([float(word) for word in words])
                    valid = len(vertices[-1]) == len(vertices[0]) >= 3
                elif kind == "f":
                    corners = [int(word.split("/")[0]) for word in words]
                    # negative numbers count back from the last vertex
                    corners = [n if n > 0 else len(vertices) + 1 + n for n in corners]
                    valid = len(corners) >= 3 and min(corners) >= 1
                    faces += [[corners[0], *pair] for pair in itertools.pairwise(corners[1:])]
                elif stated := _DECLARED.match(line):
                    declared += int(stated[1] or stated[2])
            except ValueError:
                valid = False
            if not valid:
                raise InputError(
                    f"line {number}, {line.strip()[:60]!r}: must be {kind} and {_LINES[kind]}"
                )
    if not vertices:
        raise InputError("has no vertices (lines 'v x y z')")
    return np.array(vertices)[:, :3], np.array(faces, dtype=int).reshape(-1, 3) - 1, declared


def _check_single_sheet(points: np.ndarray, faces: np.ndarray) -> None:
    """Raise `InputError` if triangles (n, 3) cover more of the plan than their points' hull."""
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

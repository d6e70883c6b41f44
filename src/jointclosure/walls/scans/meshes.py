"""Mesh files of scanned walls (STL, PLY and OBJ), which are read as points: their vertices."""

import itertools
import re
from pathlib import Path

import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.inputs.remarks import caution
from jointclosure.walls.scans.contents import Contents
from jointclosure.walls.scans.headers import placed, read_header
from jointclosure.walls.scans.sheet import TWO_WALLS, check_sheet

_DECLARED = re.compile(r"#\s*(?:vertices\s*:?\s*(\d+)|(\d+)\s+vertices)\s*$", re.IGNORECASE)
"""Comment of an OBJ file that states the number of vertices."""


def read_mesh(path: Path, variable: str | None = None) -> Contents:
    """Read the vertices of all meshes and point clouds of a file, with the units in its comments.

    ``variable`` is the order of coordinates that are x, y and z, such as "3,1,2" or "z,x,y". Raise
    `InputError` if the file is incomplete, or if the vertices are not one wall seen along z.
    """
    form = path.suffix.lower().removeprefix(".")
    vertices, faces, declared = _read_obj(path) if form == "obj" else _read_by_trimesh(path, form)
    header = read_header(_comments(path, form))
    vertices = vertices[:, _columns_of_x_y_z(variable)]
    count = len(vertices)
    if declared > count:
        contained = f"declares {declared} vertices, and contains {count}"
        raise InputError(f"{contained}: is the file incomplete?")
    if faces.size and not 0 <= faces.min() <= faces.max() < count:
        wrong = f"faces have vertices {faces.min() + 1} to {faces.max() + 1}"
        raise InputError(f"{wrong}, but there are {count} vertices")
    if count < 4:
        raise InputError(f"has {count} vertices, too few for a wall: is the file incomplete?")
    check_sheet(vertices)
    _check_single_sheet(vertices, faces)
    contents = placed(vertices, (None, None, None), header)
    if len(faces) and (loose := count - len(np.unique(faces))):
        unused = f"{loose} of {count} vertices belong to no face; they were used like the others"
        return contents._replace(remarks=(*contents.remarks, caution(unused)))
    return contents


def _columns_of_x_y_z(variable: str | None) -> list[int]:
    """Return the indices of x, y and z among the coordinates of the vertices of a mesh.

    ``variable`` states their order, such as "z,x,y" or "3,1,2"; None is "x,y,z". Raise `InputError`
    if it is no such order.
    """
    known = dict(zip("xyz", range(3), strict=True)) | {str(n + 1): n for n in range(3)}
    words = [word.strip().lower() for word in (variable or "x,y,z").split(",")]
    columns = [known.get(word, -1) for word in words]
    if sorted(columns) != [0, 1, 2]:
        raise InputError(f"variable = {variable!r}: must be an order of x, y and z, as in z,x,y")
    return columns


def _comments(path: Path, form: str) -> list[str]:
    """Return the comments at the start of a mesh, where programs state units."""
    with path.open("rb") as file:
        start = file.read(65_536 if form != "stl" else 80).decode("latin-1")
    if form == "stl":
        return [start.partition("\n")[0].removeprefix("solid").replace("\0", " ")]
    marks = {"ply": ("comment ", "obj_info "), "obj": ("#",)}[form]
    lines = start.partition("end_header")[0].splitlines()
    return [line[len(mark) :] for line in lines for mark in marks if line.startswith(mark)]


def _read_by_trimesh(path: Path, form: str) -> tuple[np.ndarray, np.ndarray, int]:
    """Return vertices (n, 3), triangles (m, 3) of their numbers, and the declared number.

    Equal vertices are merged in STL only. The number of vertices is declared in PLY; otherwise 0.
    """
    with needs("walls", form.upper()):
        import trimesh
    points = [np.empty((0, 3))]
    faces = [np.empty((0, 3), dtype=int)]
    count = 0
    with path.open("rb") as file:
        head = file.read(65_536).partition(b"end_header")[0]
        file.seek(0)
        meshes = trimesh.load_scene(file, file_type=form, process=form == "stl").geometry
        for part in meshes.values():
            points.append(np.array(part.vertices, dtype=float))
            faces.append(count + np.reshape(getattr(part, "faces", faces[0]), (-1, 3)))
            count += len(points[-1])
    stated = re.search(rb"element\s+vertex\s+(\d+)", head) if form == "ply" else None
    return np.concatenate(points), np.concatenate(faces), int(stated[1]) if stated else 0


def _read_obj(path: Path) -> tuple[np.ndarray, np.ndarray, int]:
    """Return the vertices (n, 3), triangles (m, 3), and declared number (else 0) of an OBJ file.

    It is not read by trimesh, which drops vertices without a face. Raise `InputError` without any.
    """
    vertices: list[str] = []
    faces: list[list[int]] = []
    declared = 0
    with path.open(encoding="latin-1") as file:
        for line in file:
            kind, *words = line.split() or [""]
            if kind == "v":
                vertices.append(line[2:])
            elif kind == "f":
                # negative numbers count back from the last vertex
                corners = [int(word.split("/")[0]) for word in words]
                corners = [n - 1 if n > 0 else len(vertices) + n for n in corners]
                faces += [[corners[0], *pair] for pair in itertools.pairwise(corners[1:])]
            elif stated := _DECLARED.match(line):
                declared += int(stated[1] or stated[2])
    if not vertices:
        raise InputError("has no vertices (lines 'v x y z')")
    points = np.loadtxt(vertices, ndmin=2)[:, :3]
    return points, np.array(faces, dtype=int).reshape(-1, 3), declared


def _check_single_sheet(points: np.ndarray, faces: np.ndarray) -> None:
    """Raise `InputError` if triangles overlap in the plan, as those of a solid do.

    ``faces`` (m, 3) are numbers of ``points`` (n, 3). They overlap if their areas in the plan sum
    to more than 1.05 times that of the convex hull of the points.
    """
    one, other = (points[faces[:, corner], :2] - points[faces[:, 0], :2] for corner in (1, 2))
    area = 0.5 * float(np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]).sum())
    try:
        hull = scipy.spatial.ConvexHull(points[:, :2]).volume
    except (scipy.spatial.QhullError, ValueError):
        return  # they lie on one line, which `point_distance` reports
    if area > 1.05 * hull:  # a solid has 2
        raise InputError(
            f"the surface overlaps itself: its triangles cover {area / hull:.3g} times the plan "
            f"of its points; {TWO_WALLS}"
        )

"""Points of text files, of which some are matrices of heights, and of meshes (STL, PLY, OBJ)."""

import itertools
import re
import struct
from pathlib import Path

import numpy as np
import scipy

from jointclosure.inputs import InputError, size_of
from jointclosure.inputs.extras import needs
from jointclosure.inputs.remarks import caution
from jointclosure.walls.outliers import strays
from jointclosure.walls.scans.contents import (
    VARIABLE,
    Contents,
    axis_name,
    missing_heights,
    missing_sentence,
    missing_values,
    reading_as,
    split_name,
)
from jointclosure.walls.scans.lattice import lattice_of, merged_points
from jointclosure.walls.scans.text import Table, are_places, is_binary, read_table

LEAST_COLUMNS = 12
"""Columns without names from which on a file is a matrix; points with colours have ten."""
NAMED = 3
"""Largest number of stray points whose places are listed."""
SCATTERED = (
    "the points lie on no regular grid along x and y: heights between them are interpolated, which "
    "makes walls smoother"
)
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


def read_text(path: Path, variable: str | None) -> Contents:
    """Read points of lines of x, y and z, or of three columns; or a matrix of heights."""
    table = read_table(path)
    if variable is None and (matrix := _matrix(table)) is not None:
        return matrix
    columns = _columns(table, variable)
    values = table.values[:, columns]
    x, y, z = (_unit_of(table, column) for column in columns)
    if x != y:
        raise InputError(f"x is in {x} and y in {y}: must be in the same units")
    contents = contents_of(values)
    return contents._replace(
        height_units=z, length_units=x, remarks=table.remarks + contents.remarks
    )


def _matrix(table: Table) -> Contents | None:
    """Return a matrix of heights, on the grid of its frame if it has one; None for points."""
    if table.names:
        points = _below_names(table)
    elif table.values.shape[1] < LEAST_COLUMNS:
        points = None
    elif (points := framed_points(table.values)) is None:
        return Contents(table.values, remarks=table.remarks)
    if points is None:
        return None
    contents = contents_of(points)
    read = "the first row and the first column, evenly spaced, were read as x and y"
    return contents._replace(remarks=(*table.remarks, read, *contents.remarks))


def _below_names(table: Table) -> np.ndarray | None:
    """Return the points (n, 3) of a matrix whose x are names of columns; None for other names."""
    try:
        x = np.array([float(name.replace(",", ".")) for name in table.names[1:]])
    except ValueError:
        return None
    y, heights = table.values[:, 0], table.values[:, 1:]
    return points_on(x, y, heights) if are_places(x) and are_places(y) else None


def points_on(x: np.ndarray, y: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Return points (n, 3) of heights (y, x) at places x and y along the axes."""
    columns = (*np.meshgrid(x, y), heights)
    return np.stack([column.ravel() for column in columns], axis=1)


def framed_points(matrix: np.ndarray) -> np.ndarray | None:
    """Return points (n, 3) of a matrix framed by x and y; None for heights, also of a plane."""
    x, y, heights = matrix[0, 1:], matrix[1:, 0], matrix[1:, 1:]
    if not heights.size or (are_places(heights[0]) and are_places(heights[:, 0])):
        return None
    row, column = are_places(x), are_places(y)
    if row and column:
        return points_on(x, y, heights)
    for looks, line, second in ((row, "row", heights[0]), (column, "column", heights[:, 0])):
        if looks and not are_places(second):
            raise InputError(
                f"its first {line} is evenly spaced, as places are: a matrix must have x in its "
                "first row and y in its first column, or contain only heights"
            )
    return None


def read_matrix(path: Path) -> Contents:
    """Read a text file as one matrix (y, x), of heights or of places."""
    with reading_as("a matrix"):
        table = read_table(path)
    return Contents(table.values, remarks=table.remarks)


def joined(x: Contents, y: Contents, z: Contents) -> Contents:
    """Return heights of one file at the places x and y of two others, as `contents_of`."""
    shapes = [np.asarray(part.heights).shape for part in (x, y, z)]
    if len(set(shapes)) > 1:
        listed = ", ".join(" x ".join(map(str, shape)) for shape in shapes)
        raise InputError(f"matrices of {listed} (rows x columns): must be equal for x, y and z")
    if x.height_units != y.height_units:
        raise InputError(f"x is in {x.height_units} and y in {y.height_units}: must be the same")
    columns = [np.asarray(part.heights, dtype=float).ravel() for part in (x, y, z)]
    contents = contents_of(np.stack(columns, axis=1))
    remarks = x.remarks + y.remarks + z.remarks + contents.remarks
    return contents._replace(
        height_units=z.height_units, length_units=x.height_units, remarks=remarks
    )


def contents_of(points: np.ndarray) -> Contents:
    """Return points (n, 3) as the regular grid on which they lie, otherwise as points."""
    points, remarks = cleaned(points)
    if (grid := lattice_of(points)) is not None:
        return grid._replace(remarks=remarks + grid.remarks)
    points, repeats = merged_points(points)
    return Contents(points=points, remarks=(*remarks, *repeats, caution(SCATTERED)))


def _unit_of(table: Table, column: int) -> str | None:
    """Return the unit of a column from its name or from the line of units below the names."""
    name = table.names[column] if table.names else ""
    by_name, by_line = split_name(name)[1], table.units[column] if table.units else None
    if by_name and by_line and size_of(by_name) != size_of(by_line):
        raise InputError(
            f"the column {name!r} has the unit {by_line!r} in the line of units; must be the same"
        )
    return by_name or by_line


def cleaned(points: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return points (n, 3) of a wall, NaN where a height is missing, and remarks."""
    points = points.astype(float)
    places, sentinels = zip(*(missing_values(column) for column in points[:, :2].T), strict=True)
    without_height, remarks = missing_heights(points[:, 2])
    missing = np.column_stack([*places, without_height])
    if missing[:, :2].any():
        count, values = int(missing[:, :2].any(axis=1).sum()), np.unique(np.concatenate(sentinels))
        remarks += (missing_sentence(count, values, "places"),)
    points[missing] = np.nan
    points[~np.isfinite(points)] = np.nan
    placed = np.isfinite(points[:, :2]).all(axis=1)
    nowhere = np.flatnonzero(~placed & np.isfinite(points[:, 2]) & ~missing.any(axis=1))
    if nowhere.size:
        raise InputError(f"{nowhere.size} points lack x or y, the first is number {nowhere[0] + 1}")
    if not placed.all():
        remarks += (f"{int((~placed).sum())} lines without a place were skipped",)
        points = points[placed]
    stray = strays(points)
    if stray.any():
        named = [f"({x:g}, {y:g}, {z:g})" for x, y, z in points[stray][:NAMED]]
        more = ", ..." if stray.sum() > NAMED else ""
        verb = "points were" if stray.sum() > 1 else "point was"
        remarks += (
            f"{int(stray.sum())} stray {verb} cut, far from all others: {', '.join(named)}{more} "
            "(x, y, z in the file's units)",
        )
        points = points[~stray]
    return points, remarks


def _columns(table: Table, variable: str | None) -> list[int]:
    """Return the numbers of the columns of x, y and z."""
    names, width = table.names, table.values.shape[1]
    bare = [axis_name(name) for name in names]
    if variable is not None:
        return _stated_columns(names, bare, width, variable)
    if names and not {"x", "y", "z"} <= set(bare):
        raise InputError(
            f"columns {', '.join(names)}: must be named x, y and z, or {VARIABLE} must state them, "
            "such as 1,2,3"
        )
    if not names and width != 3:
        raise InputError(
            f"{width} columns that are not named x, y and z: must be three in this order, or "
            f"{VARIABLE} must state them, such as 1,2,3; a matrix of heights has at least "
            f"{LEAST_COLUMNS}"
        )
    return [bare.index(axis) for axis in "xyz"] if names else [0, 1, 2]


def _stated_columns(names: list[str], bare: list[str], width: int, variable: str) -> list[int]:
    columns, words = [], [word.strip() for word in variable.split(",")]
    for word in words:
        if word.isdecimal() and 1 <= int(word) <= width:
            columns.append(int(word) - 1)
        elif word in names:
            columns.append(names.index(word))
        elif word.lower() in bare:
            columns.append(bare.index(word.lower()))
    if not len(set(columns)) == len(columns) == len(words) == 3:
        allowed = ", ".join(names) if names else f"numbers from 1 to {width}"
        raise InputError(
            f"variable = {variable!r}: must be three columns for x, y and z, as in 1,2,3; "
            f"there are {allowed}"
        )
    return columns


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
    if len(faces) and (loose := len(vertices) - len(np.unique(faces))):
        used = (
            f"{loose} of {len(vertices)} vertices belong to no face; they were used like the others"
        )
        return contents._replace(remarks=(*contents.remarks, caution(used)))
    return contents


def _by_trimesh(path: Path, form: str) -> tuple[np.ndarray, np.ndarray, int]:
    """Return vertices (n, 3), merged in STL only, triangles (m, 3), and the declared number."""
    with needs("walls", form.upper()):
        import trimesh
    if form == "stl":
        _check_stl(path)
    points, faces, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=int)], 0
    with path.open("rb") as file:
        head = file.read(_HEAD).partition(b"end_header")[0]
        file.seek(0)
        meshes = trimesh.load_scene(file, file_type=form, process=form == "stl").geometry
        for part in meshes.values():
            points.append(np.array(part.vertices, dtype=float))
            faces.append(count + np.reshape(getattr(part, "faces", faces[0]), (-1, 3)))
            count += len(points[-1])
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
        problem = f"contains {size} bytes, less than the head of 84"
    elif size < declared:
        triangles = (declared - 84) // 50
        problem = f"declares {triangles} triangles, {declared} bytes, and contains {size}"
    else:
        return
    raise InputError(f"{problem}: is the file incomplete?")


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

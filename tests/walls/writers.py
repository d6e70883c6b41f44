"""Functions that write a wall in every form of file that can be read: `FORMS`.

They return the arguments of `read_scan` that the file does not contain.
"""

import struct
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import xarray as xr

from jointclosure.walls.gridding import Cloud, Scan
from jointclosure.walls.scans import read_scan


class Ground:
    """Wall (y, x) [mm] on a grid of ``step`` [mm], with the place (y, x) [mm] of its first cell."""

    def __init__(self, heights: np.ndarray, step: float = 0.25, corner=(0.0, 0.0)):
        self.heights, self.step, self.corner = heights, step, corner

    def points(self) -> np.ndarray:
        """Return the points (n, 3) [mm], row by row."""
        return np.stack([part.ravel() for part in (*self.places(), self.heights)], axis=1)

    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the matrices (y, x) of x and y [mm]."""
        y, x = np.indices(self.heights.shape) * self.step
        return x + self.corner[1], y + self.corner[0]


def as_npz(path, ground):
    np.savez(path, Z_um=1e3 * ground.heights, spacing_m=1e-3 * ground.step)
    return {}


def as_netcdf(path, ground):
    """Write from the largest y down, transposed, with heights and places in different units."""
    places = {
        axis: (axis, 1e-3 * (corner + ground.step * np.arange(size)), {"units": "m"})
        for axis, size, corner in zip("yx", ground.heights.shape, ground.corner, strict=True)
    }
    height = (("y", "x"), 1e3 * ground.heights, {"units": "micrometre"})
    dataset = xr.Dataset({"height": height}, places)
    dataset.isel(y=slice(None, None, -1)).transpose("x", "y").to_netcdf(path, engine="netcdf4")
    return {}


def as_csv(path, ground):
    points = ground.points() * [1.0, 1.0, 1e3]
    np.savetxt(path, points, "%.6f", ",", header="x,y,z\nmm,mm,um", comments="")
    return {}


def as_shuffled_text(path, ground):
    points = np.random.default_rng(1).permutation(ground.points())
    np.savetxt(path, np.vstack([points, points[:3]]), "%.6f")
    return {"units": "mm"}


def as_matrix(path, ground):
    """Write heights alone: units and spacing are stated beside the file."""
    if path.suffix == ".npy":
        np.save(path, ground.heights)
    elif path.suffix == ".tif":
        pytest.importorskip("tifffile").imwrite(path, ground.heights)
    else:
        np.savetxt(path, ground.heights, "%.6f")
    return {"units": "mm", "scan_spacing": 1e-3 * ground.step}


def as_gwyddion(path, ground):
    """Write a text matrix with Gwyddion's header, which SurfaceTopography reads."""
    pytest.importorskip("SurfaceTopography")
    height, width = (size * ground.step for size in ground.heights.shape)
    head = f"Channel: Height\nWidth: {width} mm\nHeight: {height} mm\nValue units: mm"
    np.savetxt(path, ground.heights, "%.12g", header=head)
    return {}


def as_matlab(path, ground):
    x, y = ground.places()
    scipy.io.savemat(path, {"Z_um": 1e3 * ground.heights, "X_mm": x, "Y_mm": y})
    return {}


def surfer_7(heights, step, corner=(0.0, 0.0), blank=1e30):
    """Return the bytes of a Surfer grid of version 7."""
    (ny, nx), (y, x) = heights.shape, corner
    grid = struct.pack("<2i8d", ny, nx, x, y, step, step, 0.0, 0.0, 0.0, blank)
    sections = {b"DSRB": struct.pack("<i", 2), b"FLTI": bytes(5), b"GRID": grid}
    parts = (sections | {b"DATA": heights.astype("<f8").tobytes()}).items()
    return b"".join(name + struct.pack("<i", len(part)) + part for name, part in parts)


def as_surfer(path, ground):
    (ny, nx), (y, x) = ground.heights.shape, ground.corner
    ends = x + ground.step * (nx - 1), y + ground.step * (ny - 1)
    limits = [x, ends[0], y, ends[1], ground.heights.min(), ground.heights.max()]
    if path.stem == "c":
        path.write_bytes(surfer_7(ground.heights, ground.step, ground.corner))
    elif path.stem == "b":
        head = b"DSBB" + struct.pack("<2h6d", nx, ny, *limits)
        path.write_bytes(head + ground.heights.astype("<f4").tobytes())
    else:
        numbers = " ".join(f"{value:.9f}" for value in ground.heights.ravel())
        path.write_text(f"DSAA\n{nx} {ny} {' '.join(map(repr, map(float, limits)))} {numbers}")
    return {"units": "mm"}


def as_three_files(path, ground):
    for name, matrix in zip("xyz", (*ground.places(), ground.heights), strict=True):
        np.savetxt(path.parent / f"{name}.dat.txt", matrix, "%.6f")
    return {"units": "mm"}


def triangles(shape):
    """Return the corners (n, 3) of the triangles between the points of a grid."""
    ny, nx = shape
    corner = (np.arange(ny - 1)[:, None] * nx + np.arange(nx - 1)).ravel()
    first, second = [corner, corner + 1, corner + nx], [corner + 1, corner + nx + 1, corner + nx]
    return np.concatenate([np.stack(first, axis=1), np.stack(second, axis=1)])


def write_mesh(path, points, faces):
    """Write a mesh in the form of the file's suffix; ``text.ply`` is ASCII."""
    trimesh = pytest.importorskip("trimesh")
    text = {"encoding": "ascii"} if path.name == "text.ply" else {}
    mesh = trimesh.Trimesh(points, faces, process=False)
    content = mesh.export(file_type=path.suffix[1:], **text)
    path.write_bytes(content.encode() if isinstance(content, str) else content)


def as_mesh(path, ground):
    write_mesh(path, ground.points(), triangles(ground.heights.shape))
    return {"units": "mm"}


def as_esri(path, ground, rows=None, **head):
    """Write an ESRI grid: rows from the largest y down, and the corner of the first cell."""
    (ny, nx), (y, x) = ground.heights.shape, ground.corner
    words = {"ncols": nx, "nrows": ny, "xllcorner": x, "yllcorner": y, "cellsize": ground.step}
    words |= {"NODATA_value": -9999} | head
    heights = np.where(np.isnan(ground.heights), -9999, ground.heights)[::-1][:rows]
    lines = "\n".join(f"{key} {value}" for key, value in words.items() if value is not None)
    np.savetxt(path, heights, "%.9f", header=lines, comments="")
    return {"units": "mm"}


def as_geotiff(path, ground, placed=2):
    """Write a GeoTIFF [m] with the largest y first, placed by cells' middles (2) or corners (1)."""
    keys = (1, 1, 0, 3, 1025, 0, 1, placed, 3076, 0, 1, 9001, 4099, 0, 1, 9001)
    step, y, x = (1e-3 * part for part in (ground.step, *ground.corner))
    top = y + step * (len(ground.heights) - 1)
    tags = [
        (33550, "d", 3, (step, step, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, x, top, 0.0), True),
        (34735, "H", len(keys), keys, True),
        (42113, "s", 0, "-9999", True),
    ]
    heights = np.where(np.isnan(ground.heights), -9999.0, 1e-3 * ground.heights)[::-1]
    pytest.importorskip("tifffile").imwrite(path, heights, extratags=tags)
    return {}


FORMS = {
    **dict.fromkeys(("a.npy", "a.txt", "a.tif"), as_matrix),
    **dict.fromkeys(("a.stl", "a.ply", "text.ply", "a.obj"), as_mesh),
    **dict.fromkeys(("a.grd", "b.grd", "c.grd"), as_surfer),
    **dict.fromkeys(("a.asc", "esri.txt"), as_esri),
    "a.npz": as_npz, "a.mat": as_matlab, "a.nc": as_netcdf, "geo.tiff": as_geotiff,
    "a.csv": as_csv, "a.xyz": as_shuffled_text, "gwyddion.asc": as_gwyddion,
    "x.dat.txt,y.dat.txt,z.dat.txt": as_three_files,
}  # fmt: skip


def files_in(form: str, folder: Path) -> list[Path]:
    """Return the file of a form, or its three files."""
    return [folder / part for part in form.split(",")]


def read_in(form: str, ground: Ground, folder: Path) -> Scan | Cloud:
    """Write a wall in a form and read it."""
    given = FORMS[form](folder / form, ground)
    files = files_in(form, folder)
    return read_scan(files if len(files) > 1 else files[0], **given)

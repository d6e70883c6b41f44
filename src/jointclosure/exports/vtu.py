"""Mesh of the midplane of a joint, for OpenGeoSys and ParaView."""

import numpy as np
import xarray as xr

from jointclosure.exports.loading import Exported
from jointclosure.joint.history import history_of


def fracture_mesh(joint: xr.Dataset) -> Exported:
    """Triangulate the midplane of a joint whose walls, as they are at the end, just touch.

    Every cell is a point of the mesh (n, 3) [m], and four neighbouring cells are the corners of two
    triangles (m, 3). The fields of triangles (m,) are ``aperture`` [m], the mean of the three
    corners, ``contact``, 1 if a corner is in contact, else 0, and ``MaterialIDs``, 0.
    """
    upper = joint.upper_final.values
    lower = joint.lower_final.values
    together = upper + lower
    aperture = together.max() - together  # exactly 0 at first touch
    midplane = lower + 0.5 * aperture
    ny, nx = upper.shape
    y, x = np.indices(upper.shape) * history_of(joint).spacing
    points = np.column_stack([x.ravel(), y.ravel(), midplane.ravel()])
    corner = (np.arange(ny - 1)[:, None] * nx + np.arange(nx - 1)).ravel()
    halves = (corner, corner + 1, corner + nx), (corner + 1, corner + nx + 1, corner + nx)
    triangles = np.concatenate([np.stack(corners, axis=1) for corners in halves])
    of_corners = aperture.ravel()[triangles]
    fields = {
        "aperture": of_corners.mean(axis=1),
        "contact": (of_corners == 0.0).any(axis=1).astype(np.int32),
        "MaterialIDs": np.zeros(len(triangles), np.int32),
    }
    return Exported({"fracture.vtu": (points, triangles, fields)}, [])

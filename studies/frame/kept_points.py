"""Joints of several points, of which those of finished points survive an interruption."""

import shutil
from collections.abc import Sequence
from pathlib import Path

import xarray as xr

from jointclosure.storage.files import digest
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.walls import Walls
from studies.frame.checked_files import ForeignFileError, read_checked
from studies.frame.settings import Point
from studies.frame.simulation import Report, close_points, joined_points


class KeptPoints:
    """Folder in which the joints of finished points are kept until all points are closed.

    Files of another ``key`` (of points, quantities and code) or of other walls are made again.
    """

    def __init__(self, folder: Path, key: str) -> None:
        self.folder = folder
        self.key = key

    def closed(
        self,
        points: Sequence[Point],
        names: Sequence[str],
        report: Report,
        walls: Sequence[Walls],
    ) -> xr.Dataset:
        """Close the joints of points that are not kept, and join all; see `close_points`."""
        key = digest(self.key, *(wall.tobytes() for pair in walls for wall in pair))
        self.folder.mkdir(parents=True, exist_ok=True)
        parts = []
        for number, point in enumerate(points):
            file = self.folder / f"{number}.nc"
            try:
                part = read_checked(file, key)
                report(f"point {number} of an earlier run is kept")
            except (OSError, ForeignFileError):  # missing, damaged, or of something else
                part = close_points([point], names, report, walls)
                write_netcdf(part.assign_attrs(key=key), file)
            parts.append(part)
        return joined_points(parts)

    def remove(self) -> None:
        """Remove the folder, whose joints are in the file of all points."""
        shutil.rmtree(self.folder, ignore_errors=True)

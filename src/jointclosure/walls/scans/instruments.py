"""Files of surface scanners, read by SurfaceTopography, which supports about forty formats."""

from pathlib import Path

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.walls.scans.contents import Contents, check_size, reading_as


def read_any(path: Path, variable: str | None) -> Contents:
    """Read a channel of a scanner's file, by default the default channel of the file."""
    with needs("walls", f"{path.suffix or 'a file without suffix'}: a scanner's format"):
        from SurfaceTopography.Exceptions import CannotDetectFileFormat
        from SurfaceTopography.IO import open_topography
    with reading_as("a scanner's file"):
        try:
            opened = open_topography(str(path))
        except CannotDetectFileFormat:  # its message has the errors of all readers
            raise InputError("is of no form that is read here") from None
    with reading_as("a scanner's file"), opened as reader:
        index = None
        if variable is not None:
            names = [channel.name for channel in reader.channels]
            if variable not in names:
                raise InputError(f"variable = {variable!r}: must be one of {', '.join(names)}")
            index = names.index(variable)
        channel = reader.default_channel if index is None else reader.channels[index]
        check_size(tuple(channel.nb_grid_pts))
        sizes = None if channel.physical_sizes is not None else tuple(channel.nb_grid_pts)
        given = {} if sizes is None else {"physical_sizes": sizes}
        surface = reader.topography(channel_index=index, **given)
        if surface.dim != 2:
            raise InputError("contains a profile, must be a surface")
        heights = np.ma.filled(np.ma.asarray(surface.heights()).astype(float), np.nan)
        pixels, units = surface.pixel_size, surface.unit
    # SurfaceTopography's arrays are (x, y)
    spacing = (float(pixels[1]), float(pixels[0])) if sizes is None else None
    return Contents(heights.T, spacing, None, units, units)

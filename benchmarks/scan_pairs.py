"""Small pairs of scanned walls for other benchmarks, from published scans.

From one --wall (the largest square without holes, `patch63_mm`, of a regridded scan, 0.25 mm): the
wall on itself turned by 180 degrees, and on itself mirrored. From both walls of a fracture, --upper
and --lower, in one frame: the middle, 64 x 64 cells of 0.25 mm, in the position as scanned. The
--output folder then has files ``turned``, ``mirrored`` and ``fracture``, each ``_upper.npz`` and
``_lower.npz``, with heights [mm] upwards in one frame, as `price_of_accuracy.py` and
`strength_bound.py` read them.
"""

from pathlib import Path

import yardstick

# isort: split
import numpy as np

from jointclosure.walls.wall_files import registered_walls

SPACING_MM = 0.25
CELLS = 64


def write_pair(folder: Path, name: str, upper: np.ndarray, lower: np.ndarray) -> None:
    """Write heights (y, x) [mm] of both walls of a pair, upwards in one frame."""
    for side, heights in (("upper", upper), ("lower", lower)):
        np.savez(folder / f"{name}_{side}.npz", Z_mm=heights, spacing_mm=SPACING_MM)


def main(wall: Path, upper: Path, lower: Path, output: Path) -> None:
    """Write the three pairs."""
    output.mkdir(parents=True, exist_ok=True)
    patch = np.load(wall)["patch63_mm"]
    write_pair(output, "turned", patch[::-1, ::-1], patch)
    write_pair(output, "mirrored", patch[:, ::-1], patch)
    fracture = registered_walls(
        str(upper), str(lower), {"units": "mm"}, 1e-3 * SPACING_MM,
        orientation="common_frame", shift="scanned", unusual_values=True,
    )  # fmt: skip
    middle = tuple(slice((n - CELLS) // 2, (n - CELLS) // 2 + CELLS) for n in fracture.upper.shape)
    write_pair(output, "fracture", -1e3 * fracture.upper[middle], 1e3 * fracture.lower[middle])


if __name__ == "__main__":
    asked = yardstick.options(__doc__, wall=Path, upper=Path, lower=Path, output=Path)
    main(asked.wall, asked.upper, asked.lower, asked.output)

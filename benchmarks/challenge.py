"""Contact area of the surface of the Contact-Mechanics Challenge, by pressure.

The challenge (Müser et al. 2017, Tribology Letters 65, 118) presses a rigid, periodic, self-affine
surface of 0.1 mm x 0.1 mm against an elastic half-space. This script reads its heights as published
("Format 2 (ASCII, matrix form)" of www.lmp.uni-saarland.de, one line of numbers a row, heights in
0.1 mm), closes them against a flat wall in the elastic scene with substrates and interaction, and
prints the relative contact area over the pressure p/E*, to be laid beside the published curve.

Not the same: the sides of this model are free, each cell is an asperity of its own curvature, and
there is no adhesion. It was run on small files of this form only; the surface was not to be had.

    python benchmarks/challenge.py surface.0512x0512.ASCII.dat

"Dark areas of shown surface touch the counter face first" is read as the lowest heights; compare
your file with the published picture, and use ``--touches highest`` if it is the other way round.
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from yardstick import machine

import jointclosure as jc
from jointclosure.scans.text import read_table
from jointclosure.verification.analytic import ELASTIC, MODULUS, ROCK

SIDE = 1e-4
"""Length of the surface [m], and unit of its heights."""
PRESSURES = np.geomspace(1e-3, 5e-2, 9)
"""Pressures over E*; the reference of the challenge is 0.01."""


def table(heights: np.ndarray, pressures: np.ndarray = PRESSURES) -> pd.DataFrame:
    """Close heights (y, x) [m] against a flat wall at pressures over E*.

    The highest point touches first.
    """
    joint = jc.simulate(
        heights,
        np.zeros(heights.shape),
        spacing=SIDE / len(heights),
        rock=ROCK,
        max_normal_stress=MODULUS * pressures[-1],
        cycles=1,
        seating_stress=0.0,
        effects=ELASTIC,
        unusual_values=True,
    )
    up = joint.isel(step=joint.branch == "loading")
    area = np.interp(pressures * MODULUS, up.normal_stress, up.contact_fraction)
    return pd.DataFrame({"p / E*": pressures, "relative contact area": area})


def main(path: Path, touches: str) -> None:
    """Print the table of a file."""
    if not path.is_file():
        raise SystemExit(f"{path}: file not found")
    heights = SIDE * read_table(path).values
    heights = -heights if touches == "lowest" else heights
    print(f"{machine()}\n{path.name}: {heights.shape[1]} x {heights.shape[0]} heights")
    print(table(heights).to_string(index=False, float_format="%.4g"))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("path", type=Path)
    parser.add_argument("--touches", choices=("highest", "lowest"), default="lowest")
    main(**vars(parser.parse_args()))

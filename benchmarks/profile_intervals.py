"""Intervals of the roughness of profiles: how often they contain the value of the whole profile.

A self-affine profile (H = 0.8, RMS slope 0.25 at 0.25 mm) is cut into parts, and each part is
measured. The value of the whole profile is the mean of those of its parts, and of Z2 their root
mean square.

    .venv/bin/python -m benchmarks.profile_intervals
"""

from pathlib import Path

import numpy as np
import pandas as pd
import scipy

from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.storage.files import write_csv
from jointclosure.storage.provenance import write_origin
from jointclosure.walls.profile_roughness import Profile, levelled_profile, measure_profile

SPACING, SLOPE, HURST = 0.25e-3, 0.25, 0.8
PARTS = {64: 100, 200: 32}  # number of parts by their points
OUTPUT = Path("benchmarks/results/profile_intervals")


def self_affine(points: int) -> np.ndarray:
    """Return the heights (points,) [m] of a part of an eight times as long periodic profile."""
    random = generator(seed_of(1, "profile intervals", points))
    frequencies = np.fft.rfftfreq(8 * points)
    frequencies[0] = np.inf
    waves = np.fft.rfft(random.standard_normal(8 * points)) * frequencies ** -(HURST + 0.5)
    heights = np.fft.irfft(waves, 8 * points)[:points]
    return heights * SLOPE * SPACING / np.sqrt(np.mean(np.diff(heights) ** 2))


def coverage(points: int, parts: int) -> pd.DataFrame:
    """Count the intervals of parts of a profile that contain the value of the whole profile."""
    rows = []
    for part in self_affine(points * parts).reshape(parts, points):
        heights, spacing = levelled_profile(Profile(SPACING * np.arange(points), part))[:2]
        rows += [measure._asdict() for measure in measure_profile(heights, spacing)]
    found = pd.DataFrame(rows)
    results = []
    for name, values in found.groupby("name", sort=False):
        mean = float(values.value.mean())
        truth = float(np.sqrt(np.mean(values.value**2))) if name == "Z2" else mean
        held = int(((values.low <= truth) & (truth <= values.high)).sum())
        low, high = scipy.stats.binomtest(held, parts).proportion_ci(method="exact")
        row = {"points": points, "parts": parts, "measure": name, "whole": truth, "held": held}
        results.append(row | {"share_low": low, "share_high": high})
    return pd.DataFrame(results)


def main() -> None:
    OUTPUT.mkdir(parents=True, exist_ok=True)
    result = pd.concat([coverage(*each) for each in PARTS.items()], ignore_index=True)
    write_csv(result, OUTPUT / "coverage.csv")
    write_origin(OUTPUT)
    print(result.round(3).to_string(index=False))


if __name__ == "__main__":
    main()

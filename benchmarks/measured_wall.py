"""Our synthetic walls against a measured one: slopes, their correlation, scaling, curvature, peaks.

    python benchmarks/measured_wall.py scan.npz --variable patch63_mm --output out/

Takes the largest full square of the scan, draws walls by `wall_pair` with its size, spacing and JRC
(that of its slope), once with the study's Hurst exponent of 0.8 and once with the scan's own, and
prints where the scan lies among them: docs/measured_walls.md.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import matplotlib.ticker
import numpy as np
import pandas as pd

import jointclosure as jc
from jointclosure.scans import read_scan
from jointclosure.scans.units import UNITS
from jointclosure.storage.figures import save_figure
from jointclosure.storage.text import write_csv
from jointclosure.surface.differences import mean_curvature, peak_cells, slope_correlation
from jointclosure.surface.measured import point_distance, wall_on_grid, windows
from jointclosure.surface.measures import hurst_of, increments
from jointclosure.surface.roughness import detrended, jrc_of_z2, rms_slope

DISTANCES_MM = (0.5, 1.0, 2.0, 4.0)
STUDY_HURST = 0.8


def main() -> None:
    arguments = _arguments()
    spacing = None if arguments.spacing is None else 1e-3 * arguments.spacing
    scan = read_scan(
        arguments.file, units=arguments.units, spacing=spacing, variable=arguments.variable
    )
    spacing = point_distance(scan)
    wall = largest_square(wall_on_grid(scan, spacing))
    z2, own = rms_slope(wall, spacing), hurst_of(wall)
    print(
        f"{wall.shape[0]} x {wall.shape[1]} cells of {1e3 * spacing:g} mm; Z2 {z2:.4f}, H {own:.2f}"
    )
    sets = {}
    for hurst in (STUDY_HURST, min(own, 1.0)):
        jrc = jrc_of_z2(z2, spacing, hurst)
        print(f"H = {hurst:.2f}: {2 * arguments.pairs} synthetic walls of JRC {jrc:.2f}")
        pairs = (
            jc.wall_pair(jrc, wall.shape, spacing, s, hurst, roll_off=None)
            for s in range(arguments.pairs)
        )
        sets[f"H = {hurst:.2f}"] = [one for pair in pairs for one in pair]
    table = compared(wall, sets, spacing)
    print(table.round(3).to_string(index=False))
    if arguments.output:
        arguments.output.mkdir(parents=True, exist_ok=True)
        write_csv(table, arguments.output / "measured_wall.csv")
        save_figure(drawn(wall, sets, spacing), arguments.output / "measured_wall.png")


def _arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="the measured wall")
    parser.add_argument("--units", choices=list(UNITS))
    parser.add_argument("--spacing", type=float, help="of its grid [mm]")
    parser.add_argument("--variable")
    parser.add_argument("--pairs", type=int, default=100, help="synthetic pairs of walls")
    parser.add_argument("--output", type=Path, help="folder for the table and the figure")
    return parser.parse_args()


def largest_square(wall: np.ndarray) -> np.ndarray:
    """The largest square window without a missing cell, plane-detrended."""
    for size in range(min(wall.shape), 2, -1):
        try:
            y, x = windows(wall, (size, size))[0]
        except jc.InputError:
            continue
        return detrended(wall[y : y + size, x : x + size])
    raise jc.InputError("no 3 x 3 cells without a missing one")


def values_of(wall: np.ndarray, spacing: float) -> dict[str, float]:
    """All that is compared, by name."""
    steps = {"x": np.diff(wall, axis=1) / spacing, "y": np.diff(wall, axis=0) / spacing}
    found = increments(wall, spacing)
    pooled = np.concatenate([part.ravel() for part in steps.values()])
    values = {f"Z2 along {axis}": float(np.sqrt(np.mean(part**2))) for axis, part in steps.items()}
    larger, smaller = max(values.values()), min(values.values())
    values["Z2, larger over smaller direction"] = larger / smaller
    values["kurtosis of slopes (normal: 3)"] = np.mean(pooled**4) / np.mean(pooled**2) ** 2
    for distance in DISTANCES_MM:
        lag = round(1e-3 * distance / spacing)
        both = [slope_correlation(wall, np.array([lag]), axis)[0] for axis in "xy"]
        values[f"slope correlation at {distance:g} mm"] = np.mean(both)
    values["rms height (mm)"] = 1e3 * wall.std()
    values["H, second differences"] = hurst_of(wall)
    logs = [np.log(part[1:]) for part in (found.distances, np.hypot(found.x, found.y))]
    values["H, first differences"] = np.polyfit(*logs, 1)[0]
    for axis in "xy":
        curvature = getattr(found, f"second_{axis}")[0] / spacing**2
        values[f"rms curvature along {axis} (1/mm)"] = 1e-3 * curvature
    peaks, curvature = peak_cells(wall), 1e-3 * mean_curvature(wall, spacing)
    values["peaks per mm2"] = 1e-6 * peaks[1:-1, 1:-1].mean() / spacing**2
    values["mean height of peaks (rms heights)"] = wall[peaks].mean() / wall.std()
    values["mean curvature of peaks (1/mm)"] = curvature[peaks].mean()
    return values


def compared(wall: np.ndarray, sets: dict[str, list], spacing: float) -> pd.DataFrame:
    """The wall's values, and of each set the mean, the middle 95 % and the share below the wall."""
    measured = values_of(wall, spacing)
    table = pd.DataFrame({"quantity": list(measured), "measured": list(measured.values())})
    for name, walls in sets.items():
        drawn_values = pd.DataFrame([values_of(one, spacing) for one in walls])
        table[f"{name}: mean"] = drawn_values.mean().to_numpy()
        table["low"], table["high"] = drawn_values.quantile([0.025, 0.975]).to_numpy()
        below = [100.0 * np.mean(drawn_values[key] < value) for key, value in measured.items()]
        table["below (%)"] = below
        renamed = {key: f"{name}: {key}" for key in ("low", "high", "below (%)")}
        table = table.rename(columns=renamed)
    return table


def drawn(wall: np.ndarray, sets: dict[str, list], spacing: float):
    """Correlation of slopes, rms differences, slopes, and heights of peaks: scan against sets."""
    figure, panels = plt.subplots(2, 2, figsize=(9.5, 7.4), layout="constrained")
    lags = np.arange(0, min(wall.shape) // 3)
    _band(panels[0, 0], 1e3 * spacing * lags, wall, sets,
          lambda one: 0.5 * sum(slope_correlation(one, lags, axis) for axis in "xy"))  # fmt: skip
    for axis, style in (("x", ":"), ("y", "--")):
        values = slope_correlation(wall, lags, axis)
        panels[0, 0].plot(
            1e3 * spacing * lags, values, style, color="k", lw=0.9, label=f"scan, along {axis}"
        )
    panels[0, 0].axhline(0.0, color="0.6", lw=0.6)
    panels[0, 0].set(xlabel="distance (mm)", ylabel="correlation of slopes", ylim=(-0.35, 1.02))
    distances = 1e3 * increments(wall, spacing).distances
    _band(panels[0, 1], distances, wall, sets, lambda one: _second(one, spacing))
    panels[0, 1].set(xscale="log", yscale="log", xlabel="distance (mm)",
                     ylabel="rms second difference (mm)")  # fmt: skip
    for axis in (panels[0, 1].xaxis, panels[0, 1].yaxis):
        axis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
        axis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    bins = np.linspace(-4.0, 4.0, 41)
    centres = 0.5 * (bins[1:] + bins[:-1])
    _band(panels[1, 0], centres, wall, sets, lambda one: _slopes(one, bins))
    panels[1, 0].set(yscale="log", xlabel="slope / rms slope", ylabel="density", ylim=(1e-4, 1.0))
    coarse = np.linspace(-3.0, 3.0, 13)
    _band(panels[1, 1], 0.5 * (coarse[1:] + coarse[:-1]), wall, sets,
          lambda one: _peaks(one, coarse))  # fmt: skip
    panels[1, 1].set(xlabel="height of peaks / rms height", ylabel="density")
    panels[0, 0].legend(frameon=False, fontsize=8)
    return figure


def _second(wall, spacing):
    found = increments(wall, spacing)
    return 1e3 * np.sqrt(0.5 * (found.second_x**2 + found.second_y**2))


def _slopes(wall, bins):
    steps = np.concatenate([np.diff(wall, axis=axis).ravel() for axis in (0, 1)])
    return np.histogram(steps / np.sqrt(np.mean(steps**2)), bins, density=True)[0]


def _peaks(wall, bins):
    return np.histogram(wall[peak_cells(wall)] / wall.std(), bins, density=True)[0]


def _band(axes, places, wall, sets, read) -> None:
    """What is read of the wall as a line, of the sets as means and bands of their middle 95 %."""
    for number, (name, walls) in enumerate(sets.items()):
        values = np.array([read(one) for one in walls])
        low, high = np.percentile(values, [2.5, 97.5], axis=0)
        axes.fill_between(places, low, high, color=f"C{number}", alpha=0.2, lw=0)
        axes.plot(places, values.mean(axis=0), color=f"C{number}", label=f"synthetic, {name}")
    axes.plot(places, read(wall), "k-", lw=1.6, label="scan")


if __name__ == "__main__":
    main()

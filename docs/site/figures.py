"""Draw the pictures of README and of the model's page: python docs/site/figures.py (half a minute)

The diagrams are SVG whose text stays text; forges and the site show them without a network.
"""

import itertools
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

import jointclosure as jc
from jointclosure.joint.history import history_of
from jointclosure.parameters import RESOLVED
from jointclosure.plotting.assessment import assessment_figure
from jointclosure.uncertainty.variants import COPIES
from studies.frame.joint_tables import since_seating

# isort: split
from templates import stored

IMAGES = Path(__file__).parents[1] / "images"
DOLERITE = jc.Rock(youngs_modulus=78e9, poisson_ratio=0.2, compressive_strength=165e6)
FILES, STEP, QUESTION = "#e8e8e8", "#dce9f5", "#fdf0d5"
"""Colours of boxes: files, steps or rules, decisions."""


class Box(NamedTuple):
    """Box of a diagram: its centre in columns and in rows (downwards), its text and colour."""

    x: float
    y: float
    text: str
    colour: str = STEP


SOLVER = {
    "walls": Box(0, 0, "two walls at first touch, D = 0", FILES),
    "step": Box(0, 1, "closure D grows by a displacement step"),
    "contacts": Box(0, 2, "contacts: overlap $\\delta_S$ > 0\n(Eqs. 1 to 4)"),
    "forces": Box(0, 3, "equilibrium of all forces: asperities (5),\n"
                  "substrates (6, 7), interaction (17, 18)"),
    "strong": Box(0, 4, "is a contact beyond its strength?\n(Eqs. 22, 23)", QUESTION),
    "breaks": Box(1, 3, "breakage: height is lost,\ngouge fills lower neighbours,\n"
                  "curvatures are renewed"),
    "next": Box(-1, 3, "a further step"),
    "target": Box(0, 5, "is the target stress reached?", QUESTION),
    "land": Box(0, 6, "the last step is repeated, smaller,\n"
                "until the stress is within 1e-3 of the target"),
    "unload": Box(0, 7, "unloading in the same way to last contact;\nthen the next cycle", FILES),
}  # fmt: skip
SOLVER_ARROWS = (
    "walls step", "step contacts", "contacts forces", "forces strong", "strong breaks yes 0.2",
    "breaks contacts - 0.2", "strong target no", "target next no -0.2", "next step - -0.2",
    "target land yes", "land unload",
)  # fmt: skip
"""Start, end, label and bend of each arrow."""


def diagram(boxes: dict[str, Box], arrows: tuple[str, ...]) -> Figure:
    """Draw boxes and arrows; a column is 3.2 inches wide, a row 0.75 high."""
    low, high = (function(box.x for box in boxes.values()) for function in (min, max))
    rows = max(box.y for box in boxes.values())
    figure = plt.figure(figsize=(3.2 * (high - low + 1), 0.75 * (rows + 1)))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(low - 0.5, high + 0.5), ylim=(rows + 0.5, -0.5))
    axes.axis("off")
    drawn = {}
    for name, box in boxes.items():
        style = {"boxstyle": "round,pad=0.4", "facecolor": box.colour, "edgecolor": "0.5"}
        text = axes.text(box.x, box.y, box.text, ha="center", va="center", size=9, bbox=style)
        figure.canvas.draw()
        drawn[name] = text.get_bbox_patch()
    for arrow in arrows:
        start, end, *rest = arrow.split()
        label, bend = (*rest, "-", "0")[:2] if len(rest) != 1 else (*rest, "0")
        a, b = boxes[start], boxes[end]
        style = {"arrowstyle": "-|>", "color": "0.3", "connectionstyle": f"arc3,rad={bend}",
                 "patchA": drawn[start], "patchB": drawn[end]}  # fmt: skip
        axes.annotate("", (b.x, b.y), (a.x, a.y), arrowprops=style)
        middle = ((a.x + b.x) / 2 + 0.03, (a.y + b.y) / 2 + 1.2 * abs(float(bend)))
        axes.text(*middle, label.strip("-"), size=9, va="center")
    return figure


def composite() -> Figure:
    """Draw two walls, their composite surface, and this model's asperities (the paper's Fig. 1)."""
    figure, panels = plt.subplots(1, 3, figsize=(10, 2.6), layout="constrained")
    cells = np.arange(24.0)
    lower = 0.6 * np.sin(0.55 * cells) + 0.35 * np.sin(1.3 * cells + 1.0)
    upper = 0.5 * np.sin(0.8 * cells + 2.0) + 0.3 * np.sin(1.7 * cells)
    gap = (lower + upper).max()
    for axes, title in zip(panels, ("(a) two walls", "(b) composite", "(c) here"), strict=True):
        axes.set_title(title)
        axes.axis("off")
    for axes in panels[::2]:
        axes.fill_between(cells, -2.5, lower, color="0.8", lw=0)
        axes.fill_between(cells, 3.2, gap - upper, color="0.65", lw=0)
    for heights, up in ((lower, 1), (gap - upper, -1)):
        bends = np.abs(np.gradient(np.gradient(heights)))
        for x, z, bend in zip(cells, heights, bends, strict=True):
            arc = np.linspace(-0.5, 0.5, 9)
            panels[2].plot(x + arc, z - up * 0.5 * bend * arc**2, color="C0", lw=1.5)
    panels[1].bar(cells, lower + upper + 2.5, 0.9, bottom=-2.5, color="0.8")
    panels[1].axhline(gap, color="0.3")
    return figure


def contact() -> Figure:
    """Draw two asperities in contact between their substrates (the paper's Fig. 2)."""
    figure, axes = plt.subplots(figsize=(4.6, 3.6), layout="constrained")
    x = np.linspace(-1, 1, 41)
    axes.fill_between([-2, 2], -2.2, -1.0, color="0.85", lw=0)
    axes.fill_between([-2, 2], 1.0, 2.2, color="0.7", lw=0)
    axes.fill_between(x, -1.0, -(x**2), color="0.85", ec="0.4")
    axes.fill_between(x, 1.0, x**2, color="0.7", ec="0.4")
    for sign, place in ((1, "t"), (-1, "b")):
        arrow = {"arrowstyle": "-|>", "color": "C3", "lw": 2}
        axes.annotate("F", (0, 1.5 * sign), (0, 2.15 * sign), ha="center", arrowprops=arrow)
        axes.text(-1.9, 1.6 * sign, f"substrate: $E_{place}, \\nu_{place}, \\delta_{place}$")
        axes.text(1.05, 0.6 * sign, f"asperity: $R_{{a{place}}}, E_{{a{place}}}$", va="center")
    axes.annotate("", (1, -1.05), (0, -1.05), arrowprops={"arrowstyle": "<->"})
    axes.text(0.5, -1.3, "$r$", ha="center")
    axes.text(-1.3, 0, "$\\delta_a$", va="center")
    axes.axis("off")
    return figure


def overview() -> Figure:
    """Draw a pair of walls, its aperture at the largest stress, and the closure of 20 pairs."""
    load = {"spacing": 0.25e-3, "rock": DOLERITE, "max_normal_stress": 10e6}
    upper, lower = _walls(0)
    joint = jc.simulate(upper, lower, **load, cycles=2, snapshots=[10e6])
    ensemble = jc.simulate_ensemble(_walls, seeds=range(20), **load)
    figure, (section, contacts, curves) = plt.subplots(
        1, 3, figsize=(14, 4.4), width_ratios=(1.25, 1.1, 1.2), layout="constrained"
    )
    jc.plot.walls(upper, lower, spacing=0.25e-3, axes=section)
    jc.plot.aperture(joint, 0, contacts)
    _band(curves, ensemble)
    section.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=3, frameon=False)
    section.set_title("Two walls at first touch, heights stretched")
    contacts.set_title("Aperture at 10 MPa")
    curves.set_title("Mean closure of 20 joints, band of 90 %")
    return figure


def assessment() -> Figure:
    """Draw the assessment of README's joint."""
    walls = [f"config/walls/joint_{side}.npz" for side in ("upper", "lower")]
    assessed = jc.assess(walls, rock="granite", max_normal_stress=10e6)
    return assessment_figure(assessed, "joint_upper.npz on joint_lower.npz")


def price_of_accuracy() -> Figure:
    """Draw errors of means and of single joints over the time of a joint.

    The error of a single joint is that of an older version too. Bars of means are standard errors.
    A vertical line is a setting, which is named above the first panel. Axes of errors begin at
    0.1 %: of a smaller mean only the bar is seen.
    """
    tables = (stored(f"{name}/price") for name in ("price_of_accuracy", "price_before"))
    # all settings but the reference
    known, older = (table[table["closure 1 rms %"] > 0.0] for table in tables)
    seconds, seconds_before = (table.seconds / table.joints for table in (known, older))
    figure, panels = plt.subplots(4, 1, figsize=(6.2, 11.0), sharex=True, layout="constrained")
    responses = ("closure 1", "closure 2", "stiffness 1", "stiffness 2")
    for axes, response in zip(panels, responses, strict=True):
        for time in seconds:
            axes.axvline(time, color="0.85", lw=1.0, zorder=0)
        error = known[f"{response} standard error %"]
        mean = known[f"{response} mean %"].abs()
        axes.errorbar(
            seconds, mean, [np.minimum(error, mean - 1e-6), error],
            color="C0", marker="o", capsize=3, label="mean",
        )  # fmt: skip
        axes.plot(
            seconds, known[f"{response} rms %"], "--", color="C1", marker="s", label="single joint"
        )
        axes.plot(
            seconds_before, older[f"{response} rms %"], ":", color="0.6", marker="^",
            label="single joint, older version", zorder=1,
        )  # fmt: skip
        longest = max(seconds.max(), seconds_before.max())
        axes.set(xscale="log", yscale="log", xlim=(0.8 * seconds.min(), 1.25 * longest))
        axes.set_ylim(0.1, 50.0)
        axes.set_ylabel(f"net {response[:-2]}, cycle {response[-1]}\nsize of the error (%)")
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_locator(NullLocator())
    for name, time in zip(known.setting, seconds, strict=True):
        panels[0].annotate(
            name, (time, 1.02), xycoords=("data", "axes fraction"),
            rotation=90, ha="center", va="bottom", fontsize=9.0,
        )  # fmt: skip
    panels[-1].set_xlabel("processor time of a joint (s)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _walls(seed: int) -> tuple[np.ndarray, np.ndarray]:
    return jc.wall_pair(jrc=8, shape=(100, 100), spacing=0.25e-3, seed=seed)


def _band(axes: Axes, ensemble: xr.Dataset) -> None:
    """Draw the mean net closure of each branch, and the 5 and 95 % quantiles of loading."""
    net = 1e3 * since_seating(ensemble).sel(stress=ensemble.stress > 0.5e6)
    for cycle, branch in itertools.product(ensemble.cycle.values, ensemble.branch.values):
        closure, stress = net.sel(cycle=cycle, branch=branch), 1e-6 * net.stress.values
        low, high = (closure.quantile(share, "realization").values for share in (0.05, 0.95))
        mean, colour = closure.mean("realization").values, ("C0", "C1")[cycle - 1]
        style = {
            "color": "0.2",
            "ls": "--",
            "label": "both cycles, unloading" if cycle == 1 else None,
        }
        if branch == "loading":  # from seating on
            low, high, mean, stress = (np.insert(of, 0, 0.0) for of in (low, high, mean, stress))
            stress[0] = 0.5
            axes.fill_betweenx(stress, low, high, color=colour, alpha=0.15, lw=0)
            width = 1.5 if cycle == 1 else 4.0  # the line of unloading lies on that of cycle 2
            style = {"color": colour, "lw": width, "label": f"cycle {cycle}, loading"}
        axes.plot(mean, stress, **style)
    axes.set(xlabel="net closure since seating at 0.5 MPa (mm)", ylabel="normal stress (MPa)")
    axes.set(xlim=(-0.002, None), ylim=0)
    axes.legend(frameon=False)


def hard_joint() -> Figure:
    """Draw the first loading of copies of a joint that should be equal, at two stresses.

    At the lower stress the joint is hard, at the higher one easy.
    """
    upper, lower = jc.wall_pair(jrc=8, shape=(64, 64), spacing=0.25e-3, seed=1)
    load = {"spacing": 0.25e-3, "rock": DOLERITE, "cycles": 1, "numerics": RESOLVED}
    figure, panels = plt.subplots(1, 2, figsize=(9.0, 4.2), layout="constrained")
    for axes, stress in zip(panels, (1e6, 30e6), strict=True):
        largest = []
        for (name, copy), style in zip(COPIES.items(), ("-", "--", "-.", ":"), strict=True):
            joint = jc.simulate(copy(upper), copy(lower), max_normal_stress=stress, **load)
            history = history_of(joint)
            steps = history.branch(1, "loading").steps
            closure = float(history.net.cycle_closures()["max_closure_seated"][0])
            since_seating = history.net.values[steps] - history.net.values[steps[-1]] + closure
            shown = history.stress[steps] >= history.seating_stress
            axes.plot(
                1e3 * since_seating[shown], 1e-6 * history.stress[steps[shown]], style, label=name
            )
            largest.append(closure)
        scatter = 100.0 * np.std(largest, ddof=1) / np.mean(largest)
        axes.set_title(f"to {1e-6 * stress:g} MPa: net closures scatter by {scatter:.2g} %")
        seating = f"net closure since seating at {1e-6 * history.seating_stress:g} MPa (mm)"
        axes.set(xlabel=seating, ylabel="normal stress (MPa)", ylim=0)
        axes.locator_params(axis="x", nbins=5)
        axes.spines[["top", "right"]].set_visible(False)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4,
                  frameon=False, title="copies of the walls")  # fmt: skip
    return figure


def main() -> None:
    """Write all pictures."""
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "diagrams"})
    diagrams = {
        "solver": diagram(SOLVER, SOLVER_ARROWS),
        "walls": composite(),
        "contact": contact(),
    }
    for name, figure in diagrams.items():
        figure.savefig(IMAGES / f"{name}.svg", metadata={"Date": None}, facecolor="white")
    overview().savefig(IMAGES / "overview.png", dpi=110)
    hard_joint().savefig(IMAGES / "hard_joint.png", dpi=110)
    assessment().savefig(IMAGES / "assessment.png", dpi=110)
    price_of_accuracy().savefig(IMAGES / "price_of_accuracy.png", dpi=110)


if __name__ == "__main__":
    main()

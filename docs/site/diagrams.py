"""Draw the diagrams of the documentation: the flow of the solver, and the rules with their files.

    python docs/site/diagrams.py

They are SVG, which forges and the site show without a network; text stays text.
"""

from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

IMAGES = Path(__file__).parents[1] / "images"
FILES, STEP, QUESTION = "#e8e8e8", "#dce9f5", "#fdf0d5"
"""Colours of boxes: files, steps or rules, decisions."""


class Box(NamedTuple):
    """A box of a diagram: its centre in columns and rows (downwards), its text and colour."""

    x: float
    y: float
    text: str
    colour: str = STEP


class Arrow(NamedTuple):
    """An arrow between two boxes, with a bend (of arc3) and a label beside its middle."""

    start: str
    end: str
    label: str = ""
    bend: float = 0.0


SOLVER = {
    "walls": Box(0, 0, "two walls at first touch, D = 0", FILES),
    "step": Box(0, 1, "closure D grows by a displacement step"),
    "contacts": Box(0, 2, "contacts: overlap $\\delta_S$ > 0\n(Eqs. 1 to 4)"),
    "forces": Box(
        0, 3, "equilibrium of all forces: asperities (5),\nsubstrates (6, 7), interaction (17, 18)"
    ),
    "strong": Box(0, 4, "is a contact beyond its strength?\n(Eqs. 22, 23)", QUESTION),
    "breaks": Box(
        1, 3, "breakage: height is lost,\ngouge fills lower neighbours,\ncurvatures are renewed"
    ),
    "next": Box(-1, 3, "a further step", STEP),
    "target": Box(0, 5, "is the target stress reached?", QUESTION),
    "land": Box(
        0, 6, "the last step is repeated, smaller,\nuntil the stress is within 1e-3 of the target"
    ),
    "unload": Box(0, 7, "unloading in the same way to last contact;\nthen the next cycle", FILES),
}
SOLVER_ARROWS = (
    Arrow("walls", "step"),
    Arrow("step", "contacts"),
    Arrow("contacts", "forces"),
    Arrow("forces", "strong"),
    Arrow("strong", "breaks", "yes", 0.2),
    Arrow("breaks", "contacts", "", 0.2),
    Arrow("strong", "target", "no"),
    Arrow("target", "next", "no", -0.2),
    Arrow("next", "step", "", -0.2),
    Arrow("target", "land", "yes"),
    Arrow("land", "unload"),
)
RULES = {
    "config": Box(0, 0, "config/*.yaml, merged and checked", FILES),
    "kernels": Box(1, 0, "compile_kernels"),
    "make": Box(0, 1, "make_surfaces"),
    "cut": Box(-1, 1, "prepare_walls, cut_surfaces\n(scanned walls)"),
    "walls": Box(0, 2, "cases/, pool/: <case>.<block>.surfaces.nc", FILES),
    "choose": Box(1, 2, "choose_effects\n(effects: auto)"),
    "close": Box(0, 3, "close_surfaces"),
    "cases": Box(0, 4, "cases/, pool/: <case>.<block>.nc", FILES),
    "join": Box(0, 5, "aggregate"),
    "study": Box(0, 6, "study.nc, pool.nc", FILES),
    "products": Box(0, 7, "products: statistics, tables, figures, checks"),
    "tables": Box(0, 8, "tables/, figures/", FILES),
    "report": Box(1, 8, "write_report"),
}
RULES_ARROWS = (
    Arrow("config", "make"),
    Arrow("config", "cut", "", 0.2),
    Arrow("make", "walls"),
    Arrow("cut", "walls", "", 0.2),
    Arrow("walls", "close"),
    Arrow("kernels", "choose"),
    Arrow("walls", "choose"),
    Arrow("choose", "close", "", -0.2),
    Arrow("close", "cases"),
    Arrow("cases", "join"),
    Arrow("join", "study"),
    Arrow("study", "products"),
    Arrow("products", "tables"),
    Arrow("tables", "report"),
)


def diagram(boxes: dict[str, Box], arrows: tuple[Arrow, ...]) -> Figure:
    """Draw boxes and arrows; a column is 3.2 inches wide, a row 0.75 high."""
    columns = {box.x for box in boxes.values()}
    low, high = min(columns), max(columns)
    rows = max(box.y for box in boxes.values())
    figure = plt.figure(figsize=(3.2 * (high - low + 1), 0.75 * (rows + 1)))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(low - 0.5, high + 0.5), ylim=(rows + 0.5, -0.5))
    axes.axis("off")
    drawn = {name: _box(axes, box) for name, box in boxes.items()}
    for arrow in arrows:
        start, end = boxes[arrow.start], boxes[arrow.end]
        axes.annotate("", (end.x, end.y), (start.x, start.y), arrowprops={
            "arrowstyle": "-|>", "color": "0.3", "patchA": drawn[arrow.start],
            "patchB": drawn[arrow.end], "connectionstyle": f"arc3,rad={arrow.bend}",
        })  # fmt: skip
        middle = ((start.x + end.x) / 2 + 0.03, (start.y + end.y) / 2 + 1.2 * abs(arrow.bend))
        axes.text(*middle, arrow.label, size=9, va="center")
    return figure


def _box(axes: Axes, box: Box):
    style = {"boxstyle": "round,pad=0.4", "facecolor": box.colour, "edgecolor": "0.5"}
    text = axes.text(box.x, box.y, box.text, ha="center", va="center", size=9, bbox=style)
    axes.figure.canvas.draw()
    return text.get_bbox_patch()


def main() -> None:
    """Write both diagrams."""
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "diagrams"})
    for name, parts in {"solver": (SOLVER, SOLVER_ARROWS), "rules": (RULES, RULES_ARROWS)}.items():
        figure = diagram(*parts)
        figure.savefig(IMAGES / f"{name}.svg", metadata={"Date": None}, facecolor="white")
        plt.close(figure)


if __name__ == "__main__":
    main()

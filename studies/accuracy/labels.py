"""Labels beside marks that cover neither marks nor other labels."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Bbox

_PLACES = (
    ((5, 4), "left", "bottom"),
    ((5, -4), "left", "top"),
    ((-5, 4), "right", "bottom"),
    ((-5, -4), "right", "top"),
    ((0, 6), "center", "bottom"),
    ((0, -6), "center", "top"),
    ((8, 11), "left", "bottom"),
    ((8, -11), "left", "top"),
    ((-8, 11), "right", "bottom"),
    ((-8, -11), "right", "top"),
)
"""Offsets [points] from a mark's middle that are tried in turn, and the alignment of text there."""
_STAR = 8.0
"""Half-width of a large mark, with some room [points]."""
_APART = 2.0
"""Smallest distance of labels from each other and from marks [points]."""


class Label(NamedTuple):
    """Text, and the mark (data coordinates) to which it belongs."""

    text: str
    x: float
    y: float
    colour: Any


def label_marks(axes: Axes, labels: Sequence[Label], size: float = 6.0) -> None:
    """Write labels beside their marks; labels without room are left out.

    Parameters
    ----------
    axes : Axes
        Axes with all marks, limits and layout.
    labels : sequence of Label
    size : float
        Font size [points].

    Notes
    -----
    A position has room if it lies within the axes and overlaps no mark and no other label.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.draw_without_rendering()
    taken = _marks(axes, figure.dpi / 72.0)
    within = axes.get_window_extent()
    for label in labels:
        for offset, across, along in _PLACES:
            text = axes.annotate(
                label.text, (label.x, label.y), offset, textcoords="offset points", ha=across,
                va=along, fontsize=size, color=label.colour,
            )  # fmt: skip
            text.set_path_effects([withStroke(linewidth=1.5, foreground="w")])
            text.set_in_layout(False)
            box = text.get_window_extent()
            inside = within.x0 <= box.x0 and box.x1 <= within.x1
            inside &= within.y0 <= box.y0 and box.y1 <= within.y1
            wide = box.padded(_APART * figure.dpi / 72.0)
            if inside and not any(wide.overlaps(other) for other in taken):
                taken.append(box)
                break
            text.remove()


def _marks(axes: Axes, scale: float) -> list[Bbox]:
    """Return the boxes [pixels] of all marks; ``scale`` is the number of pixels of a point."""
    boxes = []
    for line in axes.lines:
        if line.get_marker() in ("", "None", None):
            continue
        half = scale * (_STAR if line.get_marker() == "*" else 0.5 * line.get_markersize())
        for x, y in axes.transData.transform(np.column_stack(line.get_data())):
            boxes.append(Bbox([[x - half, y - half], [x + half, y + half]]))
    return boxes

"""Names beside the marks of a plot."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.backend_bases import RendererBase
    from matplotlib.text import Annotation
    from matplotlib.transforms import Bbox

INK: Final = "#222222"
_ROOMS: Final = (18.0, 5.0)
"""Between a name and the marks of others, in pixels: enough that it is not taken for theirs, or what will just do."""
_PLACES: Final = (
    *((10, 5, "left"), (10, -12, "left"), (-10, 5, "right"), (-10, -12, "right")),
    *((12, 24, "left"), (-12, -30, "right"), (12, -30, "left"), (-12, 24, "right")),
    *((18, 44, "left"), (-18, -50, "right"), (18, -50, "left"), (26, 64, "left"), (-26, -70, "right")),
)
"""Of a name beside its mark, in points, the best first."""


def label_points(
    axes: Axes,
    texts: Sequence[tuple[float, float, str]],
    points: Sequence[tuple[float, float]],
    renderer: RendererBase,
) -> None:
    """Names beside their marks, each at the first place around it where it covers neither marks nor other names.

    A name that finds no place is left out.

    Parameters
    ----------
    axes : Axes
        Drawn before, so that its limits are final.
    texts : sequence of (x, y, name)
    points : sequence of (x, y)
        All marks.
    renderer : RendererBase
    """
    from matplotlib.patheffects import withStroke
    from matplotlib.text import Text

    marks = [tuple(axes.transData.transform(point)) for point in points]
    frame = axes.get_window_extent(renderer)
    taken: list[Any] = [Text.get_window_extent(text, renderer) for text in axes.texts]
    for x, y, text in sorted(texts):
        own = axes.transData.transform((x, y))
        for room, (dx, dy, side) in product(_ROOMS, _PLACES):
            note = axes.annotate(
                text,
                (x, y),
                xytext=(dx, dy),
                textcoords="offset points",
                ha=side,
                fontsize=8.5,
                color=INK,
                zorder=6,
                path_effects=[withStroke(linewidth=2.5, foreground="white", alpha=0.85)],
                arrowprops={"arrowstyle": "-", "color": "#777777", "linewidth": 0.6} if abs(dy) > 12 else None,
            )
            box = _text_box(note, renderer)
            inside = frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0 and box.y1 <= frame.y1
            free = not any(box.overlaps(other) for other in taken)
            clear = not any(_is_near(box, mark, 5.0 if np.allclose(mark, own) else room) for mark in marks)
            if inside and free and clear:
                taken.append(box)
                break
            note.remove()


def _is_near(box: Bbox, mark: tuple[float, ...], room: float) -> bool:
    """Whether a mark lies on the words, or in so much room [pixels] around them."""
    return bool(box.x0 - room < mark[0] < box.x1 + room and box.y0 - room < mark[1] < box.y1 + room)


def _text_box(note: Annotation, renderer: RendererBase) -> Bbox:
    """Of the words alone, without the line to the mark."""
    from matplotlib.text import Text

    note.update_positions(renderer)
    return Text.get_window_extent(note, renderer)

"""Names beside the marks of a plot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.backend_bases import RendererBase
    from matplotlib.text import Annotation
    from matplotlib.transforms import Bbox

INK: Final = "#222222"
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

    marks = [axes.transData.transform(point) for point in points]
    frame = axes.get_window_extent(renderer)
    taken: list[Any] = [Text.get_window_extent(text, renderer) for text in axes.texts]
    for x, y, text in sorted(texts):
        for dx, dy, side in _PLACES:
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
            clear = not any(box.x0 - 5 < mx < box.x1 + 5 and box.y0 - 5 < my < box.y1 + 5 for mx, my in marks)
            if inside and free and clear:
                taken.append(box)
                break
            note.remove()


def _text_box(note: Annotation, renderer: RendererBase) -> Bbox:
    """Of the words alone, without the line to the mark."""
    from matplotlib.text import Text

    note.update_positions(renderer)
    return Text.get_window_extent(note, renderer)

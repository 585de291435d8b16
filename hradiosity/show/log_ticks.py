"""Numbers beside logarithmic axes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_STEPS: Final = (
    (0.45, (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)),
    (0.9, (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)),
    (2.6, (1.0, 2.0, 5.0)),
)
"""Ticks in each decade of an axis that is shorter than so many."""


def plain_ticks(axes: Axes, *, both: bool) -> None:
    """Numbers and not powers, at 1, 2 and 5."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    for axis in (axes.xaxis, axes.yaxis) if both else (axes.yaxis,):
        low, high = axis.get_view_interval()
        decades = math.log10(max(high, 1e-12) / max(low, 1e-12))
        steps = next((few for most, few in _STEPS if decades < most), (1.0,))
        axis.set_major_locator(LogLocator(subs=steps, numticks=20))
        axis.set_minor_locator(LogLocator(subs=[float(k) for k in range(2, 10)], numticks=50))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.grid(True, which="major", color="#e6e6e6", linewidth=0.8)
    axes.set_axisbelow(True)

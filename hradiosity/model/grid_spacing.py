"""How far apart the points of a grid lie (EN 12464-1)."""

from __future__ import annotations

from typing import Final

import numpy as np

LARGEST_SPACING: Final = 10.0
"""[m]"""
SQUARE_ENOUGH: Final = 2.0
"""Ratio of the edges of an area from which on its shorter one decides."""


def grid_spacing(length: float, width: float) -> float:
    """Largest distance of neighbouring points, p = 0.2 · 5^(log₁₀ d), 10 m at most [m].

    d is the longer edge of the area, or the shorter one where the longer is twice as long or more.
    EN 12464-1:2021, 6.2 (the formula of EN 12464-1:2011, 4.4).

    Parameters
    ----------
    length, width : float [m]

    Raises
    ------
    ValueError
        For edges that are not positive.
    """
    long, short = max(length, width), min(length, width)
    if not short > 0.0:
        raise ValueError(f"edges must be positive, are {length} and {width}")
    decisive = short if long >= SQUARE_ENOUGH * short else long
    return min(float(0.2 * 5.0 ** np.log10(decisive)), LARGEST_SPACING)


def grid_counts(length: float, width: float) -> tuple[int, int]:
    """Points along both edges: edge over spacing, to the nearest whole number, one at least.

    Along the edge that decides the spacing first; cells stay between half and twice as long as wide along the other.

    Parameters
    ----------
    length, width : float [m]

    Raises
    ------
    ValueError
        For edges that are not positive.
    """
    spacing = grid_spacing(length, width)
    long, short = max(length, width), min(length, width)
    decisive, other = (short, long) if long >= SQUARE_ENOUGH * short else (long, short)
    first = max(1, round(decisive / spacing))
    second = max(1, round(other / (decisive / first)))
    return (first, second) if decisive == length else (second, first)

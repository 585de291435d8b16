"""Discomfort glare: UGR of CIE 117-1995 from what an observer sees of each luminaire. Pure functions of arrays."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

SMALLEST, LARGEST = 3e-4, 0.1
"""Solid angles of luminaires [sr] between which UGR holds. CIE 117-1995; CIE 147-2002 for what is outside."""
SCALE: Final = 8.0
"""UGR = 8 log₁₀(0.25 / L_b · Σ L² ω / p²)."""


def position_index(gaze: NDArray[np.float64], up: NDArray[np.float64], to: NDArray[np.float64]) -> NDArray[np.float64]:
    """Guth's position index, by the formula that the table of CIE 117 is made from (IES Lighting Handbook).

    With β the angle from the line of sight and α that of the plane through both from the upright one [degrees]:
    ln p = (35.2 − 0.31889 α − 1.22 exp(−2 α / 9)) 10⁻³ β + (21 + 0.26667 α − 0.002963 α²) 10⁻⁵ β².

    Parameters
    ----------
    gaze, up : (n, 3) float64, unit, perpendicular
        Line of sight, and what is up across it.
    to : (n, 3) float64, unit
        Direction of the source.

    Returns
    -------
    (n,) float64
        NaN below the line of sight and behind the eye, which the index was not found for.
    """
    ahead, above = np.einsum("nd,nd->n", gaze, to), np.einsum("nd,nd->n", up, to)
    aside = np.abs(np.einsum("nd,nd->n", np.cross(gaze, up), to))
    beta = np.degrees(np.arctan2(np.hypot(above, aside), ahead))
    alpha = np.degrees(np.arctan2(aside, above))
    linear = (35.2 - 0.31889 * alpha - 1.22 * np.exp(-2.0 * alpha / 9.0)) * 1e-3
    square = (21.0 + 0.26667 * alpha - 0.002963 * alpha**2) * 1e-5
    valid = (ahead > 0.0) & (above >= -1e-9)
    return np.where(valid, np.exp(np.where(valid, linear * beta + square * beta**2, 0.0)), np.nan)


def glare_sum(
    luminance: NDArray[np.float64], solid_angle: NDArray[np.float64], index: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(…) L² ω / p² of each source [cd² m⁻⁴ sr]."""
    found: NDArray[np.float64] = luminance**2 * solid_angle / index**2
    return found


def unified_glare_rating(total: NDArray[np.float64], background: NDArray[np.float64]) -> NDArray[np.float64]:
    """UGR.

    Parameters
    ----------
    total : (n,) float64
        Σ L² ω / p² of the sources [cd² m⁻⁴ sr], see `glare_sum`.
    background : (n,) float64
        Background luminance [cd m⁻²]: indirect illuminance of the plane at the eye over π.

    Returns
    -------
    (n,) float64
        NaN without sources or background.
    """
    valid = (total > 0.0) & (background > 0.0)
    share = np.divide(0.25 * total, background, out=np.ones_like(total), where=valid)
    return np.where(valid, SCALE * np.log10(share), np.nan)


def rating_half_width(indirect: NDArray[np.float64], half_width: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) half width of UGR from that of the indirect illuminance: 8 / ln 10 · ΔE / E."""
    out = np.full_like(indirect, np.nan)
    np.divide(SCALE / np.log(10.0) * half_width, indirect, out=out, where=indirect > 0.0)
    return out

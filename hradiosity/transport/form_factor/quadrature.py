"""Quadrature rules that the kernels of form factors take as arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hradiosity.transport.form_factor.pairs import Pairs
from hradiosity.transport.form_factor.polygons import PolygonSet

LineRule: TypeAlias = Callable[[int], tuple[NDArray[np.float64], NDArray[np.float64]]]
"""From an order to nodes and weights on [0, 1]."""
INSET: Final = 0.003
"""Distance of the outermost nodes of `rim` from the ends."""


def gauss(order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes and weights of Gauss–Legendre quadrature on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(order)
    return 0.5 + 0.5 * x, 0.5 * w


def rim(order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes and weights on [0, 1] that integrate polynomials of degree ``order + 1``, with a node next to each end.

    Those of Gauss–Lobatto quadrature, the ends moved in a little: what happens in the rim that Gauss points leave out
    shows in the difference from them. At the very ends polygons may touch, where there is nothing to evaluate.
    """
    legendre = np.polynomial.legendre.Legendre.basis(order + 1)
    x = np.concatenate([[2.0 * INSET - 1.0], np.sort(legendre.deriv().roots().real), [1.0 - 2.0 * INSET]])
    moments = np.zeros(order + 2)
    moments[0] = 2.0
    w = np.asarray(np.linalg.solve(np.polynomial.legendre.legvander(x, order + 1).T, moments), np.float64)
    return 0.5 + 0.5 * x, 0.5 * w


def double_exponential(step: float, reach: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lower half of the double-exponential rule on [0, 1] (Takahasi & Mori 1974), symmetric about 1/2.

    ``x = 1 / (1 + exp(π sinh t))`` at multiples t of the step, so that x keeps its digits next to 0; the node 1/2
    comes first with half its weight, since kernels use each node and its mirror image. Every second node, starting
    with the first, makes the rule of twice the step when its sum is doubled. The weights are scaled so that constants
    come out exactly: what lies beyond the last node, 1e-14 of the interval, is not left out.

    Parameters
    ----------
    step : float
        In t.
    reach : float
        Largest t.
    """
    t = np.arange(0.0, reach + 0.5 * step, step)
    node = 1.0 / (1.0 + np.exp(np.pi * np.sinh(t)))
    weight = np.cosh(t) * node * (1.0 - node)
    weight[0] *= 0.5
    return node, 0.5 * weight / weight.sum()


@dataclass(frozen=True)
class SurfaceRule:
    """Weighted points on each polygon.

    point : (n, 4, p) float64: x, y, z [m], local frame, and weight [m²]; p a multiple of 4, filled with weight 0
    """

    point: NDArray[np.float64]


def receiver_arguments(pairs: Pairs, order: int, line: LineRule = gauss) -> dict[str, Any]:
    """Kernel arguments ``rule_point``, ``rule_row`` and ``n_points``: points on the first polygon of each pair."""
    chosen, row = np.unique(pairs.first, return_inverse=True)
    point = surface_rule(pairs.polygons.subset(chosen), order, line).point
    device = pairs.device
    return {
        "rule_point": device.upload(point, np.float64),
        "rule_row": device.upload(row.ravel(), np.uint32),
        "n_points": point.shape[2],
    }


def surface_rule(polygons: PolygonSet, order: int, line: LineRule = gauss) -> SurfaceRule:
    """Points that integrate polynomials of degree ``2 order - 1`` over each polygon, and those of degree 1 from one;
    with `rim` instead of `gauss`, of degree ``order + 1``.

    Polygons are cut into a fan of quadrilaterals about the first corner, with Gauss points on each, mapped bilinearly;
    a triangle is a quadrilateral with two corners in one place (Duffy's map). The map's Jacobian is linear unless they
    are parallelograms, which takes one point more a direction.
    """
    corners = polygons.corners
    k = corners.shape[1]
    if order == 1 and line is gauss:
        rows = np.concatenate([polygons.centre, polygons.area[:, None]], axis=1)
        return _padded(rows[:, None])
    node, weight = line(order if _all_parallelograms(polygons) else order + 1)
    u, v = (grid.ravel() for grid in np.meshgrid(node, node, indexing="ij"))
    share = np.outer(weight, weight).ravel()
    parts = []
    for second in range(1, k - 1, 2):
        p0, p1, p2 = corners[:, 0], corners[:, second], corners[:, second + 1]
        p3 = corners[:, min(second + 2, k - 1)]
        along_u = (p1 - p0)[:, None] * (1 - v)[:, None] + (p2 - p3)[:, None] * v[:, None]
        along_v = (p3 - p0)[:, None] * (1 - u)[:, None] + (p2 - p1)[:, None] * u[:, None]
        point = p0[:, None] + u[:, None] * (p1 - p0)[:, None] + v[:, None] * along_v
        stretch = np.einsum("npd,nd->np", np.cross(along_u, along_v), polygons.normal)
        parts.append(np.concatenate([point, (share * stretch)[..., None]], axis=2))
    return _padded(np.concatenate(parts, axis=1))


def _all_parallelograms(polygons: PolygonSet) -> bool:
    corners = polygons.corners
    if corners.shape[1] != 4:
        return False
    warp = corners[:, 0] - corners[:, 1] + corners[:, 2] - corners[:, 3]
    return bool((np.abs(warp).max(axis=1, initial=0.0) <= 1e-9 * polygons.radius).all())


def _padded(rows: NDArray[np.float64]) -> SurfaceRule:
    """From points (n, p, 4) to coordinates in front, filled up to a multiple of four points."""
    padding = np.repeat(rows[:, :1], -rows.shape[1] % 4, axis=1)
    padding[..., 3] = 0.0
    return SurfaceRule(np.ascontiguousarray(np.concatenate([rows, padding], axis=1).transpose(0, 2, 1)))

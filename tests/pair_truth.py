"""Form factors of polygons that may touch, in extended precision and without cases: slow, for stated errors."""

from itertools import pairwise

import numpy as np

Real = np.longdouble
HAS_MORE_DIGITS = np.finfo(Real).eps < 1e-18
CROWDED = np.array([1e-9, 1e-6, 1e-3, 1e-1, 0.5])
PI = Real("3.14159265358979323846264338")


def _double_exponential():
    """Nodes on [0, 1] with their distances from 1, and weights."""
    t = np.arange(-4.0, 4.0 + 1e-9, 1.0 / 16.0).astype(Real)
    growth = np.exp(PI * np.sinh(t))
    low, high = 1.0 / (1.0 + growth), 1.0 / (1.0 + 1.0 / growth)
    weight = np.cosh(t) * low * high
    return low, high, weight / weight.sum()


LOW, HIGH, WEIGHT = _double_exponential()


def form_factor_truth(a, b):
    """F from a to b, polygons that see all of each other: the contour integral, the inner one closed."""
    a, b = (np.asarray(polygon, Real) for polygon in (a, b))
    total = Real(0)
    for p in zip(a, np.roll(a, -1, axis=0)):
        for q in zip(b, np.roll(b, -1, axis=0)):
            cosine = _along(p) @ _along(q)
            total += cosine * _edges(*((p, q) if _length(p) <= _length(q) else (q, p)))
    across = np.cross(a[1:-1] - a[0], a[2:] - a[0]).sum(axis=0)
    return float(abs(total) / (PI * np.sqrt(across @ across)))


def _length(edge):
    return np.sqrt(((edge[1] - edge[0]) ** 2).sum())


def _along(edge):
    return (edge[1] - edge[0]) / _length(edge)


def _edges(short, long):
    """Double integral of ln|p - q|: double-exponential points on parts that shrink to where edges begin or pass."""
    u, v, length, other = _along(short), _along(long), _length(short), _length(long)
    apart, cosine, normal = short[0] - long[0], u @ v, np.cross(u, v)
    begin = -(apart @ u)
    squared_sine = max(normal @ normal, Real(1e-36))
    crossing = (cosine * (v @ apart) - u @ apart) / squared_sine
    places = np.unique(np.clip([Real(0), length, begin, begin + other * cosine, crossing], Real(0), length))
    total = Real(0)
    for low, high in pairwise(places):
        share = np.concatenate([[0.0], CROWDED, 1.0 - CROWDED[-2::-1], [1.0]]).astype(Real)
        cut = low + (high - low) * share
        for start, end in pairwise(cut):
            width = end - start
            s = np.where(LOW < 0.5, start + width * LOW, end - width * HIGH)
            total += width * (WEIGHT @ _inner(short[0] + s[:, None] * u, long[0], v, other))
    return total


def _inner(points, start, along, length):
    """Integral of ln|p - q| over the edge, for each point."""
    reach = start - points
    low = reach @ along
    off = np.cross(reach, along)
    squared = (off**2).sum(axis=1)
    height, high = np.sqrt(squared), low + length

    def part(x):
        r2 = squared + x * x
        return 0.5 * x * np.log(np.where(r2 > 0.0, r2, 1.0))

    return part(high) - part(low) - length + height * np.arctan2(length * height, squared + low * high)

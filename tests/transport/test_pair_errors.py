"""Stated errors of the form-factor methods on many random pairs, most of them near contact."""

import numpy as np
import pytest
from polygon_shapes import SQUARE
from scipy.spatial.transform import Rotation

from hradiosity import form_factor
from hradiosity.transport.form_factor.quadrature import INSET, rim

EACH = 24


def random_pairs(rng):
    """Plates with a gap, tilted polygons over a plate, hinges, slivers, far ones, and any that may cross horizons."""
    pairs = []
    for _ in range(EACH):

        def scale(low, high):
            return 10.0 ** rng.uniform(low, high)

        def shape():
            return SQUARE[: rng.integers(3, 5)].copy()

        def tilted(most):
            return Rotation.from_euler("xyz", rng.uniform(-most, most, 3)).as_matrix()

        def rising(degrees):
            t, height = np.radians(degrees), scale(-1.5, 0.4)
            out = height * np.array([np.cos(t), 0.0, np.sin(t)])
            return np.array([[0, 0, 0], [0, 1, 0], [0, 1, 0] + out, out])

        over = [rng.uniform(-0.5, 0.9), rng.uniform(-0.5, 0.9), scale(-4, -1)]
        beside = [rng.uniform(-1, 1), rng.uniform(-1, 1), 0.0]
        pairs += [
            (shape(), (shape() * [scale(-1.5, 0.5), scale(-1.5, 0.5), 1.0])[::-1] + over),
            (shape(), rising(rng.uniform(5, 175)) * [1.0, scale(-1.5, 0.3), 1.0] + over),
            (SQUARE, rising(rng.uniform(5, 178))),
            (shape() * [1.0, scale(-4, -1.5), 1.0], shape()[::-1] @ tilted(0.6) + beside + [0, 0, scale(-0.2, 0.2)]),
            (shape(), shape()[::-1] @ tilted(1.0) + beside + [0, 0, scale(0.5, 1.5)]),
            (shape(), shape() @ tilted(np.pi) + rng.uniform(-1.5, 1.5, 3)),
        ]
    turns = Rotation.random(len(pairs), random_state=rng).as_matrix()
    return [(a @ turn, b @ turn) for (a, b), turn in zip(pairs, turns)]


@pytest.fixture(scope="module")
def broad(device):
    """Polygons a and b, with F from a to b by the contour integral and its error."""
    a, b = zip(*random_pairs(np.random.default_rng(11)))
    exact = form_factor(a, b, method="contour", tolerance=1e-9, device=device)
    known = np.flatnonzero((exact.value > 1e-9) & (exact.error < 1e-6 * exact.value))
    assert len(known) > 4.5 * EACH
    return [a[i] for i in known], [b[i] for i in known], exact.value[known], exact.error[known]


SETTINGS = {
    "hemisphere": {},
    "hemisphere, 4 points": {"samples": 4},
    "quasi-hemisphere": {},
    "hemicube": {"resolution": 64},
    "monte-carlo": {"tolerance": 0.05},
}


@pytest.mark.parametrize("name", SETTINGS)
def test_stated_errors_hold_without_being_useless(device, broad, name):
    a, b, exact, unsure = broad
    found = form_factor(a, b, method=name.split(",")[0], device=device, **SETTINGS[name])
    off = np.abs(found.value - exact)
    assert (off <= found.error + unsure).mean() >= 0.95
    # Fixed points on smooth pairs are far better than any change of their number can tell.
    assert np.median(found.error / np.maximum(off, 1e-15 * exact)) < (25.0 if "points" in name else 12.0)


def test_monte_carlo_near_contact(device):
    """Evenly drawn points hardly ever lie opposite each other, and those that do count without bound."""
    gap = np.array([1e-1, 1e-2, 1e-3, 1e-4])
    plates = [SQUARE[::-1] + [0.0, 0.0, g] for g in gap]
    exact = form_factor(SQUARE, plates, method="contour", device=device).value
    found = form_factor(SQUARE, plates, method="monte-carlo", samples=2**14, device=device)
    np.testing.assert_allclose(found.value, exact, rtol=5e-3)
    assert (np.abs(found.value - exact) <= 2.0 * found.error).all()
    assert (found.error < 1e-2 * exact).all()


@pytest.mark.parametrize("order", [2, 3, 8, 16])
def test_rim_rule(order):
    node, weight = rim(order)
    assert node[0] == pytest.approx(INSET) and node[-1] == pytest.approx(1.0 - INSET)
    for power in range(order + 2):
        assert weight @ node**power == pytest.approx(1.0 / (power + 1), rel=1e-12)

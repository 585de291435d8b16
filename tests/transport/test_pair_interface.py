"""``hradiosity.form_factor`` and ``form_factor_matrix``: invariants, what stands between, hard geometry, bad input."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from polygon_shapes import BLOCKED, SQUARE, box_quads, facing_square, hinged_square
from scipy.spatial.transform import Rotation

import hradiosity
from hradiosity import form_factor, form_factor_matrix
from hradiosity.reference.form_factors import parallel_rectangles
from hradiosity.transport.form_factor.methods import METHODS

CEILING = facing_square(1.0)


def area(polygon):
    first = polygon[0]
    return 0.5 * np.linalg.norm(np.cross(polygon[1:-1] - first, polygon[2:] - first).sum(axis=0))


@st.composite
def convex_polygons(draw):
    """Corners on an ellipse, 3 to 7 of them, anywhere within two units."""
    n = draw(st.integers(3, 7))
    gaps = np.array(draw(st.lists(st.floats(0.2, 1.0), min_size=n, max_size=n)))
    angle = 2 * np.pi * np.cumsum(gaps) / gaps.sum()
    flat = np.stack([np.cos(angle), draw(st.floats(0.1, 1.0)) * np.sin(angle), 0 * angle], axis=1)
    turn = Rotation.from_euler("zyx", draw(st.tuples(*[st.floats(-3.1, 3.1)] * 3))).as_matrix()
    return flat @ turn.T + np.array(draw(st.tuples(*[st.floats(-2.0, 2.0)] * 3)))


@settings(max_examples=15, deadline=None)
@given(a=convex_polygons(), b=convex_polygons())
def test_bounds_and_reciprocity(device, a, b):
    """0 <= F <= 1 and A F the same both ways to the last bit, by any method."""
    for method in ("auto", "contour", "quasi-hemisphere", "point-disk", "rays"):
        samples = 256 if method == "rays" else None
        there, back = (form_factor(*ab, method=method, samples=samples, device=device) for ab in ((a, b), (b, a)))
        assert 0.0 <= there.value <= 1.0 and there.error >= 0.0
        assert there.value * area(a) == pytest.approx(back.value * area(b), rel=1e-12)


@settings(max_examples=40, deadline=None)
@given(
    a=convex_polygons(),
    b=convex_polygons(),
    turn=st.tuples(*[st.floats(-3.1, 3.1)] * 3),
    shift=st.tuples(*[st.floats(-5.0, 5.0)] * 3),
    scale=st.sampled_from([1e-3, 1.0, 1e3]),
)
def test_moving_turning_and_scaling_change_nothing(device, a, b, turn, shift, scale):
    before = form_factor(a, b, method="contour", device=device)
    moved = [scale * (p @ Rotation.from_euler("zyx", turn).as_matrix().T + shift) for p in (a, b)]
    after = form_factor(*moved, method="contour", device=device)
    assert after.value == pytest.approx(before.value, rel=1e-9, abs=1e-12 + 2.0 * before.error)


@settings(max_examples=40, deadline=None)
@given(a=convex_polygons(), b=convex_polygons(), share=st.floats(0.1, 0.9))
def test_parts_add_up(device, a, b, share):
    """b is cut from its first corner to a point on the opposite edge."""
    k = len(b) // 2
    cut = b[k] + share * (b[(k + 1) % len(b)] - b[k])
    parts = [np.vstack([b[: k + 1], cut]), np.vstack([b[0], cut, b[k + 1 :]])]
    whole = form_factor(a, b, method="contour", device=device)
    found = form_factor(a, parts, method="contour", device=device)
    assert found.value.sum() == pytest.approx(whole.value, rel=1e-9, abs=1e-13 + 2.0 * whole.error)


def test_matrix_is_all_pairs(device):
    """Half of the pairs, but every number."""
    quads = box_quads(2, (2.0, 1.0, 0.7))
    matrix = form_factor_matrix(quads, method="contour", device=device)
    rows, columns = (index.ravel() for index in np.indices(matrix.value.shape))
    pairs = form_factor(quads[rows], quads[columns], method="contour", device=device)
    np.testing.assert_allclose(matrix.value.ravel(), pairs.value, rtol=1e-13)
    assert (matrix.method.ravel() == pairs.method).all() and (np.diag(matrix.value) == 0.0).all()


@pytest.mark.parametrize("method", METHODS)
def test_any_method_takes_any_polygons(device, method):
    """Triangle, square and hexagon in one call, a single number for a single pair."""
    hexagon = [[np.cos(t), np.sin(t), 2.0] for t in -np.pi / 3 * np.arange(6)]
    found = form_factor(
        SQUARE[:3], [hexagon, facing_square(1.5), SQUARE[2::-1] + [0, 0, 2.0]], method=method, device=device
    )
    assert found.value.shape == found.error.shape == found.visibility.shape == found.method.shape == (3,)
    exact = form_factor(
        SQUARE[:3], [hexagon, facing_square(1.5), SQUARE[2::-1] + [0, 0, 2.0]], method="contour", device=device
    )
    # Half widths hold 95 % of the time; twice as much, nearly always.
    assert (np.abs(found.value - exact.value) <= 2.0 * found.error + 1e-12).all()
    single = form_factor(SQUARE, CEILING, method=method, device=device)
    assert isinstance(single.value, float) and isinstance(single.method, str)


def card(side, height):
    return SQUARE * side + [0.5 - side / 2, 0.5 - side / 2, height]


def test_a_card_between_squares_counts_in_part(device):
    """Neither the 0 nor the 0.1998 that a single answer for the pair would give."""
    found = form_factor(SQUARE, CEILING, occluders=card(0.1, 0.5), visibility_tolerance=5e-4, device=device)
    assert found.value == pytest.approx(0.19453, abs=2e-4)
    assert found.error < 2e-4 and found.visibility == pytest.approx(0.9735, abs=1e-3)


@pytest.mark.parametrize(("name", "gap", "side"), [("B01", 1.0, 0.5), ("B03", 0.5, 0.75), ("B04", 2.0, 1.0)])
@pytest.mark.parametrize("method", ["auto", "hemicube", "rays"])
def test_blocked_pairs_of_the_catalogue(device, name, gap, side, method):
    found = form_factor(
        SQUARE,
        facing_square(gap),
        occluders=card(side, gap / 2),
        method=method,
        visibility_tolerance=2e-3,
        device=device,
    )
    assert found.value == pytest.approx(BLOCKED[name], abs=max(2.0 * found.error, 1e-15))
    assert found.error < 6e-3 * parallel_rectangles(1, 1, gap) + (2e-2 if method == "hemicube" else 5e-3)


def test_walls_of_a_convex_room_hide_nothing(device):
    """All polygons are occluders too; for each pair it is proved that none is in the way."""
    quads = box_quads(3)
    found = form_factor_matrix(quads, occluders=quads, method="contour", device=device)
    assert (found.visibility == 1.0).all()
    np.testing.assert_allclose(found.value.sum(axis=1), 1.0, atol=1e-12)


def test_room_with_a_block_closes(device):
    """What the block takes from the walls, it gets itself: rows of floor, walls and block add up to 1."""
    room = box_quads(1, (3.0, 3.0, 2.0))
    block = box_quads(1, (1.0, 1.0, 0.8))[:, ::-1] + [1.0, 1.0, 0.6]
    together = np.concatenate([room, block])
    found = form_factor_matrix(together, occluders=together, visibility_tolerance=2e-3, device=device)
    assert (np.abs(found.value.sum(axis=1) - 1.0) < found.error.sum(axis=1)).all()
    np.testing.assert_allclose(found.value.sum(axis=1), 1.0, atol=4e-3)
    assert found.visibility.min() < 0.9 and (found.value[6:, 6:] == 0.0).all()


def test_what_stands_beside_is_proved_open(device):
    beside = [card(0.4, 0.5) + [1.2, 0, 0], SQUARE - [0, 0, 0.5], CEILING + [0, 0, 0.1]]
    found = form_factor(SQUARE, CEILING, occluders=beside, method="contour", device=device)
    assert found.visibility == 1.0
    assert found.value == pytest.approx(parallel_rectangles(1, 1, 1), rel=1e-13)


HARD = {
    "same facing, coincident": (SQUARE, SQUARE, 0.0),
    "opposite facing, coincident": (SQUARE, SQUARE[::-1], 0.0),
    "coplanar, overlapping": (SQUARE, SQUARE + [0.3, 0.2, 0.0], 0.0),
    "wholly behind": (SQUARE, hinged_square(90.0) - [0, 0, 1.0], 0.0),
    "one corner in common": (SQUARE, np.array([[1, 1, 0], [1, 1, 1], [1, 2, 1], [1, 2, 0.0]]), 0.040592230101558542583),
    "half behind": (SQUARE, hinged_square(90.0) * [1, 1, 2.0] - [0, 0, 1.0], 0.5 * 0.40008755215080629),
    "screw in a hall": (1e-4 * SQUARE, 100.0 * facing_square(0.5), 0.20775756986),
}


@pytest.mark.parametrize("name", HARD)
def test_hard_pairs(device, name):
    a, b, exact = HARD[name]
    if name == "half behind":
        exact = form_factor(SQUARE, hinged_square(90.0), method="contour", device=device).value
    if name == "screw in a hall":
        # A point below a corner (Howell B-4); the screw is half its width, 1e-6 of the distance, off that.
        x = 100.0 / 50.0
        exact = x / np.sqrt(1 + x * x) * np.arctan(x / np.sqrt(1 + x * x)) / np.pi
    for method in ("auto", "contour"):
        found = form_factor(a, b, method=method, device=device)
        assert found.value == pytest.approx(exact, rel=3e-6, abs=0.0)


@pytest.mark.parametrize("width", [1e-3, 1e-6])
def test_slivers(device, width):
    """Two strips facing at distance 1: the kernel changes by width², so that one strip of no width gives the factor."""
    strip = SQUARE * [1, width, 1]
    wide = form_factor(SQUARE * [1, 1e-2, 1], facing_square(1.0) * [1, 1e-2, 1], method="contour", device=device).value
    found = form_factor(strip, strip[::-1] + [0, 0, 1.0], method="contour", device=device)
    assert found.value == pytest.approx(wide * width / 1e-2, rel=1e-4)
    assert found.error < 1e-5 * found.value


@pytest.mark.parametrize("scale", [1e-3, 1.0])
def test_far_from_the_origin(device, scale):
    """A million metres away only the rounding of the input itself is left."""
    far = np.array([1e6, -2e6, 3e6])
    for a, b in ((SQUARE, CEILING), (SQUARE, hinged_square(120.0))):
        near = form_factor(a, b, method="contour", device=device).value
        found = form_factor(scale * a + far, scale * b + far, method="contour", device=device).value
        assert found == pytest.approx(near, rel=2e-9 / scale)


BAD = {
    "has 2": SQUARE[:2],
    "not plane": SQUARE + np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0.1], [0, 0, 0]]),
    "not convex": [[0, 0, 0], [1, 0, 0], [0.2, 0.2, 0], [0, 1, 0]],
    "no area": [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
    "edges cross": SQUARE[[0, 2, 1, 3]],
    "finite": SQUARE * np.nan,
    "has 33": [[np.cos(t), np.sin(t), 0] for t in np.linspace(0, 6, 33)],
    "shape": SQUARE[:, :2],
    "three numbers": "abc",
}


@pytest.mark.parametrize("why", BAD)
def test_bad_polygons_are_named(device, why):
    with pytest.raises(ValueError, match=rf"polygon_b.*{why}"):
        form_factor(SQUARE, BAD[why], device=device)
    if why != "three numbers":
        with pytest.raises(ValueError, match=rf"polygons\[1\].*{why}"):
            form_factor_matrix([SQUARE, BAD[why]], device=device)


def test_bad_arguments(device):
    wrong = [
        ({"method": "magic"}, "method"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"samples": 0}, "samples"),
        ({"sequence": "halton"}, "sequence"),
        ({"method": "hemicube", "resolution": 9}, "even"),
        ({"visibility_tolerance": -1.0, "occluders": SQUARE}, "visibility_tolerance"),
    ]
    for options, message in wrong:
        with pytest.raises(ValueError, match=message):
            form_factor(SQUARE, CEILING, device=device, **options)
    with pytest.raises(ValueError, match="2 polygons a and 3 polygons b"):
        form_factor([SQUARE] * 2, [CEILING] * 3, device=device)


def test_public_names():
    assert hradiosity.form_factor is form_factor and "form_factor_matrix" in dir(hradiosity)

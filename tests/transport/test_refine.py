"""Direct light on leaves against closed forms of a card's shadow."""

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.cell_lookup import cell_frames, locate_cells
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.leaf_fan import fan_weights
from hradiosity.space.leaf_vertices import find_rims
from hradiosity.space.leaves import plant_leaves, split_leaves
from hradiosity.transport.device_scene import upload_scene
from hradiosity.transport.leaf_error import LeafErrors
from hradiosity.transport.leaf_light import VertexLight
from hradiosity.transport.refine import RefinementGoal, RefinementOptions, refine_shadows, united

LAMP_HEIGHT, CARD_HEIGHT = 2.0, 1.0
CARD = (-0.23, 0.31, -0.17, 0.28)
LAMP = (-0.2, 0.2, -0.2, 0.2)


def card_scene(*, point):
    """A floor of 2 m x 2 m, a card in the air, and a lamp above: a point or a square that shines downwards."""
    b = SceneBuilder()
    grey = b.material(0.5)
    b.patch((-1, -1, 0), (2, 0, 0), (0, 2, 0), grey)
    x0, x1, y0, y1 = CARD
    b.patch((x0, y0, CARD_HEIGHT), (x1 - x0, 0, 0), (0, y1 - y0, 0), grey)
    if point:
        b.point((0, 0, LAMP_HEIGHT), 1.0)
    else:
        x0, x1, y0, y1 = LAMP
        b.lamp(b.patch((x0, y0, LAMP_HEIGHT), (0, y1 - y0, 0), (x1 - x0, 0, 0), grey), 1.0)
    return b.scene()


def refined(device, scene, size=0.25, finest=1e-6, reference=0.2, **options):
    """Leaves of the floor; `reference` is the irradiance that tolerances refer to."""
    elements = build_elements(
        scene.patches, np.ones((len(scene.patches), 2), bool), np.ones(1, bool), size, grouping=False
    )
    frames = cell_frames(elements, scene.patches.is_triangle)
    wanted = np.where(frames.side == 0, finest, np.inf)
    rims = find_rims(scene.patches, np.zeros((len(scene.patches), 2), np.int64))
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    lux = np.full(len(wanted), reference * luminous_weights(scene.bands)[0])
    goal = RefinementGoal(frames, rims, elements.divisions.astype(np.int64), wanted, lux)
    shadow = refine_shadows(on_device, scene, goal, RefinementOptions(**options))
    return elements, shadow


def interpolated(scene, elements, shadow, points):
    """Irradiance on the floor at (n, 2) points."""
    u, v = ((points + 1) / 2).T.astype(np.float32)
    side = np.zeros(len(points), np.int64)
    cell, s, t = locate_cells(elements, scene.patches.is_triangle, side, u, v)
    node, s, t = shadow.leaves.locate(cell, s, t)
    ids, weights = fan_weights(shadow.vertex, node, s, t, np.zeros(len(points), bool))
    assert (ids >= 0).all()
    return (weights * shadow.per_luminaire[ids, 0]).sum(axis=1)


def grid_points(n=300):
    steps = 2 * (np.arange(n) + 0.5) / n - 1
    return np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)


def corner_factor(x, y, h):
    """Form factor of a floor point to the rectangle 0..x by 0..y at height h, signed. [Howell, configuration B-4]"""
    a, b = np.hypot(x, h), np.hypot(y, h)
    return (x / a * np.arctan(y / a) + y / b * np.arctan(x / b)) / (2 * np.pi)


def rectangle_factor(points, x0, x1, y0, y1):
    px, py = points.T
    return sum(
        sign * corner_factor(x - px, y - py, LAMP_HEIGHT)
        for x, y, sign in ((x1, y1, 1), (x0, y1, -1), (x1, y0, -1), (x0, y0, 1))
    )


def exact_soft(points):
    """The lamp less the part that the card hides: its shadow on the lamp's plane, seen from the point."""
    bounds = []
    for axis in range(2):
        p = points[:, axis]
        low, high = (p + (c - p) * LAMP_HEIGHT / CARD_HEIGHT for c in CARD[2 * axis : 2 * axis + 2])
        bounds += [np.clip(low, *LAMP[2 * axis : 2 * axis + 2]), np.clip(high, *LAMP[2 * axis : 2 * axis + 2])]
    return rectangle_factor(points, *LAMP) - rectangle_factor(points, *bounds)


def exact_hard(points):
    low, high = np.array([CARD[0], CARD[2]]), np.array([CARD[1], CARD[3]])
    factor = LAMP_HEIGHT / (LAMP_HEIGHT - CARD_HEIGHT)
    hidden = ((points > factor * low) & (points < factor * high)).all(axis=1)
    distance = np.sqrt((points**2).sum(axis=1) + LAMP_HEIGHT**2)
    return np.where(hidden, 0, LAMP_HEIGHT / distance**3)


def error_of(device, scene, exact, **options):
    points = grid_points()
    elements, shadow = refined(device, scene, reference=exact(points).mean(), **options)
    error = np.abs(interpolated(scene, elements, shadow, points) - exact(points)).mean() / exact(points).mean()
    return error, int(shadow.leaves.is_leaf.sum())


def test_hard_shadow_converges_like_the_size_of_the_leaves(device):
    """Only leaves on the shadow's edge are wrong, and their area halves with each level."""
    scene = card_scene(point=True)
    errors, leaves = zip(*(error_of(device, scene, exact_hard, base_level=0, max_level=k) for k in range(2, 6)))
    rates = -np.diff(np.log2(errors))
    print("error", np.round(errors, 5), "leaves", leaves)
    assert rates.mean() > 0.8
    assert errors[-1] < 0.006


def test_hard_shadow_needs_far_fewer_leaves_than_uniform_cutting(device):
    """The edge has twice as many leaves a level further, uniform cutting four times as many everywhere."""
    scene = card_scene(point=True)
    adaptive, few = error_of(device, scene, exact_hard, base_level=0, max_level=5, tolerance=0.002)
    uniform, many = error_of(device, scene, exact_hard, base_level=5, max_level=5)
    coarse, about_as_few = error_of(device, scene, exact_hard, base_level=3, max_level=3)
    print(f"adaptive {adaptive:.5f} with {few}, uniform {uniform:.5f} with {many}, {coarse:.5f} with {about_as_few}")
    assert few < 0.1 * many and adaptive < 1.3 * uniform
    assert few < 1.6 * about_as_few and adaptive < 0.2 * coarse


@pytest.mark.parametrize(("point", "exact"), [(False, exact_soft), (True, exact_hard)], ids=["soft", "hard"])
def test_leaves_follow_the_error_that_is_asked_for(device, point, exact):
    """The map is as good as asked for, with a third to a fifth of the leaves that uniform cutting takes."""
    scene, points = card_scene(point=point), grid_points()
    mean = exact(points).mean()

    def rms(**options):
        elements, shadow = refined(device, scene, reference=mean, **options)
        error = interpolated(scene, elements, shadow, points) - exact(points)
        return np.sqrt((error**2).mean()) / mean, int(shadow.leaves.is_leaf.sum())

    wanted, level, fewer = (0.05, 4, 5) if point else (0.0045, 3, 3)
    error, few = rms(base_level=0, max_level=7, error=wanted)
    uniform, many = rms(base_level=level, max_level=level, light_samples=256)
    print(f"adaptive {error:.5f} with {few}, uniform {uniform:.5f} with {many}")
    assert error < 1.3 * wanted
    assert error < uniform and fewer * few < many


def test_soft_shadow_is_the_closed_form(device):
    """Sampling noise of 1024 rays and interpolation in leaves of 16 mm together."""
    error, _ = error_of(
        device, card_scene(point=False), exact_soft, base_level=1, max_level=4, tolerance=0.005, light_samples=512
    )
    print("soft", error)
    assert error < 0.002


def test_smooth_light_is_not_refined(device):
    """Without the card's contrast there is little to gain: at a loose tolerance cells stay whole."""
    b = SceneBuilder()
    b.patch((-1, -1, 0), (2, 0, 0), (0, 2, 0), b.material(0.5))
    b.point((0, 0, LAMP_HEIGHT), 1.0)
    _, shadow = refined(device, b.scene(), base_level=0, tolerance=0.1)
    assert (shadow.leaves.level == 0).all()


def test_neighbours_differ_by_one_level_at_most(device):
    elements, shadow = refined(device, card_scene(point=True), base_level=0, max_level=5)
    leaves = shadow.leaves
    n = 32 * int(elements.divisions[0, 0])
    level = np.zeros((n, n), int)
    for node in np.flatnonzero(leaves.is_leaf):
        (x, y), extent = leaves.corner[node] // 6, leaves.extent[node] // 6
        level[x : x + extent, y : y + extent] = leaves.level[node]
    assert max(np.abs(np.diff(level, axis=a)).max() for a in (0, 1)) == 1
    middles = shadow.vertex[leaves.is_leaf][:, 5:]
    assert (middles >= 0).any()


def test_leaves_are_not_smaller_than_wanted(device):
    _, shadow = refined(device, card_scene(point=True), finest=0.1, base_level=0, max_level=5)
    assert shadow.leaves.level.max() == 2


def test_vertices_inside_solids_are_covered(device):
    b = SceneBuilder()
    grey = b.material(0.5)
    b.patch((-1, -1, 0), (2, 0, 0), (0, 2, 0), grey)
    b.box((-0.31, -0.27, 0), (0.33, 0.29, 0.5), grey, solid=True)
    b.point((0, 0.9, LAMP_HEIGHT), 1.0)
    scene = b.scene()
    elements, shadow = refined(device, scene, base_level=1, max_level=3)
    nodes = np.flatnonzero(shadow.leaves.is_leaf)
    place = shadow.leaves.places(nodes)[:, 0] / (shadow.leaves.step * elements.divisions[0]) * 2 - 1
    inside = (np.abs(place - [0.01, 0.01]) < [0.32, 0.28]).all(axis=1)
    np.testing.assert_array_equal(shadow.covered[shadow.vertex[nodes, 0]], inside)


@pytest.mark.parametrize(
    "wrong",
    [{"tolerance": 0.0}, {"contrast": -1.0}, {"base_level": 3, "max_level": 2}, {"light_samples": 0}, {"error": 0.0}],
)
def test_options_are_checked(wrong):
    with pytest.raises(ValueError):
        RefinementOptions(**wrong)


def planted(device, max_level=4):
    """Two cells of a floor, and vertices that tell which of their points are one."""
    b = SceneBuilder()
    b.patch((0, 0, 0), (2, 0, 0), (0, 1, 0), b.material(0.5))
    scene = b.scene()
    elements = build_elements(scene.patches, np.ones((1, 2), bool), np.ones(1, bool), 1.0, grouping=False)
    frames = cell_frames(elements, scene.patches.is_triangle)
    rims = find_rims(scene.patches, np.zeros((1, 2), np.int64))
    size = np.where(frames.side == 0, 1e-3, np.inf)
    goal = RefinementGoal(frames, rims, elements.divisions.astype(np.int64), size, np.ones(len(size)))
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=False)
    vertices = VertexLight(on_device, scene, goal, RefinementOptions(max_level=max_level))
    return plant_leaves(frames, np.isfinite(size), max_level), vertices


def test_united_leaves_are_as_fine_as_the_finer_of_both(device):
    leaves, vertices = planted(device)
    one = split_leaves(leaves, [0])
    one = split_leaves(one, [one.first_child[0]])
    other = split_leaves(leaves, [1])
    other = split_leaves(other, [other.first_child[1] + 3])
    both = united(one, other, vertices)
    assert united(both, other, vertices).n_nodes == both.n_nodes
    rng = np.random.default_rng(3)
    cell = rng.integers(0, 2, 500)
    s, t = rng.random((2, 500), np.float32)
    levels = [tree.level[tree.locate(cell, s, t)[0]] for tree in (one, other, both)]
    assert (levels[2] >= np.maximum(levels[0], levels[1])).all()
    area = 0.25 ** both.level[both.is_leaf].astype(float)
    assert area.sum() == pytest.approx(len(leaves.cell))


def test_noise_of_the_light_is_no_reason_to_split(device):
    leaves, _ = planted(device)
    whole = len(leaves.cell)
    rng = np.random.default_rng(1)
    leaves = split_leaves(leaves, np.arange(whole))
    bend = np.array([0.0, 0.0, 0.0, 0.0, 1.0])
    noise = 0.05 * rng.standard_normal((leaves.n_nodes, 5))
    children = np.arange(whole, leaves.n_nodes)
    for height, low, high in ((0.0, 0.0, 0.03), (1.0, 0.3, 0.7)):
        light = noise + height * bend
        errors = LeafErrors()
        errors.add(leaves, light, np.full_like(light, 0.05**2), np.ones(light.shape, bool))
        assert low <= np.sqrt((errors.of(children) ** 2).mean()) <= high

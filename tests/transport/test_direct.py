"""Direct light: closed forms with and without obstacles, at points and on elements."""

import numpy as np
import pytest
from rooms import SceneBuilder, cube

from hradiosity.reference.form_factors import polygon_pair
from hradiosity.reference.point_factors import points_to_polygon
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.direct import direct_at_points, direct_on_rows
from hradiosity.transport.exchange import trace_rows

UP, DOWN = np.array([0.0, 0, 1]), np.array([0.0, 0, -1])


def at_points(device, builder, position, normal, samples=64, seed=1, occlusion=True):
    """(n, n_emitters) factors at points."""
    scene = builder.scene()
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=occlusion)
    position = np.atleast_2d(np.asarray(position, float))
    return direct_at_points(on_device, position, np.broadcast_to(normal, position.shape), samples, seed)


def on_rows(device, builder, size, points=64, seed=1):
    """Elements and (n_rows, n_emitters) factors."""
    scene = builder.scene()
    bvh = build_bvh(device, scene.patches)
    space = find_lit_sides(scene, bvh).space
    elements = build_elements(scene.patches, space, np.array([m.two_sided for m in scene.materials]), size)
    on_device, uploaded = upload_scene(device, scene, bvh, occlusion=True), upload_elements(device, elements)
    hits = trace_rows(on_device, uploaded, max(64, points), seed)
    return elements, direct_on_rows(on_device, uploaded, hits, points, seed)


def lamp_and_floor(lamp_size=1.0, height=2.0):
    """A lamp facing down over a floor of 10 m; corners of the lamp in order, seen from below."""
    b = SceneBuilder()
    material = b.material(0.5)
    b.patch((-5, -5, 0), (10, 0, 0), (0, 10, 0), material)
    h = lamp_size / 2
    lamp = b.patch((-h, -h, height), (0, lamp_size, 0), (lamp_size, 0, 0), material)
    b.lamp(lamp, 1.0)
    return b, np.array([[-h, -h, height], [-h, h, height], [h, h, height], [h, -h, height]])


def test_point_source_falls_with_the_square_of_the_distance(device):
    b = SceneBuilder()
    b.patch((-50, -50, -30), (100, 0, 0), (0, 100, 0), b.material(0.5))
    b.point((0.5, 0.25, 1.0), 3.0)
    offsets = np.array([[0, 0, 1], [0, 0, 10], [1, 2, 2], [-3, 0, 4], [0, 5, 0], [1, 1, -1.0]])
    found = at_points(device, b, [0.5, 0.25, 1.0] - offsets, UP)[:, 0]
    expected = np.maximum(offsets[:, 2], 0) / np.linalg.norm(offsets, axis=1) ** 3
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-12)


def test_unobstructed_area_lamp_is_lamberts_formula(device):
    b, lamp = lamp_and_floor()
    points = np.random.default_rng(0).uniform([-4, -4, 0.01], [4, 4, 1.9], (200, 3))
    found = at_points(device, b, points, UP)[:, 0]
    np.testing.assert_allclose(found, points_to_polygon(points, np.tile(UP, (200, 1)), lamp), rtol=3e-6, atol=1e-7)
    assert (at_points(device, b, points + 3 * UP, DOWN) == 0).all()


def test_one_sided_lamp_is_dark_behind_and_two_sided_is_not(device):
    for two_sided in (False, True):
        b, lamp = lamp_and_floor()
        b.luminaires.clear()
        b.emitters.clear()
        b.lamp(1, 1.0, two_sided=two_sided)
        above = np.array([[0.1, 0.2, 3.0], [2.0, 0.0, 2.5]])
        expected = points_to_polygon(above, np.tile(DOWN, (2, 1)), lamp) if two_sided else 0.0
        np.testing.assert_allclose(at_points(device, b, above, DOWN)[:, 0], expected, rtol=5e-6)
        assert at_points(device, b, [[0.1, 0.2, 1.0]], UP)[0, 0] > 0.1


def card_scene():
    """A card half way hides x < 0 of the lamp from the point below its edge."""
    b, lamp = lamp_and_floor()
    b.patch((-3, -3, 1), (3, 0, 0), (0, 6, 0), b.material(0.2))
    half = lamp.copy()
    half[:, 0] = np.maximum(half[:, 0], 0)
    return b, half


@pytest.mark.parametrize("samples", [64, 1024])
def test_card_that_hides_half_of_the_lamp(device, samples):
    """The visible part by clipping; mean over seeds within 4 standard errors, spread falling with the samples."""
    b, half = card_scene()
    points = np.array([[0.0, 0.0, 0.01], [0.0, 0.4, 0.5]])
    exact = points_to_polygon(points, np.tile(UP, (2, 1)), half)
    found = np.array([at_points(device, b, points, UP, samples, seed)[:, 0] for seed in range(24)])
    error = found.std(axis=0, ddof=1) / np.sqrt(24)
    assert (np.abs(found.mean(axis=0) - exact) < 4 * error + 2e-3 * exact / samples).all()
    assert (found.std(axis=0) < exact * 1.5 / samples**0.75).all()


def test_behind_a_wall_is_exactly_dark_and_before_it_exactly_bright(device):
    b, lamp = lamp_and_floor()
    b.patch((-3, -3, 1), (6, 0, 0), (0, 6, 0), b.material(0.2))
    points = np.random.default_rng(1).uniform([-0.5, -0.5, 0.01], [0.5, 0.5, 0.9], (500, 3))
    assert (at_points(device, b, points, UP, 16) == 0).all()
    above = points + 1.05 * UP
    np.testing.assert_allclose(
        at_points(device, b, above, UP, 16)[:, 0], points_to_polygon(above, np.tile(UP, (500, 1)), lamp), rtol=1e-5
    )


def test_a_reading_on_a_surface_is_not_shaded_by_it(device):
    b, lamp = lamp_and_floor()
    points = np.random.default_rng(2).uniform([-4, -4, 0], [4, 4, 0], (200, 3))
    found = at_points(device, b, points, UP, 16)[:, 0]
    np.testing.assert_allclose(found, points_to_polygon(points, np.tile(UP, (200, 1)), lamp), rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("size", [20.0, 2.0])
def test_mean_over_elements_is_the_form_factor_of_the_pair(device, size):
    b, lamp = lamp_and_floor()
    elements, direct = on_rows(device, b, size, 256)
    floor = elements.cell_side[elements.row_cell[elements.row_start[:-1]]] == 0
    received = elements.area[floor] @ direct[floor, 0]
    corners = np.array([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0.0]])
    assert received == pytest.approx(polygon_pair(lamp, corners), rel=2e-2 if size > 10 else 2e-3)


@pytest.mark.parametrize("points", [1, 2, 4])
def test_all_light_of_a_lamp_above_slats_lands_somewhere(device, points):
    """In a closed room all elements together receive what the lamp sends out, however few points each of them has."""
    b = cube(0.5, side=2.0)
    material = b.material(0.5)
    b.lamp(b.patch((0.5, 0.5, 1.9), (0, 1, 0), (1, 0, 0), material), 1.0)
    for at in np.linspace(0.5, 1.5, 6):
        b.patch((at, 0.5, 1.6), (0, 1, 0), (0, 0, 0.2), material)
        b.patch((0.5, at, 1.6), (1, 0, 0), (0, 0, 0.2), material)
    received = []
    for seed in range(32):
        elements, direct = on_rows(device, b, 0.25, points, seed)
        received.append(elements.area @ direct[:, 0])
    error = np.std(received, ddof=1) / np.sqrt(len(received))
    assert error < 0.025
    assert np.mean(received) == pytest.approx(1.0, abs=4.0 * error)


def test_point_source_over_a_half_shaded_element(device):
    """A card hides the brighter part of the floor: visibility must be weighed by what each ray brings.

    Irradiance of the floor of half width a below a source at height 1, outside of the shadow |x|, |y| < 1:
    its mean is (Ω(a) − Ω(1)) / 4a² with Ω(a) = 4 asin(a² / (1 + a²)), the solid angle of the square.
    """
    b = SceneBuilder()
    material = b.material(0.5)
    a = 3.0
    b.patch((-a, -a, 0), (2 * a, 0, 0), (0, 2 * a, 0), material)
    b.patch((-0.5, -0.5, 0.5), (1, 0, 0), (0, 1, 0), material)
    b.point((0, 0, 1), 1.0)

    def solid_angle(half):
        return 4 * np.arcsin(half**2 / (1 + half**2))

    exact = (solid_angle(a) - solid_angle(1.0)) / (4 * a * a)
    found = []
    for seed in range(8):
        elements, direct = on_rows(device, b, 100.0, 1024, seed)
        rows = elements.cell_side[elements.row_cell[elements.row_start[:-1]]]
        found.append(direct[rows == 0, 0][0])
    assert np.mean(found) == pytest.approx(exact, rel=0.02)


def exposed_factor(low, high):
    """Mean factor to the ceiling of a unit cube over the floor outside of a rectangle."""

    def to_ceiling(x0, y0, x1, y1):
        ceiling = np.array([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1.0]])
        floor = np.array([[x0, y0, 0], [x1, y0, 0], [x1, y1, 0], [x0, y1, 0.0]])
        return (x1 - x0) * (y1 - y0) * polygon_pair(floor, ceiling)

    covered = (high[0] - low[0]) * (high[1] - low[1])
    return (to_ceiling(0, 0, 1, 1) - to_ceiling(*low, *high)) / (1 - covered)


@pytest.mark.parametrize(("low", "high"), [((0.2, 0.2), (0.7, 0.8)), ((0.0, 0.0), (0.5, 1.0))])
def test_covered_parts_receive_nothing_and_count_for_nothing(device, low, high):
    """A low solid block on the floor: the mean is over the part that it leaves free."""
    b = cube()
    b.lamp(5, 1.0)
    b.box((*low, 0), (*high, 2e-3), b.material(0.0), solid=True)
    elements, direct = on_rows(device, b, 100.0, 2048)
    rows = elements.cell_side[elements.row_cell[elements.row_start[:-1]]]
    assert direct[rows == 8, 0][0] == pytest.approx(exposed_factor(low, high), rel=5e-3)


def test_no_emitters_and_no_points(device):
    assert at_points(device, cube(), [[0.5, 0.5, 0.5]], UP).shape == (1, 0)
    b, _ = lamp_and_floor()
    assert at_points(device, b, np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 1)


@pytest.mark.parametrize("distance", [0.6, 8.0])
@pytest.mark.parametrize("seen", [False, True])
def test_a_ray_by_chance_has_no_bias_whatever_the_lamp_is_taken_for(device, distance, seen):
    """Near and far lamp, half hidden by an edge; open ones have no noise when taken for seen, hidden ones else."""
    b, _ = lamp_and_floor(height=distance)
    b.patch((0.05, -3, 0.5 * distance), (0, 6, 0), (3, 0, 0), b.material(0.5))
    scene = b.scene()
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    n = 4096
    position = np.repeat([(0.1, 0.0, 0.0), (-2.0, 0.0, 0.0), (1.5, 0.0, 0.0)], n, axis=0)
    normal = np.broadcast_to(UP, position.shape)
    few = {"n_samples": np.full((3 * n, 1), 0.25), "seen": np.full((3 * n, 1), seen)}
    found = direct_at_points(on_device, position, normal, seed=3, **few)[:, 0].reshape(3, n).astype(float)
    truth = direct_at_points(on_device, position[::n], UP[None].repeat(3, axis=0), 4096, 1)[:, 0]
    error = found.std(axis=1, ddof=1) / np.sqrt(n)
    assert (np.abs(found.mean(axis=1) - truth) <= 4.0 * error + 1e-3 * truth).all()
    assert truth[2] == 0.0 and truth[0] > 0.0 and error[0] > 0.0
    assert error[1 if seen else 2] == 0.0 and error[2 if seen else 1] > 0.0

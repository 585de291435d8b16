"""Colours in the window are those of the pictures."""

from dataclasses import replace

import numpy as np
import pytest

from hradiosity.io.drawn_scene import Cells, Light
from hradiosity.io.results_reading import read_result
from hradiosity.io.scene_drawing import draw_scene
from hradiosity.metrics.colorimetric import encode_srgb, xyz_to_linear_srgb
from hradiosity.show.channels import paint_colours
from hradiosity.show.colormap import colours_of
from hradiosity.show.exposure import to_bytes
from hradiosity.show.preview import Preview
from hradiosity.show.scale_bar import Scale
from hradiosity.show.window.colours import LightValues
from hradiosity.show.window.look import MODES, Look
from hradiosity.show.window.navigation import pose_of_view
from hradiosity.show.window.picking import pick_cell
from hradiosity.show.window.seams import level_seams
from hradiosity.show.window.subject import GAMUT_MARK, Choices, Subject
from hradiosity.show.window.vertices import corner_means, shared_corners


def test_cells_have_the_colours_of_the_run_s_preview(solved, device):
    """Pixel by pixel: the preview finds what it shows with rays on the device, the window with its own."""
    solution, folder = solved
    view = solution.scene.views[0]
    preview = Preview(solution.scene, device, view)
    expected = preview.pixels(solution)
    subject = Subject(read_result(folder), Choices(white_luminance=preview.white_luminance))
    colours = subject.paint(Look(mode="flat")).colours
    pose = pose_of_view(view, view.width / view.height, 1.0)
    x, y = np.meshgrid(np.arange(2, view.width, 5) + 0.5, np.arange(2, view.height, 5) + 0.5)
    rays = pose.rays(x.ravel(), view.height - y.ravel(), view.width, view.height)
    wrong = 0
    for row, column, ray in zip(y.ravel(), x.ravel(), rays, strict=True):
        cell, _ = pick_cell(subject.cells, pose.position, ray, None)
        assert cell >= 0
        wrong += int(np.abs(colours[cell].astype(int) - expected[int(row), int(column)]).max() > 1)
    assert wrong <= 2, "only rays that hit the edge between two cells may differ"


def test_paints_are_those_of_the_pictures(room, subject):
    of_material = to_bytes(encode_srgb(xyz_to_linear_srgb(paint_colours(room), 1.0)))
    for shown in (subject, Subject(draw_scene(room), Choices())):
        colours = shown.paint(Look(mode="unshaded")).colours
        np.testing.assert_array_equal(colours, of_material[shown.cells.material])


@pytest.mark.parametrize("quantity", ["illuminance", "luminance"])
def test_false_colours_stand_for_numbers(solved, quantity):
    subject = Subject(read_result(solved[1]), Choices(scale_range=(0.0, 100.0)))
    colours = subject.paint(Look(mode="false-color", quantity=quantity)).colours
    values = subject.values.smooth.of(quantity)
    np.testing.assert_array_equal(colours, to_bytes(colours_of(Scale(0.0, 100.0, False, "", "").share(values))))


def test_luminance_is_that_of_what_leaves(subject):
    """A Lambertian surface of one paint: L = (M₀ + ρE) / π, and ρ = 0.2 at all wavelengths on the floor."""
    floor = subject.cells.material == subject.drawn.words.materials.index("floor")
    values = subject.values.flat
    np.testing.assert_allclose(values.xyz[floor, 1], 0.2 * values.illuminance[floor] / np.pi, rtol=1e-6)


def test_even_light_is_even_at_corners(subject):
    drawn = subject.drawn
    light = replace(drawn.light, irradiance=np.ones_like(drawn.light.irradiance))
    values = LightValues(drawn, light)
    np.testing.assert_allclose(values.smooth.illuminance, values.flat.illuminance[:, None].repeat(4, 1), rtol=1e-9)


def test_corners_are_shared_inside_a_surface_alone(subject):
    cells, light = subject.cells, subject.drawn.light
    vertex = shared_corners(cells, light)
    kind = np.column_stack([cells.object, cells.material, np.round(cells.normal, 3)])
    for column in kind.T:
        low = np.full(vertex.max() + 1, np.inf)
        high = np.full(vertex.max() + 1, -np.inf)
        np.minimum.at(low, vertex.ravel(), np.repeat(column, 4))
        np.maximum.at(high, vertex.ravel(), np.repeat(column, 4))
        np.testing.assert_array_equal(low, high)
    places = np.zeros((vertex.max() + 1, 3))
    places[vertex.ravel()] = cells.corners.reshape(-1, 3)
    np.testing.assert_allclose(places[vertex], cells.corners, atol=1e-5)
    shared = np.bincount(vertex[~cells.is_triangle].ravel())
    assert shared.max() == 4, "four cells meet inside of a wall"


def test_linear_light_stays_linear_inside(subject):
    """The mean over four equal cells of a linear field is its value where they meet."""
    cells, light = subject.cells, subject.drawn.light
    vertex = shared_corners(cells, light)
    middle = cells.corners.mean(axis=1)
    at_corner = corner_means(cells, replace(light, exposed=np.ones_like(light.exposed)), vertex, middle)
    inner = np.bincount(vertex.ravel())[vertex] == 4
    inner[cells.is_triangle] = False
    np.testing.assert_allclose(at_corner[inner], cells.corners[inner], atol=1e-9)


def two_patches():
    """Two halves of a square, cut 1 × 1 and 3 × 3: their corners meet at two places only."""
    grids = [(np.array([0.0, 0.0, 0.0]), 1), (np.array([1.0, 0.0, 0.0]), 3)]
    corners, place, grid, patch = [], [], [], []
    for number, (origin, n) in enumerate(grids):
        for i in range(n):
            for j in range(n):
                here = np.array([[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]])
                corners.append(origin + np.column_stack([here / n, np.zeros(4)]))
                place.append(here)
                grid.append([n, n])
                patch.append(number)
    n = len(corners)
    zero = np.zeros(n, np.int32)
    cells = Cells(
        corners=np.array(corners),
        is_triangle=np.zeros(n, np.bool_),
        element=np.arange(n, dtype=np.int32),
        material=zero,
        object=zero,
        patch=np.array(patch, np.int32),
        side=zero,
        place=np.array(place, np.int32),
        grid=np.array(grid, np.int32),
        width=zero + 1,
        luminaire=zero - 1,
    )
    return cells, Light(np.ones((n, 1)), np.ones(n), zero, 1)


def test_linear_light_has_no_seam_between_patches():
    """With the right values of a linear field at all corners, levelling changes none of them."""
    cells, light = two_patches()
    vertex = shared_corners(cells, light)
    field = cells.corners @ np.array([[2.0, 0.0], [1.0, -3.0], [0.0, 0.0]])
    np.testing.assert_allclose(level_seams(cells, light, vertex, field), field, atol=2e-3)


def test_a_step_between_patches_is_levelled():
    cells, light = two_patches()
    vertex = shared_corners(cells, light)
    step = corner_means(cells, light, vertex, cells.patch[:, None].astype(float))
    at_seam = (cells.corners[..., 0] == 1.0) & (cells.patch[:, None] == 1)
    inner = at_seam & (cells.corners[..., 1] > 0.1) & (cells.corners[..., 1] < 0.9)
    assert (step[inner] == 1.0).all(), "these corners are not shared"
    levelled = level_seams(cells, light, vertex, step)
    assert (levelled[inner] < 0.8).all()
    away = cells.corners[..., 0] > 1.2
    np.testing.assert_array_equal(levelled[away], 1.0)


def test_saturated_light_is_marked(subject):
    drawn = subject.drawn
    green = np.zeros_like(drawn.light.irradiance)
    green[:, np.searchsorted(drawn.words.bands.upper, 520.0)] = 1.0
    shown = Subject(drawn, Choices())
    shown.take_light(replace(drawn.light, irradiance=green))
    dull = drawn.cells.luminaire < 0
    assert shown.out_of_gamut()[dull].all()
    marked = shown.paint(Look(gamut=True)).colours
    np.testing.assert_array_equal(marked[dull], np.broadcast_to(GAMUT_MARK, marked[dull].shape))
    shown.take_light(replace(drawn.light, irradiance=np.ones_like(green)))
    floor = drawn.cells.material == drawn.words.materials.index("floor")
    assert not shown.out_of_gamut()[floor].any(), "equal energy on grey is inside"


def test_exposure_stays_when_light_grows(solved):
    drawn = read_result(solved[1])
    shown = Subject(drawn, Choices())
    before = shown.luminance(Look()), shown.scale(Look())
    shown.take_light(replace(drawn.light, irradiance=3.0 * drawn.light.irradiance))
    assert (shown.luminance(Look()), shown.scale(Look())) == before
    assert shown.luminance(Look(stops=1.0)) == pytest.approx(before[0] / 2.0)


def test_all_modes_colour_all_cells(subject, room):
    for shown in (subject, Subject(draw_scene(room), Choices())):
        for mode in MODES:
            paint = shown.paint(Look(mode=mode))
            assert len(paint.colours) == len(shown.cells)
            assert paint.colours.dtype == np.uint8

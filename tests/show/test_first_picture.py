"""The picture before anything is solved, against rooms whose light is known, and pictures of the solution."""

from dataclasses import replace

import numpy as np
import pytest
from drawn import QUICK, camera, furnished_room
from rooms import SceneBuilder

from hradiosity.model.scene import View
from hradiosity.model.spectrum import Bands
from hradiosity.radiosity import solve
from hradiosity.show.first_picture import BLOCK, MOST_LAMPS, first_picture
from hradiosity.show.preview import Preview

LOOKING_DOWN = View("v", np.array([1.0, 1.0, 1.9]), np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0]), 50.0, 64, 64)

WHOLE = Bands.explicit(np.array([380.0, 780.0]))


def linear(pixels):
    """sRGB bytes as linear values."""
    value = pixels / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def lit_box(n_lamps=1, inside=True):
    """A white box of 2 m with lamps under the ceiling, or above the whole of it."""
    b = SceneBuilder()
    paint = b.material(0.5)
    b.box((0, 0, 0), (2, 2, 2), paint, inward=True)
    z = 1.95 if inside else 3.0
    for x in np.linspace(0.4, 1.5, n_lamps):
        b.lamp(b.patch((x, 0.9, z), (0, 0.2, 0), (0.1, 0, 0), paint), 1.0)
    b.sensor((1, 1, 1), (0, 0, 1))
    return b


def test_it_resembles_the_solution(device):
    """A furnished room: brightness relative to the mean differs by a quarter, where the guess has no corners."""
    view = camera((2.7, 0.3, 1.6), (0.5, 3.5, 0.6))
    scene = replace(furnished_room(), views=(view,))
    shown, first = first_picture(scene, device)
    solution = solve(scene, QUICK, device)
    solved = Preview(solution.scene, device).pixels(solution)
    assert shown is view and first.shape == solved.shape
    guessed, known = (linear(p.astype(float)).mean(axis=2) for p in (first, solved))
    difference = guessed / guessed.mean() - known / known.mean()
    assert np.sqrt((difference**2).mean()) < 0.25
    assert np.sqrt(((known / known.mean() - 1) ** 2).mean()) > 0.4


def test_direct_light_falls_off_as_it_should(device):
    """A small lamp straight above the middle of a floor: cos⁴ and one irradiance more for all places, m / (1 − ρ)."""
    b = SceneBuilder()
    b.patch((-9, -9, 0), (18, 0, 0), (0, 18, 0), b.material(0.5))
    b.lamp(b.patch((0.99, 0.99, 2.0), (0, 0.02, 0), (0.02, 0, 0), b.material(0.0)), 1.0)
    _, pixels = first_picture(replace(b.scene(), views=(LOOKING_DOWN,)), device)
    y, x = (np.indices((64, 64)) - 31.5) / 32 * np.tan(np.radians(25.0)) * 1.9 / 2.0
    expected = (1.0 + x**2 + y**2) ** -2
    expected += 0.5 * expected.mean() / (1 - 0.5)
    found = linear(pixels.astype(float))[..., 1]
    inner = np.s_[8:-8, 8:-8]
    np.testing.assert_allclose(found[inner] / found[12, 12], expected[inner] / expected[12, 12], rtol=0.02)


def test_shadows_fall_beside_what_stands_there(device):
    b = lit_box()
    b.box((0.9, 0.5, 0.0), (1.1, 1.5, 1.0), 0, solid=True)
    view = replace(LOOKING_DOWN, position=np.array([1.0, 1.0, 1.93]), field_of_view=70.0)
    scene = replace(b.scene(), views=(view,))
    _, pixels = first_picture(scene, device)
    _, empty = first_picture(replace(lit_box().scene(), views=(view,)), device)
    share = linear(pixels.astype(float))[..., 1] / linear(empty.astype(float))[..., 1]
    assert share.shape == (64, 64) and share.min() < 0.8 * np.median(share)


@pytest.mark.parametrize("scene", [lit_box(0).scene(), lit_box(1, inside=False).scene()])
def test_without_light_in_view_the_paints_are_shown(device, scene):
    """Paint of reflectance 0.5 in even light."""
    _, pixels = first_picture(replace(scene, bands=WHOLE, views=(LOOKING_DOWN,)), device)
    luminance = linear(pixels.astype(float)) @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(luminance, 0.5, rtol=0.02)


def test_lamps_beyond_the_strongest_take_part_in_the_guess(device):
    lamps = 2 * MOST_LAMPS
    _, pixels = first_picture(replace(lit_box(lamps).scene(), views=(LOOKING_DOWN,)), device)
    assert pixels[..., 1].min() > 60 and pixels.max() >= 250


@pytest.mark.parametrize("size", [(1, 1), (BLOCK - 1, 3 * BLOCK + 1), (50, 1)])
def test_any_size(device, size):
    view = replace(LOOKING_DOWN, width=size[0], height=size[1])
    _, pixels = first_picture(replace(lit_box().scene(), views=(view,)), device)
    assert pixels.shape == (size[1], size[0], 3) and pixels[..., 1].min() > 0


def test_a_view_of_nothing_is_black(device):
    view = replace(LOOKING_DOWN, position=np.array([1.0, 1.0, -5.0]))
    _, pixels = first_picture(replace(lit_box().scene(), views=(view,)), device)
    assert (pixels == 0).all()

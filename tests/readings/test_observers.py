"""What observers see of luminaires, and UGR refused where it is not valid."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity.metrics.glare import position_index
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Scene, Sensor
from hradiosity.options import Options
from hradiosity.radiosity import solve
from hradiosity.readings.glare import NO_SOURCE, glare_of, sources_seen
from hradiosity.space.bvh_build import build_bvh

EYE, AHEAD, UP = np.array([[0.5, 2.0, 1.2]]), np.array([[1.0, 0.0, 0.0]]), np.array([0.0, 0.0, 1.0])


def room(lamps=((3.0, 1.7, 0.6, 0.6),), exitance=30.0, screen=None, eye=EYE, gaze=AHEAD) -> Scene:
    """A grey room of 6 × 4 × 2.8 m; each lamp (x, y, width, depth) is an object of its own."""
    builder = SceneBuilder()
    grey = builder.material(0.5)
    builder.box((0, 0, 0), (6, 4, 2.8), grey, inward=True)
    patches = [builder.patch((x, y, 2.7), (0, depth, 0), (width, 0, 0), grey) for x, y, width, depth in lamps]
    builder.lamp(patches, exitance)
    if screen is not None:
        builder.patch(*screen, grey)
    scene = builder.scene()
    numbers = np.zeros(len(scene.patches), np.int32)
    numbers[patches] = 1 + np.arange(len(patches))
    names = ("room", *(f"lamp {k}" for k in range(len(patches))))
    return replace(
        scene,
        patches=replace(scene.patches, object=numbers),
        objects=names,
        sensors=(Sensor("eyes", eye, np.broadcast_to(gaze, eye.shape).copy(), glare=True),),
    )


def brightness(scene):
    return float((scene.luminaires[0].exitance * luminous_weights(scene.bands)).sum()) / np.pi


def by_summation(lamp, eye, n=600):
    """(ω, E at the eye per luminance, middle) of a level lamp that shines down, by the midpoint rule."""
    x, y, width, depth = lamp
    u, v = np.meshgrid((np.arange(n) + 0.5) / n * width, (np.arange(n) + 0.5) / n * depth, indexing="ij")
    way = np.stack([x + u, y + v, np.full_like(u, 2.7)], axis=-1).reshape(-1, 3) - eye
    square = (way**2).sum(axis=1)
    to = way / np.sqrt(square)[:, None]
    angle = to[:, 2] / square * (width * depth / n**2)
    middle = (angle[:, None] * to).sum(axis=0)
    return angle.sum(), (angle * to[:, 0]).sum(), middle / np.linalg.norm(middle)


def seen_by(scene, device):
    return sources_seen(scene, scene.sensors[0].place, scene.sensors[0].direction, build_bvh(device, scene.patches))


def test_luminance_solid_angle_index_and_illuminance(device):
    lamps = ((3.0, 1.7, 0.6, 0.6), (4.5, 0.4, 0.3, 1.2))
    scene = room(lamps)
    found = seen_by(scene, device)
    np.testing.assert_array_equal(found.object, [1, 2])
    np.testing.assert_allclose(found.luminance, brightness(scene), rtol=1e-12)
    for row, lamp in enumerate(lamps):
        angle, light, middle = by_summation(lamp, EYE[0])
        assert found.solid_angle[row] == pytest.approx(angle, rel=1e-4)
        assert found.illuminance[row] == pytest.approx(light * brightness(scene), rel=1e-4)
        assert found.position_index[row] == pytest.approx(position_index(AHEAD, UP[None], middle[None])[0], rel=1e-4)


def test_half_of_a_lamp_behind_a_screen_has_half_of_its_solid_angle(device):
    """The screen's edge lies in the upright plane through the eye and the middle of the lamp."""
    screen = ((2.0, 2.0, 0.0), (0, 2.0, 0), (0, 0, 2.8))
    open_, hidden = (seen_by(room(screen=some), device) for some in (None, screen))
    assert hidden.solid_angle[0] == pytest.approx(0.5 * open_.solid_angle[0], rel=0.02)
    assert hidden.luminance[0] == pytest.approx(open_.luminance[0])


def rated(scene, device):
    options = Options(replicates=4, element_size=0.4, gather_samples=1024, light_samples=64, rays_per_element=128)
    readings = solve(scene, options, device).readings
    (found,) = glare_of(scene, readings, build_bvh(device, scene.patches)).values()
    return found, readings["eyes"]


def test_rating_is_that_of_the_parts(device):
    lamps = ((3.0, 1.7, 0.6, 0.6), (4.5, 0.4, 0.3, 1.2))
    scene = room(lamps)
    found, eyes = rated(scene, device)
    parts = [by_summation(lamp, EYE[0]) for lamp in lamps]
    bright = brightness(scene)
    total = sum(bright**2 * angle / position_index(AHEAD, UP[None], m[None])[0] ** 2 for angle, _, m in parts)
    indirect = eyes.illuminance[0] - bright * sum(light for _, light, _ in parts)
    assert found.background[0] == pytest.approx(indirect / np.pi, rel=1e-3)
    assert found.ugr[0] == pytest.approx(8 * np.log10(0.25 / (indirect / np.pi) * total), abs=0.01)
    assert 0 < found.half_width[0] < 0.3
    assert found.reason == ("",)


@pytest.mark.parametrize(
    ("lamps", "gaze", "reason"),
    [
        (((2.0, 0.5, 3.0, 3.0),), (1, 0, 0), "too large"),
        (((5.5, 1.9, 0.05, 0.05),), (1, 0, 0), "too small"),
        (((3.0, 1.7, 0.6, 0.6),), (-1, 0, 0), NO_SOURCE),
        (((3.0, 1.7, 0.6, 0.6),), (0.3, 0, 1), "below the line of sight"),
    ],
)
def test_rating_is_refused_outside_its_validity(device, lamps, gaze, reason):
    direction = np.array([gaze], float) / np.linalg.norm(gaze)
    found, _ = rated(room(lamps, gaze=direction), device)
    assert np.isnan(found.ugr[0])
    assert np.isnan(found.half_width[0])
    assert reason in found.reason[0]

"""Images against what they must show."""

from dataclasses import replace

import numpy as np
import pytest
from drawn import QUICK, camera, furnace, furnished_room
from rooms import SceneBuilder

from hradiosity.metrics.colorimetric import xyz_weights
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Sky
from hradiosity.radiosity import solve
from hradiosity.show.image import gather_image

INSIDE = camera((0.2, 0.25, 0.6), (0.9, 0.8, 0.4), field_of_view=90)
ROOM = camera((0.3, 0.3, 1.7), (2.2, 3.2, 0.8), field_of_view=85)


def image_of(device, scene, view, options=QUICK, **choices):
    return gather_image(solve(replace(scene, views=(view,)), options, device), device, view, **choices)


@pytest.mark.parametrize("rho", [0.2, 0.8])
def test_furnace_has_one_radiance_in_every_pixel(device, rho):
    """M = M0 + rho E = M0 / (1 - rho) on all walls, corners and edges included, without noise."""
    scene = furnace(rho, 3.0)
    image = image_of(device, scene, INSIDE, spectra=True)
    exitance = 3.0 / (1 - rho)
    expected = exitance / np.pi * xyz_weights(scene.bands)[0]
    np.testing.assert_allclose(image.xyz, np.broadcast_to(expected, image.xyz.shape), rtol=2e-3)
    np.testing.assert_allclose(image.illuminance, exitance * luminous_weights(scene.bands)[0], rtol=2e-3)
    np.testing.assert_allclose(image.spectrum * scene.bands.width, exitance / np.pi, rtol=2e-3)
    assert image.noise.max() < 1e-3 and (image.surface == 1).all() and (image.shining == 1).all()


def test_images_of_all_walls_hold_the_energy_of_the_lamp(device):
    """Walls of one reflectance take up (1 - rho) E, which adds up to the flux."""
    b = SceneBuilder()
    white = b.material(0.6)
    b.box((0, 0, 0), (1, 1, 1), white, inward=True)
    b.lamp(range(1), 6.0)
    flux = 6.0
    scene = b.scene()
    total = 0.0
    for axis, sign in ((0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)):
        aim = np.full(3, 0.5)
        aim[axis] += 0.5 * sign
        up = (1.0, 0.0, 0.0) if axis == 2 else (0.0, 0.0, 1.0)
        view = replace(camera((0.5, 0.5, 0.5), aim, field_of_view=90, width=32, height=32), up=np.array(up))
        total += image_of(device, scene, view).illuminance.mean()
    np.testing.assert_allclose(total * (1 - 0.6), flux * luminous_weights(scene.bands)[0], rtol=0.01)


def penumbra_room():
    """A lamp 0.2 m wide straight above the middle of a floor, and a screen half-way whose edge is below its middle."""
    b = SceneBuilder()
    black, grey = b.material(0.0), b.material(0.5)
    b.patch((-2, -2, 0), (4, 0, 0), (0, 4, 0), grey)
    b.lamp(b.patch((-0.1, -0.1, 2.0), (0, 0.2, 0), (0.2, 0, 0), black), 1000.0)
    b.box((-2, -2, 1.0), (0, 2, 1.001), black, solid=True)
    return b.scene()


def test_penumbra_lies_where_the_lamp_is_cut(device):
    """Seen from x on the floor, the screen's edge at half the height hides the lamp at x_lamp < -x: all of it below
    x = -0.1, nothing from 0.1 on; in between the share that is seen grows evenly, the lamp being small."""
    scene = penumbra_room()
    view = replace(camera((0, 0, 0.9), (0, 0, 0), field_of_view=30, width=96, height=8), up=np.array([0.0, 1.0, 0.0]))
    image = image_of(device, scene, view, samples=64)
    half = 0.9 * np.tan(np.radians(15))
    x = ((np.arange(96) + 0.5) / 96 * 2 - 1) * half
    lux = image.illuminance.mean(axis=0)
    dark, bright = x < -0.105, x > 0.105
    assert lux[dark].max() == 0.0
    clear = lux[bright].mean()
    inside = ~dark & ~bright
    np.testing.assert_allclose(lux[inside] / clear, np.clip((x[inside] + 0.1) / 0.2, 0, 1), atol=0.04)
    error = np.sqrt((image.illuminance_error**2).mean(axis=0))
    assert error[bright].max() < 1e-3 * clear and error[dark].max() == 0.0


def test_standard_errors_are_the_spread_over_seeds(device):
    """Root mean square over pixels of the stated errors against that of the spread of eight independent images."""
    solution = solve(replace(furnished_room(), views=(ROOM,)), QUICK, device)
    view = replace(ROOM, width=48, height=36)
    images = [gather_image(solution, device, view, samples=8, seed=seed) for seed in range(8)]
    luminance = np.stack([image.xyz[..., 1] for image in images])
    spread = np.sqrt((luminance.var(axis=0, ddof=1)).mean())
    stated = np.sqrt(np.mean([image.standard_error[..., 1] ** 2 for image in images]))
    print("stated over true", stated / spread)
    assert 0.85 < stated / spread < 1.15


def test_noise_halves_with_four_times_the_samples(device):
    solution = solve(replace(furnished_room(), views=(ROOM,)), QUICK, device)
    few, many = (gather_image(solution, device, ROOM, samples=n) for n in (8, 32))
    ratio = np.sqrt((few.standard_error**2).mean() / (many.standard_error**2).mean())
    print(ratio)
    assert 1.7 < ratio < 4.0


def test_image_agrees_with_readings(device):
    """Illuminance where a pixel looks, from the image and from the solution's own readings."""
    scene = furnished_room()
    solution = solve(replace(scene, views=(ROOM,)), replace(QUICK, replicates=4, gather_samples=64), device)
    view = replace(camera((1.5, 1.0, 2.2), (1.8, 2.6, 0.0), field_of_view=3, width=4, height=4))
    image = gather_image(solution, device, view, samples=512)
    forward = view.direction
    point = view.position - forward * view.position[2] / forward[2]
    reading = solution.read(point, (0, 0, 1))
    error = np.hypot(image.illuminance_error.mean() / 4, 0.5 * reading.illuminance_half_width[0])
    difference = image.illuminance.mean() - reading.illuminance[0]
    print(image.illuminance.mean(), reading.illuminance, error)
    assert abs(difference) < 3 * error + 0.02 * reading.illuminance[0]


def test_the_same_bits_every_time(device):
    solution = solve(replace(furnished_room(), views=(ROOM,)), QUICK, device)
    first, second, other = (gather_image(solution, device, ROOM, samples=4, seed=seed) for seed in (3, 3, 4))
    assert (first.xyz == second.xyz).all() and (first.standard_error == second.standard_error).all()
    assert (first.xyz != other.xyz).any()


def test_sky_is_seen_and_lights_the_ground(device):
    b = SceneBuilder()
    b.patch((-1, -1, 0), (2, 0, 0), (0, 2, 0), b.material(0.5))
    b.sky = Sky(np.array([3.0]))
    scene = b.scene()
    image = image_of(device, scene, camera((0, -3, 1), (0, 0, 0.8), field_of_view=90))
    sky = 3.0 * xyz_weights(scene.bands)[0, 1]
    np.testing.assert_allclose(image.xyz[:8, :, 1], sky, rtol=1e-5)
    ground = image.xyz[..., 1][(image.surface == 1.0)]
    np.testing.assert_allclose(ground, 0.5 * sky, rtol=1e-3)


def test_at_least_one_sample(device):
    solution = solve(replace(furnace(), views=(INSIDE,)), QUICK, device)
    with pytest.raises(ValueError, match="at least 1 sample"):
        gather_image(solution, device, INSIDE, samples=0)

"""Rates of change by every reflectance and lamp."""

import numpy as np
import pytest

from hradiosity import Options
from hradiosity.metrics.photometric import illuminance
from hradiosity.model.scene import Sky
from hradiosity.model.spectrum import Bands
from hradiosity.radiosity.photopic_bands import in_photopic_bands
from hradiosity.radiosity.sensitivity import Parameter, sensitivities
from tests.rooms import SceneBuilder


def glowing_cube(reflectance):
    """E = M / (1 − ρ), so that S = ρ / (1 − ρ)."""
    b = SceneBuilder(2)
    b.box((0, 0, 0), (1, 1, 1), b.material(reflectance), inward=True)
    b.lamp(range(6), 1.0)
    b.sensor([(0.5, 0.5, 0.2), (0.3, 0.6, 0.7)], (0, 0, 1), "inside")
    return b.scene()


@pytest.mark.parametrize("reflectance", [0.2, 0.6, 0.9, 0.995])
def test_closed_cube(device, reflectance):
    found = sensitivities(glowing_cube(reflectance), device=device)["inside"]
    paint = found[Parameter("reflectance", "m0")]
    truth = reflectance / (1.0 - reflectance)
    assert (np.abs(paint.value - truth) <= paint.half_width).all()
    assert abs(paint.mean - truth) <= paint.mean_half_width
    assert (paint.half_width <= 0.02 * max(truth, 0.5) / (1.0 - reflectance) ** 0.5).all()
    lamp = found[Parameter("flux", "l0")]
    np.testing.assert_array_equal(lamp.value, 1.0)
    assert lamp.half_width.max() < 1e-3 / (1.0 - reflectance)


def test_light_reflected_once(device):
    """A black room with one paint: E = b ρ where the lamp is not seen, E = a + b ρ elsewhere."""
    b = SceneBuilder(1)
    black, paint = b.material(0.0), b.material(0.6)
    b.box((0, 0, 0), (2, 2, 2), [black] * 4 + [paint, black], inward=True)
    lamp = b.patch((0.8, 0.8, 1.9), (0, 0.4, 0), (0.4, 0, 0), black)
    b.lamp([lamp], 10.0)
    b.sensor([(0.3, 0.3, 1.95)], (0, 0, -1), "hidden")
    b.sensor([(0.3, 0.3, 1.0)], (1, 0, 0), "both")
    found = sensitivities(b.scene(), device=device)
    hidden, both = (found[name][Parameter("reflectance", "m1")] for name in ("hidden", "both"))
    assert hidden.value[0] == pytest.approx(1.0, abs=0.01 + hidden.half_width[0])
    assert 0.0 < both.value[0] < 1.0
    assert Parameter("reflectance", "m0") not in found["both"]


def test_shares_of_lamps_and_sky_make_one(device):
    b = SceneBuilder(3)
    b.box((0, 0, 0), (2, 2, 2), b.material([0.3, 0.5, 0.7]), inward=True)
    b.rows.pop()
    b.point((0.5, 0.5, 1.5), [1.0, 2.0, 3.0])
    b.point((1.5, 1.0, 1.5), [3.0, 2.0, 1.0])
    b.sky = Sky(np.array([0.5, 0.5, 0.5]))
    b.sensor([(1.0, 1.0, 0.5), (0.5, 1.5, 0.2)], (0, 0, 1), "desk")
    found = sensitivities(b.scene(), Options(seed=3), device)["desk"]
    shares = [s for p, s in found.items() if p.kind != "reflectance"]
    assert [p.name for p in found if p.kind != "reflectance"] == ["l0", "l1", "sky"]
    np.testing.assert_allclose(np.sum([s.value for s in shares], axis=0), 1.0, atol=2e-3)
    assert all(((s.value > 0.0) & (s.value < 1.0)).all() for s in shares)


def test_photopic_bands_keep_the_lumens():
    b = SceneBuilder(60)
    b.box((0, 0, 0), (1, 1, 1), b.material(np.linspace(0.2, 0.8, 60)), inward=True)
    b.lamp([5], np.linspace(1.0, 3.0, 60))
    b.point((0.5, 0.5, 0.5), np.linspace(3.0, 0.0, 60))
    scene = b.scene()
    few = in_photopic_bands(scene)
    assert len(few.bands) == 9
    assert (few.bands.lower[0], few.bands.upper[-1]) == (scene.bands.lower[0], scene.bands.upper[-1])
    for old, new in zip(scene.luminaires, few.luminaires):
        light, fewer = (lamp.exitance if len(lamp.exitance) else lamp.intensity for lamp in (old, new))
        assert illuminance(fewer, few.bands) == pytest.approx(illuminance(light, scene.bands))
    assert (np.diff(few.materials[0].reflectance) > 0.0).all()


def test_scenes_that_nobody_sees_have_no_sensitivities(device):
    from dataclasses import replace

    scene = replace(glowing_cube(0.5), bands=Bands.explicit([900.0, 910.0, 920.0]))
    found = sensitivities(scene, device=device)["inside"]
    assert np.isnan(found[Parameter("reflectance", "m0")].value).all()

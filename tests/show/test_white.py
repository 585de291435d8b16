"""Pictures that take the lamps' light for white."""

from dataclasses import replace

import numpy as np
import pytest
from drawn import QUICK, camera, draw
from rooms import SceneBuilder

from hradiosity.metrics.colorimetric import chromaticity
from hradiosity.model.scene import Sky
from hradiosity.model.spectrum import Bands
from hradiosity.show.first_picture import first_picture
from hradiosity.show.pictures import PictureOptions
from hradiosity.show.white import lamp_light, white_of

INSIDE = camera((0.3, 0.3, 1.0), (1.7, 1.6, 0.9))
WARM = np.array([0.2, 1.0, 3.0])
"""In three bands of the whole visible range."""


def warm_room():
    """Grey walls, and a lamp in the ceiling."""
    b = SceneBuilder(3)
    grey = b.material(0.5)
    b.box((0, 0, 0), (2, 2, 2), grey, inward=True)
    b.lamp(b.patch((0.8, 0.8, 1.98), (0, 0.4, 0), (0.4, 0, 0), grey), WARM)
    return replace(b.scene(), bands=Bands.explicit(np.array([400.0, 500.0, 600.0, 700.0])))


def test_grey_under_warm_lamps_is_grey_once_adapted(device):
    scene = warm_room()
    options = replace(QUICK, element_size=1.0)
    measured_set, measured = draw(device, scene, INSIDE, options=options)
    adapted_set, adapted = draw(device, scene, INSIDE, options=options, white="lamps")
    before, after = (d["v", "smooth"].pixels.astype(int) for d in (measured, adapted))
    assert (before[..., 0] - before[..., 2]).mean() > 60
    assert np.ptp(after, axis=2).max() <= 2
    for name, channel in measured["v", "smooth"].channels.items():
        np.testing.assert_array_equal(channel, adapted["v", "smooth"].channels[name])
    x, y = chromaticity(lamp_light(scene))
    for text in (adapted_set.record["exposure"]["colours"], adapted["v", "smooth"].texts["colours"]):
        assert f"x = {x:.4f}, y = {y:.4f}" in text and "CAT16" in text
    assert "without adaptation" in measured_set.record["exposure"]["colours"]


def test_the_first_picture_adapts_too(device):
    _, pixels = first_picture(replace(warm_room(), views=(INSIDE,)), device, "lamps")
    assert np.ptp(pixels.astype(int), axis=2).max() <= 2


def test_the_mean_light_is_weighted_with_flux():
    b = SceneBuilder(1)
    paint = b.material(0.5)
    b.lamp(b.patch((0, 0, 2), (0, 3, 0), (2, 0, 0), paint), 5.0, two_sided=True)
    b.point((0, 0, 1), 2.0)
    scene = b.scene()
    one = lamp_light(
        replace(
            scene,
            emitters=replace(
                scene.emitters,
                patch=scene.emitters.patch[:0],
                position=scene.emitters.position[:0],
                luminaire=scene.emitters.luminaire[:0],
            ),
            sky=Sky(np.array([1.0])),
        )
    )
    np.testing.assert_allclose(lamp_light(scene), (2 * 6 * 5.0 + 4 * np.pi * 2.0) * one)


def test_without_light_colours_stay():
    b = SceneBuilder(1)
    b.patch((0, 0, 2), (0, 1, 0), (1, 0, 0), b.material(0.5))
    white = white_of(b.scene(), "lamps")
    np.testing.assert_array_equal(white.matrix, np.eye(3))
    assert "nothing shines" in white.words


def test_other_names_are_refused():
    with pytest.raises(ValueError, match="white must be one of"):
        PictureOptions(white="warm")

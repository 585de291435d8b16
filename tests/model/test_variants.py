from dataclasses import replace

import numpy as np
import pytest

from hradiosity.model.scene import Sky
from hradiosity.model.spectrum import Spectrum
from hradiosity.model.variants import (
    Factor,
    check_variants,
    make_variant,
    stacked_emission,
    stacked_reflectance,
    stacked_sky,
    variant_from,
    with_variant,
)
from tests.rooms import cube


def room(bands=3):
    b = cube([0.5, 0.6, 0.5, 0.5, 0.5, 0.5], bands=bands)
    b.lamp([0], [1.0, 2.0, 3.0][:bands])
    b.point((0.5, 0.5, 0.5), 4.0)
    b.sensor((0.5, 0.5, 0.1), (0, 0, 1))
    return b.scene()


def test_numbers_spectra_arrays_and_factors():
    scene = room()
    paints = {"m0": 0.2, "m1": Factor(0.5), "m2": [0.1, 0.2, 0.3], "m3": Spectrum.constant(0.7)}
    variant = make_variant(scene, "other", materials=paints, luminaires={"l0": Factor(0.0), "l1": 1.5})
    found = with_variant(scene, variant)
    np.testing.assert_allclose(found.reflectance[:4], [[0.2] * 3, [0.3] * 3, [0.1, 0.2, 0.3], [0.7] * 3])
    np.testing.assert_array_equal(found.reflectance[4:], scene.reflectance[4:])
    np.testing.assert_array_equal(found.luminaires[0].exitance, np.zeros(3))
    np.testing.assert_array_equal(found.luminaires[1].intensity, np.full(3, 1.5))
    assert found.patches is scene.patches
    assert variant_from(scene, found, "other").materials == variant.materials


def test_all_mistakes_are_told_at_once():
    with pytest.raises(ValueError) as error:
        make_variant(
            room(),
            "odd",
            materials={"m9": 0.5, "m1": Factor(2.0), "m2": [0.5, 0.5]},
            luminaires={"sun": 1.0, "l0": -1.0},
        )
    for part in ("'odd'", "no material 'm9'", "'m1' has reflectances", "(2,)", "no luminaire 'sun'", "'l0' has light"):
        assert part in str(error.value)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda s: replace(s, patches=replace(s.patches, origin=s.patches.origin + 1e-9)), "other patches"),
        (lambda s: replace(s, sensors=()), "other sensors"),
        (lambda s: replace(s, emitters=replace(s.emitters, luminaire=s.emitters.luminaire[::-1])), "other emitters"),
        (lambda s: replace(s, bands=room(2).bands), "other bands"),
        (lambda s: replace(s, sky=Sky(np.ones(3))), "other sky"),
        (lambda s: replace(s, materials=s.materials[::-1]), "materials of other names"),
        (lambda s: replace(s, luminaires=s.luminaires[::-1]), "luminaires of other names"),
    ],
)
def test_scenes_that_differ_in_more_are_no_variants(change, told):
    with pytest.raises(ValueError, match=told):
        variant_from(room(), change(room()), "other")


def test_names_are_used_once():
    variant = make_variant(room(), "twice")
    with pytest.raises(ValueError, match="several variants are named twice"):
        check_variants(replace(room(), variants=(variant, variant)))


def test_stacked_side_by_side():
    scene = replace(room(), sky=Sky(np.array([1.0, 2.0, 3.0])))
    variant = make_variant(scene, "v", materials={"m0": 0.1}, luminaires={"l1": 7.0})
    both = replace(scene, variants=(variant,))
    other = with_variant(scene, variant)
    np.testing.assert_array_equal(stacked_reflectance(both), np.hstack([scene.reflectance, other.reflectance]))
    np.testing.assert_array_equal(stacked_emission(both)[1], [4.0] * 3 + [7.0] * 3)
    np.testing.assert_allclose(stacked_sky(both), np.pi * np.array([1.0, 2.0, 3.0] * 2))

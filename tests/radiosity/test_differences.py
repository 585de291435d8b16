"""Differences between variants that are solved with the same rays."""

from dataclasses import replace

import numpy as np
import pytest

from hradiosity import Factor, Options, SceneError, compare, make_variant, solve
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.variants import with_variant
from hradiosity.planning import spectral_columns
from tests.rooms import SceneBuilder, cube

QUICK = Options(elements=300, rays_per_element=32, gather_samples=512, light_samples=256, replicates=4)


def glowing_cube(bands=3, reflectance=0.5):
    """All of it shines, so that E = M / (1 − ρ) everywhere."""
    b = cube(reflectance, bands=bands)
    b.lamp(range(6), np.linspace(1.0, 2.0, bands))
    b.sensor([(0.5, 0.5, 0.2), (0.3, 0.6, 0.7)], (0, 0, 1), "inside")
    return b.scene()


def cube_with_lamp(reflectance=0.5):
    """One face shines. The mean of the readings near all six faces is that of a cube whose faces share the light.

    Turned in all ways that a cube allows, the readings stay the same as a whole, and the faces shine alike on average.
    """
    b = cube(reflectance)
    b.lamp([5], 1.0)
    normals = np.concatenate([np.eye(3), -np.eye(3)])
    b.sensor(0.5 - 0.4 * normals, normals, "faces")
    return b.scene()


def furnished_room():
    b = cube([0.5, 0.6, 0.5, 0.5, 0.3, 0.7], side=3.0)
    wood = b.material(0.4)
    for x in (0.5, 1.6):
        b.box((x, 0.6, 0.0), (x + 0.7, 1.4, 0.75), wood, solid=True)
    lamp = b.patch((1.2, 1.2, 2.9), (0, 0.5, 0), (0.5, 0, 0), b.material(0.2))
    b.lamp([lamp], 100.0)
    b.sensor([(0.4, 0.4, 0.8), (1.5, 1.5, 0.8), (2.5, 0.3, 0.1)], (0, 0, 1), "desk")
    return b.scene()


def painted(scene, reflectance, name="painted"):
    return make_variant(scene, name, materials={m.name: reflectance for m in scene.materials})


def test_closed_cube_of_another_paint(device):
    scene = glowing_cube()
    found = compare(scene, [painted(scene, 0.51)], QUICK, device)
    difference = found.variants["painted"].differences["inside"].numbers["irradiance"]
    truth = scene.luminaires[0].exitance * (1.0 / 0.49 - 1.0 / 0.5)
    assert (np.abs(difference.value - truth) <= difference.half_width).all()
    assert (difference.half_width <= 0.01 * truth).all()
    np.testing.assert_allclose(
        found.variants["painted"].readings["inside"].irradiance - found.readings["inside"].irradiance,
        difference.value,
        rtol=1e-9,
    )


def test_numbers_relative_to_the_scene(device):
    scene = glowing_cube()
    found = compare(scene, [painted(scene, 0.6)], QUICK, device)
    numbers = found.variants["painted"].differences["inside"].numbers
    for name in ("relative_illuminance", "relative_mean_illuminance"):
        assert np.all(np.abs(numbers[name].value - 0.25) <= numbers[name].half_width)
    assert np.all(np.abs(numbers["chromaticity"].value) <= numbers["chromaticity"].half_width)
    assert np.all(np.abs(numbers["uniformity"].value) <= numbers["uniformity"].half_width)


def test_a_variant_like_the_scene_changes_nothing(device):
    scene = furnished_room()
    found = compare(scene, [make_variant(scene, "same")], QUICK, device).variants["same"]
    for name, estimate in found.differences["desk"].numbers.items():
        known = np.isfinite(estimate.value)
        assert not estimate.value[known].any(), name
        assert not estimate.half_width[known].any(), name


def test_dimmed_lamps_cost_no_column_and_no_interval(device):
    scene = furnished_room()
    variant = make_variant(scene, "dimmed", luminaires={"l0": Factor(0.25)})
    found = compare(scene, [variant], QUICK, device)
    assert found.plan.columns.n_columns == 1
    numbers = found.variants["dimmed"].differences["desk"].numbers
    np.testing.assert_allclose(numbers["illuminance"].value, -0.75 * found.readings["desk"].illuminance)
    relative = numbers["relative_illuminance"]
    np.testing.assert_allclose(relative.value, -0.75)
    assert relative.parts["sampling"].max() < 1e-12
    assert relative.half_width.max() < 1e-3


def test_far_narrower_than_the_intervals_apart(device):
    scene = furnished_room()
    variant = make_variant(scene, "wall", materials={"m1": 0.62})
    found = compare(scene, [variant], QUICK, device)
    own, other = found.readings["desk"], found.variants["wall"].readings["desk"]
    apart = np.hypot(own.illuminance_half_width, other.illuminance_half_width)
    difference = found.variants["wall"].differences["desk"]
    assert (difference.illuminance > 0.0).all()
    assert (5.0 * difference.illuminance_half_width <= apart).all()


def test_variants_agree_with_runs_of_their_own(device):
    scene = furnished_room()
    variant = make_variant(scene, "other", materials={"m1": 0.3}, luminaires={"l0": Factor(2.0)})
    together = compare(scene, [variant], QUICK, device).variants["other"].readings["desk"]
    alone = solve(with_variant(scene, variant), replace(QUICK, seed=1), device).readings["desk"]
    noise = np.hypot(together.illuminance_half_width, alone.illuminance_half_width)
    assert (np.abs(together.illuminance - alone.illuminance) <= 2.0 * noise).all()


@pytest.mark.slow
def test_intervals_of_differences_hold_the_truth(device):
    scene = cube_with_lamp()
    both = make_variant(scene, "both", materials={m.name: 0.6 for m in scene.materials}, luminaires={"l0": Factor(1.1)})
    variants = [painted(scene, 0.52), both]
    lux = float(luminous_weights(scene.bands)[0]) / 6.0
    truths = {"painted": lux * (1.0 / 0.48 - 2.0), "both": lux * (1.1 / 0.4 - 2.0)}
    options = replace(QUICK, elements=150, gather_samples=128, light_samples=64)
    hits = dict.fromkeys(truths, 0)
    for seed in range(40):
        found = compare(scene, variants, replace(options, seed=seed), device)
        for name, truth in truths.items():
            difference = found.variants[name].differences["faces"].numbers["mean_illuminance"]
            hits[name] += abs(difference.value - truth) <= difference.half_width
    # Of 40 intervals with the level of 95 %, fewer than 34 hold the truth once in 300 times.
    assert min(hits.values()) >= 34


def test_the_same_bits_again_and_after_a_checkpoint(device):
    from hradiosity.radiosity import make_solver

    scene = furnished_room()
    scene = replace(scene, variants=(make_variant(scene, "wall", materials={"m1": 0.62}),))
    first = solve(scene, QUICK, device)
    broken_off = make_solver(scene, QUICK, device)
    for state in broken_off.states():
        if state.replicate == 2:
            break
    resumed = make_solver(scene, QUICK, device)
    resumed.restore(broken_off.checkpoint())
    for _ in resumed.states():
        pass
    for other in (solve(scene, QUICK, device), resumed.solution()):
        for name, found in first.variants["wall"].differences["desk"].numbers.items():
            again = other.variants["wall"].differences["desk"].numbers[name]
            np.testing.assert_array_equal(again.value, found.value)
            np.testing.assert_array_equal(again.half_width, found.half_width)


def test_a_lamp_that_only_a_variant_switches_on(device):
    scene = furnished_room()
    off = with_variant(scene, make_variant(scene, "off", luminaires={"l0": Factor(0.0)}))
    found = compare(off, [replace(scene, name="on")], QUICK, device)
    np.testing.assert_array_equal(found.readings["desk"].illuminance, 0.0)
    difference = found.variants["on"].differences["desk"]
    alone = solve(scene, replace(QUICK, seed=1), device).readings["desk"]
    noise = np.hypot(difference.illuminance_half_width, alone.illuminance_half_width)
    assert (np.abs(difference.illuminance - alone.illuminance) <= 2.0 * noise).all()
    assert np.isnan(difference.numbers["relative_illuminance"].value).all()


def test_dark_variants_are_not_dark_for_certain(device):
    """Below a plate with a small hole few shadow rays find the lamp above it; another lamp is in full view."""
    b = SceneBuilder()
    black = b.material(0.0)
    b.box((0, 0, 0), (2, 2, 2), black, inward=True)
    lamp = b.patch((0.75, 0.75, 1.9), (0, 0.5, 0), (0.5, 0, 0), black)
    for x, y, width, depth in ((0, 0, 1.1, 2), (1.13, 0, 0.87, 2), (1.1, 0, 0.03, 1.05), (1.1, 1.08, 0.03, 0.92)):
        b.patch((x, y, 1.0), (width, 0, 0), (0, depth, 0), black)
    b.lamp([lamp], 10.0)
    b.point((0.3, 0.3, 0.5), 1.0)
    b.sensor((1.0, 1.0, 0.1), (0, 0, 1), "below")
    scene = b.scene()
    off = make_variant(scene, "off", luminaires={"l1": Factor(0.0)})
    found = compare(scene, [off], replace(QUICK, light_samples=4), device)
    dark = found.variants["off"].readings["below"].numbers["illuminance"]
    assert found.readings["below"].illuminance[0] > 0.0
    assert dark.value[0] == 0.0
    assert dark.half_width[0] == dark.parts["unseen"][0] > 0.0
    assert found.variants["off"].differences["below"].numbers["illuminance"].parts["unseen"][0] > 0.0


def test_a_variant_that_alone_reflects(device):
    scene = glowing_cube(reflectance=0.0)
    found = compare(scene, [painted(scene, 0.5)], QUICK, device)
    difference = found.variants["painted"].differences["inside"].numbers["irradiance"]
    assert (np.abs(difference.value - scene.luminaires[0].exitance) <= difference.half_width).all()


def test_columns_make_the_bands_of_the_scene_and_of_variants():
    scene = glowing_cube(bands=4)
    variant = make_variant(scene, "v", materials={"m0": [0.5, 0.2, 0.5, 0.2]}, luminaires={"l0": [1.0, 2.0, 3.0, 4.0]})
    columns = spectral_columns(replace(scene, variants=(variant,)))
    plain = spectral_columns(scene)
    assert columns.n_classes == 2
    for found, wanted in (
        (columns, scene.luminaires[0].exitance),
        (columns.of_variant(0), variant.luminaires[0].exitance),
        (plain, scene.luminaires[0].exitance),
    ):
        np.testing.assert_allclose(found.to_bands(found.emission)[0], wanted, rtol=1e-6)
    bound = columns.unlike(0).to_bands(columns.emission)[0]
    own, other = scene.luminaires[0].exitance, variant.luminaires[0].exitance
    shared = np.array([True, False, True, False])
    np.testing.assert_allclose(bound, np.where(shared, np.abs(other - own), other + own), rtol=1e-6)


def test_classic_mode_refuses_variants(device):
    scene = glowing_cube()
    with pytest.raises(SceneError, match="variants"):
        compare(scene, [painted(scene, 0.6)], Options(mode="classic"), device)


@pytest.mark.parametrize("options", [{"links": "hierarchical"}, {"form_factors": "auto"}])
def test_other_exchanges_compare_too(device, options):
    scene = glowing_cube()
    found = compare(scene, [painted(scene, 0.6)], replace(QUICK, **options), device)
    difference = found.variants["painted"].differences["inside"].numbers["irradiance"]
    truth = scene.luminaires[0].exitance * (1.0 / 0.4 - 1.0 / 0.5)
    np.testing.assert_allclose(difference.value, np.broadcast_to(truth, difference.value.shape), rtol=0.01)

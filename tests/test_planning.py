"""Right-hand sides: as few as the spectra allow, and the bands follow from them exactly."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import SceneBuilder, cube

from hradiosity.model.scene import Scene, Sky
from hradiosity.options import Options
from hradiosity.planning import make_plan, paths_of_reading, spectral_columns
from hradiosity.reference.radiosity import solve_dense
from hradiosity.space.lit_sides import LitSides

BANDS = 12


def room(reflectances, exitances, sky=None) -> Scene:
    """A cube whose faces have the given reflectances, and a lamp for each spectrum."""
    b = SceneBuilder(BANDS)
    b.box((0, 0, 0), (1, 1, 1), [b.material(reflectances[k % len(reflectances)]) for k in range(6)], inward=True)
    for k, exitance in enumerate(exitances):
        b.lamp(k, exitance)
    b.sky = None if sky is None else Sky(np.asarray(sky, float))
    return b.scene()


def solutions(scene):
    """Irradiance of the six faces in every band: by the columns, and band by band."""
    rng = np.random.default_rng(0)
    exchange = rng.uniform(0.5, 1.5, (6, 6))
    exchange += exchange.T
    for _ in range(300):
        d = 1 / np.sqrt(exchange.sum(axis=1))
        exchange *= d[:, None] * d
    area, share = np.ones(6), rng.random((6, len(scene.luminaires) + 1))
    columns = spectral_columns(scene)
    emission = np.concatenate([columns.emission, columns.sky[None]]).astype(float)
    reflectance = columns.reflectance[scene.patches.material].astype(float)
    by_columns = solve_dense(exchange, area, reflectance, share @ emission)
    sky = np.zeros(BANDS) if scene.sky is None else np.pi * scene.sky.radiance
    spectra = np.array([lamp.exitance if len(lamp.exitance) else lamp.intensity for lamp in scene.luminaires] + [sky])
    by_bands = solve_dense(exchange, area, scene.reflectance[scene.patches.material], share @ spectra)
    return columns, columns.to_bands(by_columns), by_bands


def check(scene, n_columns, n_classes=None):
    columns, by_columns, by_bands = solutions(scene)
    assert columns.n_columns == n_columns
    assert n_classes is None or columns.n_classes == n_classes
    np.testing.assert_allclose(by_columns, by_bands, rtol=1e-5, atol=0)
    return columns


def spectra(seed, count):
    return np.random.default_rng(seed).uniform(0.1, 1.0, (count, BANDS))


def test_grey_room_needs_one_column_a_shape():
    warm, cold = spectra(1, 2)
    check(room([0.5], [warm]), 1, 1)
    check(room([0.5, 0.2], [warm, cold]), 2, 1)
    check(room([0.5, 0.2], [warm, 3 * warm, 0.1 * warm, cold]), 2, 1)


def test_more_shapes_than_bands_need_the_bands():
    check(room([0.5], spectra(2, 5)), 5, 1)
    b = SceneBuilder(BANDS)
    b.box((0, 0, 0), (1, 1, 1), b.material(0.5), inward=True)
    for k, exitance in enumerate(spectra(3, 20)):
        b.lamp(k % 6, exitance)
    check(b.scene(), BANDS, 1)


def test_coloured_room_needs_every_band():
    check(room(list(spectra(4, 2) * 0.9), spectra(5, 2)), BANDS, BANDS)


def test_bands_of_equal_reflectance_form_a_class():
    """Three plateaus: one lamp needs a column in each, two lamps two."""
    plateaus = np.repeat([0.2, 0.5, 0.8], 4)
    check(room([plateaus, 0.3], spectra(6, 1)), 3, 3)
    check(room([plateaus, 0.3], spectra(6, 2)), 6, 3)
    scattered = plateaus[np.random.default_rng(0).permutation(BANDS)]
    check(room([scattered, 0.3], spectra(6, 2)), 6, 3)


def test_unused_materials_do_not_count():
    b = SceneBuilder(BANDS)
    b.box((0, 0, 0), (1, 1, 1), b.material(0.5), inward=True)
    b.material(spectra(7, 1)[0])
    b.lamp(5, spectra(8, 1)[0])
    check(b.scene(), 1, 1)


def test_lamps_that_shine_in_some_bands_only():
    laser, other = np.zeros(BANDS), np.zeros(BANDS)
    laser[3], other[7:] = 5.0, 1.0
    check(room([0.5], [laser, other]), 2, 1)
    check(room([np.repeat([0.2, 0.5, 0.8], 4)], [laser]), 1)


@pytest.mark.filterwarnings("error")
def test_no_light_at_all():
    columns = check(room([0.5], [np.zeros(BANDS)]), 0)
    assert columns.n_groups == 1 and columns.to_bands(np.zeros((4, 8))).shape == (4, BANDS)
    check(room([0.5], []), 0)
    check(room([spectra(9, 1)[0]], [np.zeros(BANDS)]), 0)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("coloured", [False, True])
@pytest.mark.parametrize("weak", [1e-6, 1e-30, 1e-120])
def test_weak_sources_keep_their_digits(weak, coloured):
    """Alone in their bands or their shapes, whatever else shines; and a scene of weak light only."""
    reflectance = [spectra(10, 1)[0] * 0.9] if coloured else [0.5]
    bright, dim = np.zeros(BANDS), np.zeros(BANDS)
    bright[:6], dim[6:] = spectra(11, 2)[:, :6]
    scene = room(reflectance, [bright, weak * dim])
    _, by_columns, by_bands = solutions(scene)
    np.testing.assert_allclose(by_columns, by_bands, rtol=1e-5, atol=0)
    _, by_columns, by_bands = solutions(room(reflectance, [weak * spectra(12, 1)[0]]))
    np.testing.assert_allclose(by_columns, by_bands, rtol=1e-5, atol=0)


def test_sky_and_point_sources_count_as_sources():
    b = SceneBuilder(BANDS)
    b.box((0, 0, 0), (1, 1, 1), b.material(0.5), inward=True)
    warm, cold = spectra(13, 2)
    b.point((0.5, 0.5, 0.5), warm)
    b.lamp(5, 2 * warm)
    b.sky = Sky(cold)
    columns = check(b.scene(), 2, 1)
    b.sky = Sky(warm)
    check(b.scene(), 1, 1)
    assert columns.sky.any()


def test_reflectance_ends_with_the_black_back():
    scene = cube(0.5, bands=BANDS).scene()
    columns = spectral_columns(replace(scene, luminaires=room([0.5], spectra(1, 1)).luminaires))
    assert not columns.reflectance[-1].any() and len(columns.reflectance) == len(scene.materials) + 1


def lit_cube(scene, free_path=2 / 3) -> LitSides:
    """Fronts lit, backs dark; the mean free path of a unit cube is 4V/S = 2/3 m."""
    lit = np.tile([True, False], (len(scene.patches), 1))
    space = np.where(lit, 0, -1).astype(np.int32)
    slots = np.zeros(lit.shape, np.int64)
    return LitSides(lit=lit, space=space, open=np.zeros(1, bool), free_path=free_path, slots=slots)


@pytest.mark.parametrize(
    ("elements", "edge", "bound"), [(1, 0.2, "no larger than 20 %"), (20000, 0.05, "no smaller than 5 %")]
)
def test_a_number_of_elements_that_is_not_kept_is_explained(elements, edge, bound):
    scene = cube(0.5, bands=BANDS).scene()
    plan = make_plan(scene, Options(elements=elements), lit_cube(scene))
    assert plan.element_size == pytest.approx(edge * 2 / 3)
    (line,) = [line for line in plan.lines() if line.startswith("elements:")]
    assert line.startswith(f"elements: {elements} asked for, {plan.n_elements} made: cells {bound}")
    assert "--element-size" in line


def test_plates_that_nearly_touch_do_not_make_millions_of_elements():
    scene = cube(0.5, bands=BANDS).scene()
    plan = make_plan(scene, Options(elements=500), lit_cube(scene, free_path=1e-5))
    assert plan.element_size == pytest.approx((6 / 8000) ** 0.5)
    assert "larger than 20 % of the mean free path" in plan.size_bound


@pytest.mark.parametrize("options", [Options(elements=2000), Options(element_size=0.01), Options(element_size=0.4)])
def test_a_size_within_bounds_or_forced_needs_no_word(options):
    scene = cube(0.5, bands=BANDS).scene()
    plan = make_plan(scene, options, lit_cube(scene))
    assert not [line for line in plan.lines() if line.startswith("elements:")]
    if options.element_size:
        assert plan.element_size == options.element_size


@pytest.mark.parametrize(
    ("reflectance", "edge", "rays"), [(0.5, 0.02, 32), (0.5, 0.12, 56), (0.5, 0.2, 64), (0.8, 0.02, 64)]
)
def test_many_times_the_elements_asked_for_send_fewer_rays_each_but_for_bright_rooms(reflectance, edge, rays):
    """√(4 · 80/423) of 64 are 56; half of them at the least."""
    scene = room([np.full(BANDS, reflectance)], [np.ones(BANDS)])
    options = Options(elements=80, element_size=edge, rays_per_element=512)
    assert make_plan(scene, options, lit_cube(scene)).rays_per_element == rays


@pytest.mark.parametrize(("n_readings", "times"), [(1, 8.0), (125, 8.0), (400, 2.5), (1000, 1.0), (5800, 1.0)])
def test_few_readings_have_the_paths_of_a_thousand_up_to_eight_times_as_many(n_readings, times):
    draft = Options.of_quality("draft")
    assert paths_of_reading(draft, n_readings) == round(times * draft.gather_samples)


def test_samples_that_are_said_are_meant():
    assert paths_of_reading(Options.of_quality("draft", gather_samples=640), 3) == 640
    assert paths_of_reading(Options(gather_samples=640), 3) == 640
    assert paths_of_reading(Options.of_quality("draft", accuracy=0.01), 3) == Options.of_quality("draft").gather_samples

"""Whole runs against continuous solutions of box rooms, exact closures and symmetries."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from box_rooms import CASES, FACES, box_room, expected
from rooms import SceneBuilder, cube, moved
from scipy.spatial.transform import Rotation

from hradiosity.io.scene_toml import load_scene
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Emitters, Luminaire, Sky
from hradiosity.options import Options
from hradiosity.radiosity import solve
from hradiosity.readings.paths import trace_referee
from hradiosity.space.bvh_build import build_bvh
from hradiosity.transport.device_scene import upload_scene

SCENES = Path(__file__).parents[2] / "scenes"
QUICK = Options(gather_samples=1024, light_samples=64, rays_per_element=128, light_points=32)
SHADOW_RAYS = replace(QUICK, glow=False)
"""Every lamp gets shadow rays, also those that would be left to the rays that meet them."""
SMALL = replace(QUICK, element_size=0.15)
FINE = Options(gather_samples=16384, light_samples=256, rays_per_element=1024, light_points=256)
QUICK_CASES = ("cube-iso-rho0.50", "cube-lum-ceiling-A", "room443-panel-752")


def only(solution):
    (readings,) = solution.readings.values()
    return readings


def check_box_room(device, name, options, at_points, at_faces):
    case = CASES[name]
    scene = box_room(case)
    solution = solve(scene, options, device)
    error = only(solution).illuminance / expected(case) - 1
    elements, efficacy = solution.elements, luminous_weights(scene.bands)[0]
    material = elements.row_material
    received = np.bincount(material, elements.area * solution.surfaces.irradiance[:, 0])
    mean = efficacy * received / np.bincount(material, elements.area)
    faces = mean / [case["face_means"][face]["total"] for face in FACES] - 1
    print(f"{name:32s} points {np.abs(error).max():.4f} faces {np.abs(faces).max():.4f}")
    assert np.abs(error).max() < at_points
    assert np.abs(faces).max() < at_faces


@pytest.mark.parametrize("name", QUICK_CASES)
def test_box_rooms_quickly(device, name):
    """1024 paths: three standard errors of the noisiest point are 2 %."""
    check_box_room(device, name, QUICK, 0.02, 0.005)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_box_rooms_as_accurately_as_the_references_ask(device, name):
    """0.5 % at points, 0.1 % for the means of faces."""
    check_box_room(device, name, FINE, 0.005, 0.001)


def furnished(bands, exitance):
    """A room with solid boxes, a shelf and a two-sided screen, all of other colours, each patch shining alike.

    exitance : of a surface as a function of its reflectance (n_bands,)
    """
    rng = np.random.default_rng(0)
    b = SceneBuilder(bands)

    def paint():
        return b.material(rng.uniform(0.05, 0.9, bands))

    single = b.box((0, 0, 0), (3, 4, 2.5), [paint() for _ in range(6)], inward=True)
    for low, high in (((0.5, 0.5, 0.02), (1.2, 1.5, 0.7)), ((2.0, 0.3, 0.7), (2.8, 3.7, 0.75))):
        single += b.box(low, high, paint(), solid=True)
    screen = b.patch((1.5, 3.0, 1.4), (0.8, 0.3, 0.1), (0, 0.2, 0.6), paint(), triangle=True)
    for patch in [*single, screen]:
        b.lamp(patch, exitance(b.materials[b.rows[patch][4]].reflectance), two_sided=patch == screen)
    places = [(1.5, 2, 1), (0.25, 1, 0.1), (2.5, 1, 0.35), (1.6, 3.4, 1.2)]
    b.sensor(places, [(0, 0, 1), (1, 0, 0), (0, 0, 1), (0, 0.6, 0.8)])
    return b


def test_uniform_light_in_a_furnished_room(device):
    """M = (1 − ρ) B everywhere makes E = B at every place and in every band, whatever stands where."""
    wanted = np.array([2.0, 5.0, 11.0])
    solution = solve(furnished(3, lambda rho: (1 - rho) * wanted).scene(), SHADOW_RAYS, device)
    readings = only(solution)
    error = readings.irradiance / wanted - 1
    assert (np.abs(error) < np.maximum(4 * readings.half_width / wanted, 0.01)).all()
    area = solution.elements.area * solution.surfaces.exposed
    mean = area @ (solution.surfaces.irradiance / wanted - 1) / area.sum()
    assert np.abs(mean).max() < 0.01


def test_uniform_light_in_the_office_is_exact(device):
    """M = (1 − ρ) B on all 2148 patches, books, chairs and lamps among them: E = B within 1e-4.

    Lamps outside, between the walls' backs and nothing, are sampled; those inside are left to the rays that meet them.
    What few readings miss beyond that is the light of single paths that end in cracks between things that touch.
    """
    office = load_scene(SCENES / "office")
    patches, wanted = office.patches, 100.0
    scene = replace(
        office,
        luminaires=tuple(Luminaire(m.name, wanted * (1 - m.reflectance), np.zeros(0)) for m in office.materials),
        emitters=Emitters(np.arange(len(patches), dtype=np.int32), patches.centroid, patches.material),
    )
    solution = solve(scene, Options(), device)
    assert np.count_nonzero(solution.plan.weak_emitters) > 1900
    error = np.concatenate([readings.irradiance for readings in solution.readings.values()]) / wanted - 1
    assert np.sqrt((error**2).mean()) < 1e-4
    assert (np.abs(error) > 1e-4).mean() < 0.02
    assert np.abs(error).max() < 1e-3
    inside = solution.surfaces.space == np.bincount(solution.surfaces.space).argmax()
    weight = (solution.elements.area * solution.surfaces.exposed)[inside]
    mean = weight @ solution.surfaces.irradiance[inside] / weight.sum()
    np.testing.assert_allclose(mean, wanted, rtol=1e-3)


@pytest.mark.parametrize("glow", [True, False])
def test_a_luminous_ceiling_left_to_rays_and_sampled(device, glow):
    """Both ways of finding a lamp, against the exact room.

    Left to rays, a lamp lights itself through the same exchange twice, there and back: the noise of 32 rays an element
    makes its own face 1.5 % too bright.
    """
    options = replace(QUICK, gather_samples=16384, rays_per_element=256, glow=glow)
    check_box_room(device, "cube-lum-ceiling-A", options, 0.02, 0.02 if glow else 0.005)


@pytest.mark.slow
def test_uniform_light_beside_furniture_without_bias(device):
    """Places 10 cm above the floor beside a box and under a shelf, within 0.5 %."""
    room = furnished(1, lambda rho: 1 - rho)
    options = replace(SHADOW_RAYS, gather_samples=65536, light_samples=16384, light_points=256)
    solution = solve(room.scene(), options, device)
    np.testing.assert_allclose(only(solution).irradiance, 1.0, atol=0.005)


def test_flux_balance(device):
    """Closed: what is emitted is absorbed, Σ A (1 − ρ) E = Σ A M, once the direct part is what the lamps send."""
    room = cube([0.1, 0.3, 0.5, 0.7, 0.9, 0.2])
    room.lamp(5, 1.0)
    solution = solve(room.scene(), replace(SMALL, light_points=256), device)
    rho = np.array([0.1, 0.3, 0.5, 0.7, 0.9, 0.2])[solution.elements.row_material]
    absorbed = solution.elements.area @ ((1 - rho) * solution.surfaces.irradiance[:, 0])
    sent = solution.elements.area @ solution.surfaces.direct[:, 0]
    assert absorbed == pytest.approx(sent, rel=1e-3)
    assert sent == pytest.approx(1.0, rel=2e-3)


@pytest.mark.parametrize("rho", [0.5, 0.9, 0.999])
def test_furnace(device, rho):
    """Uniform emission in a closed room of one reflectance: E = M / (1 − ρ) everywhere."""
    room = cube(rho)
    room.lamp(range(6), 1 - rho)
    room.sensor([(0.5, 0.5, 0.5), (0.1, 0.2, 0.0), (0.9, 0.9, 0.95)], [(0, 0, 1), (0, 0, 1), (0, -0.6, 0.8)])
    solution = solve(room.scene(), replace(SMALL, glow=False), device)
    np.testing.assert_allclose(only(solution).irradiance, 1.0, rtol=0.02)
    mean = np.average(solution.surfaces.irradiance[:, 0], weights=solution.elements.area)
    assert mean == pytest.approx(1.0, rel=5e-3)


def test_sealed_dark_room_reads_exactly_zero(device):
    rooms = SceneBuilder()
    grey = rooms.material(0.5)
    lit = rooms.box((0, 0, 0), (1, 1, 1), grey, inward=True)
    rooms.box((1.01, 0, 0), (2, 1, 1), grey, inward=True)
    rooms.lamp(lit[0], 1e6)
    rooms.sensor([(1.5, 0.5, 0.5), (1.02, 0.5, 0.5)], (-1, 0, 0))
    rooms.sensor((0.5, 0.5, 0.5), (-1, 0, 0))
    dark, bright = solve(rooms.scene(), QUICK, device).readings.values()
    assert not dark.irradiance.any() and bright.irradiance.all()


def test_dim_room_beside_a_bright_one(device):
    """White and sealed, a millionth as bright: as if it were alone."""

    def rooms(with_bright):
        b = SceneBuilder()
        white, dark = b.material(0.9), b.material(0.05)
        b.lamp(b.box((0, 0, 0), (1, 1, 1), white, inward=True)[5], 1e-6)
        if with_bright:
            b.lamp(b.box((1.2, 0, 0), (2.2, 1, 1), dark, inward=True)[5], 1.0)
        b.sensor((0.5, 0.5, 0.5), (0, 0, 1))
        return only(solve(b.scene(), QUICK, device)).irradiance[0, 0]

    assert rooms(True) == pytest.approx(rooms(False), rel=0.02)


@pytest.mark.parametrize(
    ("position", "normal"),
    [((0.5, 0.5, -0.5), (0, 0, 1)), ((2.0, 0.5, 0.5), (-1, 0, 0)), ((0.5, 0.5, 1.2), (0, 0, -1))],
)
def test_outside_of_a_sealed_convex_room_is_dark(device, position, normal):
    room = cube()
    room.lamp(5, 1.0)
    room.sensor(position, normal)
    assert not only(solve(room.scene(), QUICK, device)).irradiance.any()


def test_a_single_table_shades(device):
    table = SceneBuilder()
    table.patch((0, 0, 0), (1, 0, 0), (0, 1, 0), table.material(0.5))
    table.point((0.5, 0.5, 1), 1.0)
    table.sensor([(0.5, 0.5, -0.5), (0.5, 0.5, 0.5)], (0, 0, 1))
    below, above = only(solve(table.scene(), QUICK, device)).irradiance[:, 0]
    assert below == 0 and above == pytest.approx(4.0, rel=1e-5)


@pytest.mark.parametrize(("rho", "from_below"), [(0.0, 0.0), (0.5, 0.5)])
def test_sky_over_a_plain(device, rho, from_below):
    """πL from above, ρπL from below."""
    plain = SceneBuilder()
    plain.patch((-500, -500, 0), (1000, 0, 0), (0, 1000, 0), plain.material(rho))
    plain.sky = Sky(np.array([1.0]))
    plain.sensor([(0, 0, 1)] * 2, [(0, 0, 1), (0, 0, -1)])
    found = only(solve(plain.scene(), QUICK, device)).irradiance[:, 0]
    np.testing.assert_allclose(found, [np.pi, from_below * np.pi], rtol=1e-5)


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("light", ["none", "point", "sky"])
@pytest.mark.parametrize("surfaces", [False, True])
def test_scenes_with_next_to_nothing(device, light, surfaces):
    b = cube() if surfaces else SceneBuilder()
    if light == "point":
        b.point((0.5, 0.5, 0.9), 1.0)
    if light == "sky":
        b.sky = Sky(np.array([1.0]))
    b.sensor((0.5, 0.5, 0.5), (0, 0, 1))
    found = only(solve(b.scene(), QUICK, device)).irradiance[0, 0]
    if light == "none" or (light == "sky" and surfaces):
        assert found == 0
    elif not surfaces:
        assert found == pytest.approx(np.pi if light == "sky" else 6.25, rel=1e-5)
    else:
        assert found > 6.25


def lit_room(bands=2):
    """Asymmetric, not convex, two lamps of two spectra, and a sensor of five points."""
    b = cube([0.2, 0.4, 0.5, 0.6, 0.3, 0.7], bands=bands)
    b.box((0.2, 0.3, 0.05), (0.6, 0.5, 0.4), b.material(np.linspace(0.2, 0.6, bands)), solid=True)
    b.lamp(5, np.linspace(1.0, 2.0, bands))
    b.lamp(b.patch((0.8, 0.2, 0.5), (0.1, 0.0, 0.0), (0.0, 0.1, 0.05), 0), np.linspace(3.0, 1.0, bands))
    b.sensor(np.random.default_rng(0).uniform(0.1, 0.9, (5, 3)) * [1, 1, 0.4] + [0, 0, 0.5], (0, 0, 1))
    return b


def irradiance_of(device, scene, options=None):
    readings = only(solve(scene, options or SMALL, device))
    return readings.irradiance, readings.half_width


def assert_equal_light(one, other):
    """Means of two independent runs within what their intervals allow, and closer than 3 %."""
    (first, first_width), (second, second_width) = one, other
    assert (np.abs(first - second) < 2.5 * np.hypot(first_width, second_width) + 2e-3 * first).all()
    assert np.abs(first / second - 1).max() < 0.03


def test_linear_in_the_emission(device):
    scene = lit_room().scene()
    base = irradiance_of(device, scene)[0]

    def lit_by(factors):
        lamps = tuple(replace(lamp, exitance=f * lamp.exitance) for f, lamp in zip(factors, scene.luminaires))
        return irradiance_of(device, replace(scene, luminaires=lamps))[0]

    np.testing.assert_allclose(lit_by((1e-9, 1e-9)), 1e-9 * base, rtol=1e-5)
    np.testing.assert_allclose(lit_by((1, 0)) + lit_by((0, 1)), base, rtol=0.03)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_scaling_changes_nothing(device, factor):
    scene, options = lit_room().scene(), replace(SMALL, element_size=0.15 * factor)
    assert_equal_light(irradiance_of(device, scene), irradiance_of(device, moved(scene, factor=factor), options))


def test_power_of_two_scaling_changes_no_bit(device):
    """Area lamps: every length is multiplied exactly."""
    scene = lit_room().scene()
    first = irradiance_of(device, scene)[0]
    other = irradiance_of(device, moved(scene, factor=4.0), replace(SMALL, element_size=0.6))[0]
    np.testing.assert_allclose(first, other, rtol=1e-6)


def test_rotation_and_translation_change_nothing(device):
    scene = lit_room().scene()
    base = irradiance_of(device, scene)
    turn = Rotation.from_euler("xyz", [0.3, 0.5, 0.7]).as_matrix()
    assert_equal_light(base, irradiance_of(device, moved(scene, rotation=turn)))
    assert_equal_light(base, irradiance_of(device, moved(scene, shift=np.array([1e6, -1e6, 1e5]))))


def test_renumbering_changes_nothing(device):
    scene = lit_room().scene()
    order = np.random.default_rng(1).permutation(len(scene.patches))
    fields = {name: getattr(scene.patches, name)[order] for name in scene.patches.__dataclass_fields__}
    place = np.argsort(order)
    shuffled = replace(
        scene,
        patches=replace(scene.patches, **fields),
        emitters=replace(scene.emitters, patch=place[scene.emitters.patch].astype(np.int32)),
    )
    assert_equal_light(irradiance_of(device, scene), irradiance_of(device, shuffled))


def test_band_by_band_is_all_bands_at_once(device):
    """The same rays serve all bands: each band alone gives the same numbers to rounding and solver tolerance."""
    scene = lit_room(3).scene()
    together = irradiance_of(device, scene)[0]
    for k in range(3):
        one = replace(
            scene,
            bands=type(scene.bands)(scene.bands.lower[k : k + 1], scene.bands.upper[k : k + 1]),
            materials=tuple(replace(m, reflectance=m.reflectance[k : k + 1]) for m in scene.materials),
            luminaires=tuple(replace(lamp, exitance=lamp.exitance[k : k + 1]) for lamp in scene.luminaires),
        )
        np.testing.assert_allclose(irradiance_of(device, one)[0][:, 0], together[:, k], rtol=0.03)


SCRIPT = """
import sys
from test_rooms import SMALL, lit_room, only
from hradiosity.device import Device
from hradiosity.radiosity import solve
from hradiosity.readings.paths import trace_referee
from hradiosity.space.bvh_build import build_bvh
from hradiosity.transport.device_scene import upload_scene
sys.stdout.write(only(solve(lit_room().scene(), SMALL, Device())).irradiance.tobytes().hex())
"""


def test_same_bits_whatever_the_number_of_threads():
    tests = Path(__file__).parents[1]

    def run(threads):
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (tests, tests / "whole", tests.parent)))}
        if threads:
            environment["POCL_MAX_PTHREAD_COUNT"] = str(threads)
        return subprocess.run(
            [sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True
        ).stdout

    one = run(1)
    assert len(one) > 100 and one == run(2)


@pytest.mark.parametrize("gap", [1e-3, 2e-2])
def test_light_in_a_slot_under_a_block(device, gap):
    """Elements of the lit floor reach into the slot; looked up there, they make it up to 60 times too bright.

    Against unbiased paths, within the two intervals and 10 % for elements that the slot is not much lower than.
    """
    b = SceneBuilder(1)
    grey = b.material(0.6)
    b.box((0, 0, 0), (4, 4, 2.5), grey, inward=True)
    b.box((1.5, 1.5, gap), (2.5, 2.5, 0.5), grey, solid=True)
    b.lamp(b.patch((1.5, 1.5, 2.45), (0, 1, 0), (1, 0, 0), grey), 1000.0)
    depths = np.array([2.0, 5.0, 10.0]) * gap
    b.sensor(np.column_stack([1.5 + depths, np.full(3, 2.0), np.full(3, 0.5 * gap)]), (0, 0, 1))
    scene = b.scene()
    sensor = scene.sensors[0]
    readings = only(solve(scene, Options(), device))
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    truth = trace_referee(on_device, scene, sensor.position, sensor.normal, paths=65536, seed=3)
    error = np.abs(readings.irradiance - truth.irradiance)[:, 0]
    assert (error <= readings.half_width[:, 0] + 3.0 * truth.standard_error[:, 0] + 0.1 * truth.irradiance[:, 0]).all()
    assert readings.irradiance[0, 0] > 0.0

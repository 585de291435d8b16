"""Cases 30 to 33: light that comes from afar, round corners, through a slit, or not at all."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import SceneBuilder
from truths import QUICK, assert_agrees, only, read, rectangle_factor, unbiased

from hradiosity.model.scene import Sensor, Sky
from hradiosity.options import Options
from hradiosity.radiosity import solve

WEST = np.tile([1.0, 0.0, 0.0], (2, 1))


def points_on_walls(low, high, n):
    """Positions and normals of n × n points on each inner face of a box."""
    low, size = np.array(low, float), np.subtract(high, low).astype(float)
    u, v = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n)
    position, normal = [], []
    for axis in range(3):
        for end in (0.0, 1.0):
            share = np.insert(np.column_stack([u.ravel(), v.ravel()]), axis, end, axis=1)
            position.append(low + share * size)
            normal.append(np.tile((1.0 - 2.0 * end) * np.eye(3)[axis], (n * n, 1)))
    return np.concatenate(position), np.concatenate(normal)


def test_case_30_bottom_of_a_light_well_twenty_times_as_deep_as_wide(device):
    """Sky straight from above by Lambert's formula, in a black well; with reflections against unbiased paths."""

    def well(rho):
        b = SceneBuilder()
        b.box((0, 0, 0), (1, 1, 20), b.material(rho), inward=True)
        b.rows.pop()
        b.sky = Sky(np.array([1.0]))
        b.sensor([(0.5, 0.5, 0.0), (0.1, 0.1, 0.0), (0.5, 0.5, 10.0)], (0, 0, 1))
        return b.scene()

    black = read(well(0.0), device, replace(QUICK, gather_samples=65536))
    exact = [np.pi * rectangle_factor(p, (0, 0, 1), (0, 0, 20), (1, 0, 0), (0, 1, 0)) for p in black.position]
    error = np.abs(black.irradiance[:, 0] - exact)
    assert (error <= 2.0 * black.half_width[:, 0]).all()
    scene = well(0.7)
    found = read(scene, device)
    truth = unbiased(scene, device, 65536)
    assert_agrees(found, truth, bias=0.03)
    assert (found.half_width > 0.0).all()


def test_case_30_far_end_of_a_corridor(device):
    b = SceneBuilder()
    paint = b.material(0.5)
    b.box((0, 0, 0), (40, 2, 2), paint, inward=True)
    b.lamp(b.patch((0.2, 0.5, 1.95), (0, 1, 0), (1, 0, 0), paint), 1000.0)
    b.box((2, 0, 0), (2.1, 1.5, 2), paint, solid=True)
    b.sensor([(10, 1, 0.5), (25, 1, 0.5), (39.5, 1, 0.5)], (0, 0, 1))
    scene = b.scene()
    found = read(scene, device, Options())
    truth = unbiased(scene, device, 1 << 18)
    assert_agrees(found, truth, bias=0.03)
    relative = (found.half_width / truth.irradiance)[:, 0]
    assert (found.irradiance > 0.0).all() and relative[2] > relative[0]


def maze():
    """Four rooms in a row whose doors lie at alternate ends: the last one sees no wall that the lamp sees."""
    b = SceneBuilder()
    paint = b.material(0.8)
    b.box((0, 0, 0), (8, 3, 2.5), paint, inward=True)
    for k, x in enumerate((2.0, 4.0, 6.0)):
        low = 0.6 if k % 2 else 0.0
        b.box((x - 0.05, low, 0), (x + 0.05, low + 2.4, 2.5), paint, solid=True)
    b.lamp(b.patch((0.5, 0.5, 2.45), (0, 1, 0), (1, 0, 0), paint), 1000.0)
    b.sensor([(7.0, 2.5, 0.8), (7.0, 0.5, 0.8), (5.0, 2.5, 0.8)], (0, 0, 1))
    return b.scene()


def test_case_31_light_of_three_bounces_or_more_in_a_maze(device):
    scene = maze()
    found = read(scene, device, replace(QUICK, rays_per_element=512))
    assert not only(solve(scene, replace(QUICK, interreflection=False), device)).irradiance.any()
    truth = unbiased(scene, device, 1 << 17)
    assert_agrees(found, truth, bias=0.05)
    assert (found.irradiance > 0.0).all()


def test_case_32_two_bright_rooms_through_a_slit_of_a_millimetre(device):
    """What the dim room absorbs, (1 − ρ) S Ē, came in through the slit of area s: s times the irradiance there."""
    rho, slit = 0.9, 1e-3
    b = SceneBuilder()
    paint = b.material(rho)
    b.box((0, 0, 0), (2, 1, 1), paint, inward=True)
    b.patch((1, 0, 0), (0, 0.5, 0), (0, 0, 1), paint)
    b.patch((1, 0.5 + slit, 0), (0, 0.5 - slit, 0), (0, 0, 1), paint)
    b.lamp(b.patch((0.25, 0.25, 0.98), (0, 0.5, 0), (0.5, 0, 0), paint), 1000.0)
    in_slit = replace(b.scene(), sensors=(Sensor("slit", np.array([[1.0, 0.5005, z] for z in (0.25, 0.75)]), -WEST),))
    arriving = unbiased(in_slit, device, 16384).irradiance.mean()
    b.sensor(*points_on_walls((1, 0, 0), (2, 1, 1), 4))
    solution = solve(b.scene(), QUICK, device)
    found = only(solution)
    expected = slit * arriving / ((1.0 - rho) * 6.0 + slit)
    mean, width = found.irradiance.mean(), found.mean_illuminance_half_width / found.mean_illuminance
    assert abs(mean - expected) <= width * mean
    assert width < 1.0
    assert max(c["products"] - c["deflated"] for c in solution.record["solver"]) <= 15


def slot_transmission(width, depth, rho, n=500):
    """Share of diffuse light that passes a long slot with walls of ρ: strips by crossed strings (Hottel 1954)."""
    x, step = (np.arange(n) + 0.5) / n * depth, depth / n
    apart = np.abs(x[:, None] - x)
    strings = np.hypot(apart + step, width) + np.hypot(apart - step, width) - 2.0 * np.hypot(apart, width)
    from_end = np.diff(np.arange(n + 1) * step - np.hypot(np.arange(n + 1) * step, width)) / 2.0
    exitance = np.linalg.solve(np.eye(n) - rho * strings / (2.0 * step), rho * from_end / step)
    return (np.hypot(depth, width) - depth) / width + 2.0 * (exitance * from_end[::-1]).sum() / width


def rooms_with_a_wall_between(depth, blocks):
    """A room with a lamp and one without, and blocks [low, high] between x = 1 and 1 + depth that make the wall."""
    b = SceneBuilder()
    paint = b.material(0.9)
    b.box((0, 0, 0), (2 + depth, 1, 1), paint, inward=True)
    for low, high in blocks:
        b.box((1, *low), (1 + depth, *high), paint, solid=True)
    b.lamp(b.patch((0.25, 0.25, 0.98), (0, 0.5, 0), (0.5, 0, 0), paint), 1000.0)
    return b


@pytest.mark.slow
@pytest.mark.parametrize("options", [Options(), Options(elements=4000, rays_per_element=512)], ids=("", "many rays"))
@pytest.mark.parametrize(("slit", "depth"), [(0.001, 0.05), (0.01, 0.1)])
def test_case_32_through_a_slit_in_a_wall(device, slit, depth, options):
    """A hundredth to a tenth of the light passes: (1 − ρ) S Ē = s T E, by strips along the slot."""
    rho = 0.9
    b = rooms_with_a_wall_between(depth, [((0, 0), (0.5, 1)), ((0.5 + slit, 0), (1, 1))])
    places = np.array([[0.9999, 0.5 + 0.5 * slit, z] for z in (0.25, 0.75)])
    arriving = unbiased(replace(b.scene(), sensors=(Sensor("slit", places, -WEST),)), device, 16384).irradiance.mean()
    b.sensor(*points_on_walls((1 + depth, 0, 0), (2 + depth, 1, 1), 4))
    found = only(solve(b.scene(), options, device))
    expected = slit * slot_transmission(slit, depth, rho) * arriving / ((1.0 - rho) * 6.0)
    mean, width = found.irradiance.mean(), found.mean_illuminance_half_width / found.mean_illuminance
    assert abs(mean - expected) <= width * mean


HOLE = [((0, 0), (0.5, 1)), ((0.55, 0), (1, 1)), ((0.5, 0), (0.55, 0.5)), ((0.5, 0.55), (0.55, 1))]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("depth", "blocks"),
    [(0.1, [((0, 0), (0.5, 1)), ((0.51, 0), (1, 1))]), (0.3, [((0, 0), (0.5, 1)), ((0.53, 0), (1, 1))]), (0.25, HOLE)],
    ids=("ten times as deep", "wide", "square hole"),
)
def test_case_32_through_slots_of_other_proportions(device, depth, blocks):
    """Against unbiased paths, within the interval and three standard errors."""
    b = rooms_with_a_wall_between(depth, blocks)
    b.sensor(*points_on_walls((1 + depth, 0, 0), (2 + depth, 1, 1), 4))
    scene = b.scene()
    truth = unbiased(scene, device, 1 << 15)
    found = only(solve(scene, Options(elements=4000, rays_per_element=512), device))
    mean, width = found.irradiance.mean(), found.mean_illuminance_half_width / found.mean_illuminance
    assert width < 0.5
    noise = np.sqrt((truth.standard_error**2).sum()) / truth.standard_error.size
    assert abs(mean - truth.irradiance.mean()) <= width * mean + 3.0 * noise


def two_sealed_rooms(both):
    b = SceneBuilder()
    grey = b.material(0.7)
    lit = b.box((0, 0, 0), (1, 1, 1), grey, inward=True)
    if both:
        b.box((1, 0, 0), (2, 1, 1), grey, inward=True)
    b.lamp(lit[5], 1.0)
    b.sensor((0.5, 0.5, 0.5), (0, 0, 1))
    if both:
        b.sensor([(1.5, 0.5, 0.5), (1.001, 0.5, 0.001)], (0, 0, 1))
    return b.scene()


def test_case_33_of_two_sealed_rooms_the_dark_one_is_exactly_dark(device):
    """The lit one has the light that it has alone; that rays prove no wall is in the interval of the other."""
    solution = solve(two_sealed_rooms(True), QUICK, device)
    lit, dark = solution.readings.values()
    assert not dark.irradiance.any()
    assert (dark.half_width < 0.01 * lit.irradiance).all()
    assert len(set(solution.surfaces.space.tolist())) == 1
    alone = only(solve(two_sealed_rooms(False), replace(QUICK, element_size=solution.plan.element_size), device))
    np.testing.assert_allclose(lit.irradiance, alone.irradiance, rtol=0.02)

"""Cases 47, 48 and 50 to 54: sheets with holes, slats, spheres, next to nothing, and a great many small faces."""

from dataclasses import replace

import numpy as np
import pytest
import scene_writing
from rooms import SceneBuilder
from truths import QUICK, read, rectangle_factor, uploaded

from hradiosity.model.geometry import Patches
from hradiosity.options import Options
from hradiosity.radiosity import solve
from hradiosity.space.bvh import STACK_SIZE
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.space.visibility import trace_closest
from hradiosity.transport.device_scene import upload_elements
from hradiosity.transport.direct import direct_at_points
from hradiosity.transport.exchange import build_exchange, trace_rows

HOLES, PITCH = 100, 0.02
OPEN = np.sqrt(0.2) * PITCH
"""Edge of a hole: a fifth of the sheet is open."""


def perforated():
    """A black sheet with 100 × 100 square holes 1 m up, and a lamp of 1 m² above it, 2 m up."""
    b = SceneBuilder()
    black = b.material(0.0)
    side = HOLES * PITCH
    b.lamp(b.patch((-0.5, -0.5, 2.0), (0, 1, 0), (1, 0, 0), black), 1000.0)
    left = np.arange(HOLES) * PITCH - 0.5 * side
    closed = PITCH - OPEN
    for y in left:
        b.patch((-0.5 * side, y, 1.0), (side, 0, 0), (0, closed, 0), black)
        for x in left:
            b.patch((x, y + closed, 1.0), (closed, 0, 0), (0, OPEN, 0), black)
    return b, left + closed


def corner_factor(x, y):
    """Form factor, at a height of 2, to the rectangle from the point straight below a corner to (x, y); odd in both."""
    a, b = np.hypot(x, 2.0), np.hypot(y, 2.0)
    return (x / a * np.arctan(y / a) + y / b * np.arctan(x / b)) / (2.0 * np.pi)


def through_holes(point, low):
    """Exact light of that lamp: what each hole, seen from the point, leaves of it."""
    first, last = (np.clip(point[:2] + 2.0 * (edge[:, None] - point[:2]), -0.5, 0.5) for edge in (low, low + OPEN))
    x, y = (np.stack([first[:, k], last[:, k]]) - point[k] for k in (0, 1))
    corners = corner_factor(x[:, None, :, None], y[None, :, None, :])
    return 1000.0 * (corners[1, 1] - corners[0, 1] - corners[1, 0] + corners[0, 0]).sum()


@pytest.mark.slow
def test_case_47_a_lamp_behind_a_sheet_of_ten_thousand_holes(device):
    """A fifth of it shows, in pieces: the exact light lies in the interval, and few rays say that they are few."""
    b, low = perforated()
    places = np.array([(0.0, 0.0, 0.0), (0.113, 0.207, 0.0), (-0.37, 0.119, 0.0), (0.301, -0.257, 0.0)])
    exact = np.array([through_holes(p, low) for p in places])
    bare = [1000.0 * rectangle_factor(p, (0, 0, 1), (-0.5, -0.5, 2), (1, 0, 0), (0, 1, 0)) for p in places]
    np.testing.assert_allclose(exact / bare, 0.2, atol=0.01)
    b.sensor(places, (0, 0, 1))
    scene = b.scene()
    widths = []
    for samples in (16, 4096):
        found = read(scene, device, replace(QUICK, light_samples=samples))
        error = np.abs(found.irradiance[:, 0] - exact)
        assert (error <= 1.5 * found.half_width[:, 0]).all()
        widths.append((found.half_width[:, 0] / exact).max())
    assert widths[0] > 0.2 and widths[1] < 0.12


def test_case_48_regular_slats_do_not_resonate_with_the_samples(device):
    """64 slats, 512 scrambles of few samples: the mean over scrambles is the exact light of what the gaps leave."""
    b = SceneBuilder()
    black = b.material(0.0)
    b.lamp(b.patch((-0.5, -0.5, 2.0), (0, 1, 0), (1, 0, 0), black), 1000.0)
    for k in range(-32, 32):
        b.patch((k / 64.0, -1.0, 1.0), (1.0 / 128.0, 0, 0), (0, 2.0, 0), black)
    places = np.array([(0.0, 0.0, 0.0), (0.003, 0.1, 0.0), (0.1, 0.2, 0.0)])
    b.sensor(places, (0, 0, 1))
    exact = []
    for p in places:
        gaps = p[0] + 2.0 * (np.arange(-40, 40) / 64.0 + 1.0 / 128.0 - p[0])
        low, high = np.clip(gaps, -0.5, 0.5), np.clip(gaps + 1.0 / 64.0, -0.5, 0.5)
        kept = [(a, z) for a, z in zip(low, high) if z > a]
        exact.append(
            sum(1000.0 * rectangle_factor(p, (0, 0, 1), (a, -0.5, 2), (z - a, 0, 0), (0, 1, 0)) for a, z in kept)
        )
    scene = b.scene()
    on_device = uploaded(scene, device)
    normal = scene.sensors[0].normal
    for n in (16, 32, 64):
        found = 1000.0 * np.stack([direct_at_points(on_device, places, normal, n, seed)[:, 0] for seed in range(512)])
        error = found.std(axis=0, ddof=1) / np.sqrt(512.0)
        assert (np.abs(found.mean(axis=0) - exact) <= 3.5 * error).all()
        assert (error < 0.015 * np.array(exact)).all()


def sphere(levels, radius=1.0):
    """(n, 3, 3) corners of an icosahedron whose faces were quartered and pushed out, counter-clockwise from inside."""
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    vertex = np.array([v for s in (-1, 1) for t in (-golden, golden) for v in ((0, s, t), (s, t, 0), (t, 0, s))], float)
    from scipy.spatial import ConvexHull

    corners = vertex[ConvexHull(vertex).simplices]
    corners /= np.linalg.norm(corners, axis=2, keepdims=True)
    for _ in range(levels):
        a, b, c = corners.transpose(1, 0, 2)
        ab, bc, ca = (0.5 * (p + q) for p, q in ((a, b), (b, c), (c, a)))
        corners = np.concatenate([np.stack(f, axis=1) for f in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        corners /= np.linalg.norm(corners, axis=2, keepdims=True)
    outward = np.einsum(
        "ni,ni->n", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), corners[:, 0]
    )
    corners[outward > 0.0] = corners[outward > 0.0][:, ::-1]
    return radius * corners


def add_triangles(b, corners, material):
    return [b.patch(t[0], t[1] - t[0], t[2] - t[0], m, triangle=True) for t, m in zip(corners, material)]


def test_case_50_integrating_sphere_with_a_port(device):
    """E = (Φ/S) / (1 − ρ (1 − f)): the multiplier of a sphere of ρ = 0.9 whose port absorbs a share f of about 1 %."""
    rho = 0.9
    corners = sphere(3)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    height = corners.mean(axis=1)[:, 2]
    is_port = height < np.sort(height)[int(0.01 * len(height))]
    share = area[is_port].sum() / area.sum()
    assert share == pytest.approx(0.01, abs=0.003)
    b = SceneBuilder()
    paint, port = b.material(rho), b.material(0.0)
    add_triangles(b, corners, np.where(is_port, port, paint))
    b.point((0.0, 0.0, 0.0), 1.0)
    solution = solve(b.scene(), Options(elements=1500, rays_per_element=256, light_points=64), device)
    weight = solution.elements.area
    mean = weight @ solution.surfaces.irradiance[:, 0] / weight.sum()
    expected = 4.0 * np.pi / area.sum() / (1.0 - rho * (1.0 - share))
    assert mean == pytest.approx(expected, rel=1e-3)


def test_case_51_a_group_that_sees_itself(device):
    """Elements of many small faces of a sphere: their rows have a diagonal, close, and keep the energy."""
    corners = sphere(3)
    b = SceneBuilder()
    paint = b.material(0.8)
    b.lamp(add_triangles(b, corners, [paint] * len(corners)), 0.2)
    scene = b.scene()
    on_device = uploaded(scene, device)
    lit = find_lit_sides(scene, on_device.bvh)
    elements = build_elements(scene.patches, lit.space, np.ones(1, bool), 0.7)
    assert len(elements) < len(corners) / 4
    assert elements.area.sum() == pytest.approx(scene.patches.area.sum(), rel=1e-6)
    hits = trace_rows(on_device, upload_elements(device, elements), 1024, seed=1)
    exchange = build_exchange(hits, elements)
    row = np.repeat(np.arange(len(elements)), np.diff(exchange.start.astype(int)))
    own = np.bincount(row, exchange.area * (exchange.source == row), minlength=len(elements))
    sums = np.bincount(row, exchange.area, minlength=len(elements))
    np.testing.assert_allclose(sums, exchange.element_area, rtol=1e-9)
    share = own / exchange.element_area
    np.testing.assert_allclose(share.mean(), (elements.area / elements.area.sum()).mean(), rtol=0.2)
    solution = solve(scene, replace(QUICK, element_size=0.7), device)
    np.testing.assert_allclose(solution.surfaces.irradiance, 1.0, rtol=1e-5)


def test_case_52_no_surfaces_and_no_lights_are_refused(tmp_path):
    lamp = "[[point_source]]\nname = 'bulb'\nposition = [0, 0, 1]\nluminaire = 'lamp'\n"
    header = scene_writing.HEADER + scene_writing.PAINT + scene_writing.LAMP
    (fault,) = scene_writing.faults(tmp_path, header + lamp.replace("0, 0, 1", "0.0, 0.0, 1.0"))
    assert "no surface; at least one [[rectangle]], [[polygon]], [[box]] or [[mesh]]" in fault
    (fault,) = scene_writing.faults(tmp_path, scene_writing.HEADER + scene_writing.PAINT + scene_writing.FLOOR)
    assert "nothing gives light; a `luminaire` on a surface, a [[point_source]] or a [sky]" in fault


def test_case_52_one_triangle_and_no_sensors(device):
    b = SceneBuilder()
    b.patch((0, 0, 0), (1, 0, 0), (0, 1, 0), b.material(0.5), triangle=True)
    b.point((0.25, 0.25, 2.0), 8.0)
    blind = solve(b.scene(), QUICK, device)
    assert blind.readings == {}
    area = blind.elements.area
    x, y, w = gauss_points()
    exact = (w * 8.0 * 2.0 / ((x - 0.25) ** 2 + (y - 0.25) ** 2 + 4.0) ** 1.5).sum()
    assert area @ blind.surfaces.irradiance[:, 0] / area.sum() == pytest.approx(exact, rel=1e-3)
    b.sensor((0.25, 0.25, 0.0), (0, 0, 1))
    readings = read(b.scene(), device)
    assert readings.irradiance[0, 0] == pytest.approx(2.0, rel=1e-5) and readings.half_width[0, 0] < 1e-4


def test_case_52_a_point_source_behind_a_sensor_and_nothing_else(device):
    b = SceneBuilder()
    b.point((0.0, 0.0, 1.0), 8.0)
    b.sensor([(0.0, 0.0, 0.0), (0.0, 0.0, 2.0)], (0, 0, 1))
    readings = read(b.scene(), device)
    np.testing.assert_allclose(readings.irradiance[:, 0], [8.0, 0.0], rtol=1e-5)
    assert readings.half_width[1, 0] == 0.0


def gauss_points():
    """Gauss points and weights, of sum 1, on the triangle (0, 0), (1, 0), (0, 1), by Duffy's map."""
    n = 64
    node, weight = np.polynomial.legendre.leggauss(n)
    u, v = np.meshgrid(0.5 + 0.5 * node, 0.5 + 0.5 * node)
    w = 0.25 * np.outer(weight, weight) * (1.0 - u.T)
    return u.T, v.T * (1.0 - u.T), 2.0 * w


def patches_of_triangles(origin, edge_u, edge_v):
    n = len(origin)
    zeros = np.zeros(n, np.int32)
    return Patches(
        origin, edge_u, edge_v, np.ones(n, bool), zeros, zeros, np.arange(n, dtype=np.int32), zeros - 1
    )  # fmt: skip


@pytest.mark.slow
def test_case_53_a_million_triangles_of_a_millimetre_in_one_heap(device):
    """The hierarchy is shallow, its stack can't overflow, and rays meet what they are aimed at."""
    n = 1_000_000
    rng = np.random.default_rng(2)
    edges = rng.normal(size=(2, n, 3))
    edges *= 1e-3 / np.linalg.norm(edges, axis=2, keepdims=True)
    patches = patches_of_triangles(rng.normal(scale=0.05, size=(n, 3)), *edges)
    bvh = build_bvh(device, patches)
    assert bvh.depth < 64 and 7 * bvh.depth + 8 <= STACK_SIZE
    aim = patches.centroid[:2000]
    hits = trace_closest(bvh, aim + 2e-6 * patches.normal[:2000], -patches.normal[:2000])
    assert (hits.patch == np.arange(2000)).mean() > 0.99
    assert np.isfinite(trace_closest(bvh, np.zeros((2000, 3)), rng.normal(size=(2000, 3))).t).mean() > 0.9


def test_case_54_triangles_that_all_have_one_centroid(device):
    """No split by place tells them apart: halved, and each ray meets the nearest one, found here by brute force."""
    n = 500
    rng = np.random.default_rng(3)
    corners = rng.normal(size=(n, 3, 3))
    corners -= corners.mean(axis=1, keepdims=True)
    corners += [1.0, 2.0, 3.0]
    patches = patches_of_triangles(corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    np.testing.assert_allclose(patches.centroid, np.tile([1.0, 2.0, 3.0], (n, 1)), rtol=1e-12)
    bvh = build_bvh(device, patches)
    assert bvh.depth <= 12
    origin = rng.normal(scale=6.0, size=(300, 3)) + [1, 2, 3]
    direction = rng.normal(scale=0.5, size=(300, 3)) + [1, 2, 3] - origin
    hits = trace_closest(bvh, origin, direction)
    t = nearest(patches, origin, direction)
    met = np.isfinite(t)
    assert met.sum() > 100
    assert ((hits.patch >= 0) == met).mean() > 0.99
    both = met & (hits.patch >= 0)
    np.testing.assert_allclose(hits.t[both], t[both], rtol=2e-5)


def nearest(patches, origin, direction):
    """Distance to the first triangle in float64 (Möller and Trumbore 1997)."""
    across = np.cross(direction[:, None], patches.edge_v)
    det = np.einsum("rnd,nd->rn", across, patches.edge_u)
    away = origin[:, None] - patches.origin
    u = np.einsum("rnd,rnd->rn", away, across) / det
    other = np.cross(away, patches.edge_u)
    v = np.einsum("rnd,rd->rn", other, direction) / det
    t = np.einsum("rnd,nd->rn", other, patches.edge_v) / det
    return np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0), t, np.inf).min(axis=1)

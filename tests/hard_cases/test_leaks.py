"""Hard cases 22 to 25: cracks, T-junctions, sealed boxes, contact, surfaces in one place."""

from itertools import pairwise

import numpy as np
import pytest
from check_rooms import LAMP, ROOM, SOUND, box, findings, grave, of_kind, rectangle
from ray_scenes import from_triangles, sphere_triangles
from rooms import SceneBuilder, moved
from scipy.spatial.transform import Rotation

from hradiosity import Options, solve
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.visibility import trace_any, trace_closest

OPTIONS = Options(elements=1500, gather_samples=2048, light_samples=128, rays_per_element=64)
TURN = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
UP = (0.0, 0.0, 1.0)
FLOOR = 4


def walls_with_t_junctions(seed, crack=0.0):
    """A unit cube whose faces are each cut at other places: no corner inside an edge has a partner across it.

    crack : by which every piece is too short [m]
    """
    rng = np.random.default_rng(seed)
    b = SceneBuilder()
    paint = [b.material(rho) for rho in rng.uniform(0.1, 0.9, 5)]
    faces = SceneBuilder()
    faces.box((0, 0, 0), (1, 1, 1), faces.material(0.0), inward=True)
    for origin, u, v, *_ in faces.rows:
        cuts = np.concatenate([[0.0], np.sort(rng.uniform(0.05, 0.95, 3)), [1.0]])
        for low, high in pairwise(cuts):
            across = np.concatenate([[0.0], np.sort(rng.uniform(0.05, 0.95, 2)), [1.0]])
            for left, right in pairwise(across):
                corner = origin + low * u + left * v
                b.patch(corner, (high - low - crack) * u, (right - left - crack) * v, paint[rng.integers(5)])
    return b


def escapes(device, scene, n, seed=0):
    """Share of rays that leave a unit cube, from everywhere in it in all directions."""
    rng = np.random.default_rng(seed)
    bvh = build_bvh(device, scene.patches)
    origin, direction = rng.uniform(0.01, 0.99, (n, 3)), rng.normal(size=(n, 3))
    return np.count_nonzero(trace_closest(bvh, origin, direction).patch < 0) / n


@pytest.mark.parametrize("crack", [0.0, 1e-6], ids=["22-t-junctions", "22-cracks-1e-6"])
def test_case_22_light_stays_in_a_room_with_seams(device, crack):
    """What escapes is what the cracks are of the walls, below 1e-5; M = 1 − ρ everywhere makes E = 1 but for that."""
    b = walls_with_t_junctions(3, crack)
    for patch in range(len(b.rows)):
        b.lamp(patch, 1.0 - b.materials[b.rows[patch][4]].reflectance)
    b.sensor([(0.5, 0.5, 0.5), (0.01, 0.5, 0.5), (0.3, 0.7, 0.0)], [UP, (1, 0, 0), UP])
    scene = b.scene()
    open_share = 1.0 - scene.patches.area.sum() / 6.0
    assert open_share < 1e-5
    n = 1_000_000
    assert escapes(device, scene, n) < max(1e-6, open_share + 4.0 * np.sqrt(open_share / n))
    solution = solve(scene, OPTIONS, device)
    np.testing.assert_allclose(solution.readings["s0"].irradiance, 1.0, rtol=1e-4)
    light = np.average(solution.surfaces.irradiance[:, 0], weights=solution.elements.area)
    assert light == pytest.approx(1.0, abs=1e-4)


def shots_at_edges(rng, corners, n):
    """Rays from the middle to points of the triangles' edges, a tenth of them to the corners themselves."""
    triangle, corner = rng.integers(len(corners), size=n), rng.integers(3, size=n)
    share = np.where(rng.random(n) < 0.1, 0.0, rng.random(n))[:, None]
    target = corners[triangle, corner] * (1 - share) + corners[triangle, (corner + 1) % 3] * share
    origin = corners.mean(axis=(0, 1)) + rng.uniform(-0.3, 0.3, (n, 3))
    return origin, target - origin


def rays_lost_at_shared_edges(device, n):
    """Of a closed body of triangles a thousand metres off and turned, by both kinds of rays."""
    rng = np.random.default_rng(22)
    corners = sphere_triangles(rng, 30) @ TURN.T + [1e3, -2e3, 5e2]
    bvh = build_bvh(device, from_triangles(corners))
    lost = 0
    for _ in range(0, n, 1_000_000):
        origin, direction = shots_at_edges(rng, corners, min(n, 1_000_000))
        lost += np.count_nonzero(trace_closest(bvh, origin, direction).patch < 0)
        lost += np.count_nonzero(~trace_any(bvh, origin, direction))
    return lost


def test_case_22_shared_edges_are_tight(device):
    assert rays_lost_at_shared_edges(device, 200_000) == 0


@pytest.mark.slow
def test_case_22_shared_edges_are_tight_in_ten_million_rays(device):
    assert rays_lost_at_shared_edges(device, 10_000_000) == 0


PLACES = {
    "as it is": {},
    "a million metres off": {"shift": np.array([1e6, -1e6, 1e5])},
    "turned": {"rotation": TURN},
    "of millimetres": {"factor": 1e-3},
    "turned, of kilometres": {"rotation": TURN, "factor": 1e3},
}


def sealed_box(bright):
    """A box with a solid block in it stands in a room whose walls and ceiling shine, touching its floor."""
    b = SceneBuilder()
    grey = b.material(0.8)
    room = b.box((0, 0, 0), (4, 3, 2.5), grey, inward=True)
    b.box((1, 1, 0), (2.3, 2.1, 1.1), grey)
    b.box((1.2, 1.2, 0), (1.5, 1.4, 0.7), grey, solid=True)
    b.lamp([patch for patch in room if patch != FLOOR], bright)
    inside = [(1.8, 1.5, 0.5), (1.001, 1.001, 0.001), (1.35, 1.3, 0.7), (2.299, 2.0, 1.099), (2.0, 2.0, 0.0)]
    b.sensor(inside, [UP, UP, UP, (-1, 0, 0), UP], "inside")
    b.sensor([(0.5, 0.5, 0.5)], UP, "outside")
    return b.scene()


@pytest.mark.parametrize("place", PLACES, ids="23-{}".format)
def test_case_23_a_sealed_box_is_dark_inside(device, place):
    for glow in (True, False):
        options = Options(elements=1000, gather_samples=256, light_samples=32, glow=glow)
        solution = solve(moved(sealed_box(1e6), **PLACES[place]), options, device)
        assert (solution.readings["inside"].irradiance == 0.0).all()
        assert solution.readings["outside"].irradiance[0, 0] > 1e6


def room_with_touching_boxes(solid, shines):
    """A box stands flush on the floor, another in the corner.

    solid : the first box is one; else it is five faces without a bottom
    shines : every surface sends out 1 − ρ, so that E = 1 whatever stands where; else only the ceiling does
    """
    b = SceneBuilder()
    walls = b.box((0, 0, 0), (3, 4, 2.5), [b.material(rho) for rho in (0.2, 0.8, 0.5, 0.3, 0.7, 0.6)], inward=True)
    b.box((0, 0, 0), (0.5, 0.5, 0.5), b.material(0.9), solid=True)
    faces = b.box((1, 1, 0), (2, 2, 1), b.material(0.4), solid=solid)
    if not solid:
        del b.rows[faces[FLOOR]]
    for patch in range(len(b.rows)) if shines else [walls[5]]:
        b.lamp(patch, 1.0 - b.materials[b.rows[patch][4]].reflectance)
    gaps = (1e-4, 1e-3, 1e-2, 0.1)
    b.sensor([(1.0 - gap, 1.5, 0.0) for gap in gaps] + [(0.5 + gap, 0.3, 0.0) for gap in gaps], UP, "floor")
    b.sensor([(1.0, 1.5, gap) for gap in gaps] + [(0.5, 0.2, gap) for gap in gaps], [(-1, 0, 0)] * 4 + [(1, 0, 0)] * 4)
    if not solid:
        b.sensor([(1.5, 1.5, 0.0), (1.001, 1.001, 0.0), (1.01, 1.5, 0.01), (1.5, 1.5, 0.9)], UP, "under")
    return b.scene()


@pytest.mark.parametrize("solid", [True, False], ids=["24-solid", "24-without-bottom"])
def test_case_24_light_next_to_a_contact(device, solid):
    """E = 1 down to 0.1 mm from the line where box and floor touch: exactly in even light, else as stated."""
    options = Options(elements=2000, gather_samples=4096, light_samples=1024, rays_per_element=128, glow=False)
    sampled = solve(room_with_touching_boxes(solid, True), options, device)
    even = solve(room_with_touching_boxes(solid, True), Options(elements=1000, gather_samples=1024, glow=True), device)
    for name in ("floor", "s1"):
        readings = sampled.readings[name]
        error = readings.irradiance - 1.0
        assert (np.abs(error) < 1.5 * readings.half_width + 2e-3).all()
        assert abs(error.mean()) < 0.02 and readings.half_width.max() < 0.1
        np.testing.assert_allclose(even.readings[name].irradiance, 1.0, rtol=1e-4)


def test_case_24_nothing_gets_under_a_touching_box(device):
    for place in PLACES.values():
        scene = moved(room_with_touching_boxes(False, False), **place)
        solution = solve(scene, Options(elements=1000, gather_samples=256, light_samples=32), device)
        assert (solution.readings["under"].irradiance == 0.0).all()
        assert solution.readings["floor"].irradiance.min() > 0.0


PAIRS = {
    "25-rug-in-the-floor": (rectangle("rug", (1, 1, 0), (1, 0, 0), (0, 2, 0)), "coincident-surfaces", "2 m²"),
    "25-half-a-millionth-above": (
        rectangle("rug", (1, 1, 5e-7), (1, 0, 0), (0, 2, 0)),
        "coincident-surfaces",
        "2 m²",
    ),
    "25-lamp-in-the-ceiling": (
        rectangle("rug", (1, 1, 2.5), (0, 2, 0), (1, 0, 0), luminaire="lamp"),
        "lamp-in-surface",
        "2 m²",
    ),
    "25-picture-in-the-wall": (
        rectangle("rug", (0, 1, 1), (0, 1, 0), (0, 0, 0.5), material="other"),
        "coincident-surfaces",
        "0.5 m²",
    ),
}


@pytest.mark.parametrize(("added", "kind", "area"), PAIRS.values(), ids=PAIRS)
def test_case_25_surfaces_in_one_place_are_named(device, tmp_path, added, kind, area):
    found = findings(device, tmp_path, SOUND + added)
    assert grave(found) == [kind]
    (finding,) = of_kind(found, kind)
    assert "'rug'" in finding.message and "'room'" in finding.message and area in finding.message
    assert "1 mm" in finding.fix


def test_case_25_boxes_that_share_a_face_plane(device, tmp_path):
    """Two that overlap with tops in one plane are named; two that merely touch, face to face, are not."""
    one = box("chest", (1, 1, 0), (1, 1, 0.5))
    (finding,) = of_kind(findings(device, tmp_path, ROOM + LAMP + one + box("crate", (1.5, 1.5, 0), (1, 1, 0.5))),
                         "coincident-surfaces")  # fmt: skip
    assert "'chest'" in finding.message and "'crate'" in finding.message and "0.25 m²" in finding.message
    assert grave(findings(device, tmp_path, ROOM + LAMP + one + box("crate", (2, 1, 0), (1, 1, 0.5)))) == []

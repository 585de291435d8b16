"""What proofs of sight do to direct light, and what the plan says of them."""

import numpy as np
from rooms import SceneBuilder

from hradiosity.options import Options
from hradiosity.planning import make_plan
from hradiosity.radiosity.record import Record
from hradiosity.radiosity.solver import RadiositySolver
from hradiosity.radiosity.surfaces import SurfaceSolver
from hradiosity.reference.point_factors import points_to_polygon
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.space.shafts import FREE, HIDDEN, UNKNOWN
from hradiosity.transport.device_scene import upload_scene
from hradiosity.transport.direct import direct_at_points, direct_on_rows
from hradiosity.transport.exchange import trace_rows

LAMP = np.array([[1.5, 1.5, 2.9], [1.5, 2.5, 2.9], [2.5, 2.5, 2.9], [2.5, 1.5, 2.9]])
OPTIONS = Options(
    element_size=0.5, rays_per_element=64, light_points=16, light_samples=64, gather_samples=256, replicates=4
)


def two_rooms() -> SceneBuilder:
    """A furnished room, and an empty one beside it that shares nothing with it."""
    b = SceneBuilder()
    paint = b.material(0.5)
    b.box((0, 0, 0), (4, 4, 3), paint, inward=True)
    b.box((0.5, 2.5, 0), (1.5, 3.5, 1.0), paint, solid=True)
    b.lamp(b.patch(LAMP[0], LAMP[1] - LAMP[0], LAMP[3] - LAMP[0], paint), 1.0)
    b.box((6, 0, 0), (9, 4, 3), paint, inward=True)
    b.lamp(len(b.rows) - 1, 1.0)
    b.sensor([[2.0, 1.0, 0.5], [3.0, 2.0, 0.0], [7.0, 2.0, 1.0]], (0.0, 0.0, 1.0))
    return b


def surface_solver(device, options):
    scene = two_rooms().scene()
    bvh = build_bvh(device, scene.patches)
    lit = find_lit_sides(scene, bvh)
    return SurfaceSolver(device, scene, bvh, lit, make_plan(scene, options, lit), options, Record())


def test_rows_proved_free_take_the_closed_form(device):
    solver = surface_solver(device, OPTIONS)
    elements = solver.on_device_elements
    hits = trace_rows(solver.on_device, elements, 64, 3)
    found = direct_on_rows(solver.on_device, elements, hits, 16, 3)
    clear = direct_on_rows(solver.on_device.without_occlusion(), elements, hits, 16, 3)
    assert (solver.sight == FREE).mean() > 0.2
    np.testing.assert_allclose(found[solver.sight == FREE], clear[solver.sight == FREE], rtol=1e-5)
    assert (clear[solver.sight == HIDDEN] == 0.0).all()
    assert (solver.sight == UNKNOWN).any()


def test_points_proved_free_have_no_noise(device):
    scene = two_rooms().scene()
    position = np.random.default_rng(0).uniform([2.6, 0.2, 0.0], [3.8, 1.2, 2.5], (200, 3))
    normal = np.broadcast_to([0.0, 0.0, 1.0], position.shape)
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    found = direct_at_points(on_device, position, normal, 64, 1)[:, 0]
    np.testing.assert_allclose(found, points_to_polygon(position, normal, LAMP), rtol=1e-5, atol=1e-7)


def test_results_agree_with_those_of_all_rays(device):
    runs = []
    for forced in (None, True):
        options = Options(**{**OPTIONS.__dict__, "occlusion": forced})
        solver = RadiositySolver(two_rooms().scene(), options, device)
        for _ in solver.states():
            pass
        runs.append((solver, solver.solution().readings["s0"]))
    (proved, ours), (traced, theirs) = runs
    assert proved.record.rays < traced.record.rays
    bound = np.hypot(ours.illuminance_half_width, theirs.illuminance_half_width)
    assert (np.abs(ours.illuminance - theirs.illuminance) <= bound + 1e-5 * theirs.illuminance).all()


def test_plan_says_which_lamps_are_free(device):
    lines = RadiositySolver(two_rooms().scene(), OPTIONS, device).plan.lines()
    assert any("proved free by shafts" in line for line in lines)
    assert sum("free everywhere" in line for line in lines) == 1
    assert any(line.startswith("lamp 'l1' in space") for line in lines)
    forced = Options(**{**OPTIONS.__dict__, "occlusion": True})
    assert "as asked for" in RadiositySolver(two_rooms().scene(), forced, device).plan.lines()[0]

"""Every kernel once with tiny arrays, for the memory checker; see README for how to run it.

The checker's own log must stay empty. The numbers are looked at as well: another make of driver computed them.
"""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rooms import cube

from hradiosity.model.scene import View
from hradiosity.model.sensor_kinds import curved_sensor
from hradiosity.options import Options
from hradiosity.planning import make_plan
from hradiosity.radiosity.record import Record
from hradiosity.radiosity.surfaces import SurfaceSolver
from hradiosity.readings.effort import Effort
from hradiosity.readings.guide_pilot import make_guides
from hradiosity.readings.path_tracing import PathRules, upload_points
from hradiosity.readings.paths import trace_referee
from hradiosity.readings.pilot_light import PilotLight, brightness_met
from hradiosity.readings.sensors import read_points
from hradiosity.show.camera import trace_view
from hradiosity.show.image import gather_image
from hradiosity.solution import Solution
from hradiosity.solvers.link_operator import LinkOperator
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.lit_sides import LitSides
from hradiosity.space.nodes import build_nodes
from hradiosity.transport import lamp_choice
from hradiosity.transport.cell_pairs import CellPairs
from hradiosity.transport.device_scene import upload_elements, upload_scene
from hradiosity.transport.direct import direct_on_rows
from hradiosity.transport.exchange import trace_rows
from hradiosity.transport.form_factor.hemicube import Hemicube
from hradiosity.transport.form_factor.interface import form_factor
from hradiosity.transport.form_factor.methods import METHODS
from hradiosity.transport.link_exchange import build_link_exchange, link_nodes
from hradiosity.transport.links import LinkFinder, Refinement
from hradiosity.transport.pair_sight import open_share

pytestmark = pytest.mark.oclgrind
LOG = Path(os.environ.get("OCLGRIND_LOG", os.devnull))
"""Where the checker writes what it finds."""


@pytest.fixture(autouse=True)
def empty_log(device):
    """The test at which the checker complains fails."""
    if "oclgrind" in device.info.platform.lower() and "OCLGRIND_LOG" not in os.environ:
        pytest.fail("nobody would read what the checker finds: give oclgrind the option --log")
    before = LOG.read_text() if LOG.is_file() else ""
    yield
    assert (LOG.read_text() if LOG.is_file() else "") == before


def furnished_cube(bands):
    """A lit cube with a solid block that casts shadows and covers a part of the floor, and two readings."""
    room = cube(0.5, bands)
    room.box((0.3, 0.3, 0.0), (0.7, 0.6, 0.4), 0, solid=True)
    room.lamp(room.patch((0.2, 0.2, 0.99), (0.0, 0.3, 0.0), (0.3, 0.0, 0.0), 0), 1.0)
    room.point((0.8, 0.8, 0.8), 0.1)
    room.sensor([[0.2, 0.5, 0.1], [0.9, 0.2, 0.3]], (0.0, 0.0, 1.0))
    return room.scene()


def lit_fronts(scene):
    """The front sides are lit, without asking any ray."""
    lit = np.array([[True, False]] * len(scene.patches))
    return LitSides(
        lit=lit,
        space=np.where(lit, 0, -1).astype(np.int32),
        open=np.array([False]),
        free_path=0.5,
        slots=np.zeros(lit.shape, np.int64),
    )


@pytest.mark.parametrize("bands", [1, 11])
def test_a_replicate(device, bands):
    """Exchange, direct light, solution, readings; eleven paints that differ fill two groups of eight columns partly."""
    scene = furnished_cube(bands)
    scene.materials[0].reflectance[:] = np.linspace(0.3, 0.6, bands)
    options = Options(
        element_size=1.0, rays_per_element=32, light_points=2, light_samples=2, gather_samples=4, replicates=2
    )
    lit = lit_fronts(scene)
    plan = make_plan(scene, options, lit)
    solver = SurfaceSolver(device, scene, build_bvh(device, scene.patches), lit, plan, options, Record())
    light = solver.replicate(1)
    sensor, few = scene.sensors[0], np.array([4, 2])
    points = upload_points(solver.on_device, sensor.position, sensor.normal)
    place = solver.on_device, solver.on_device_elements
    guides = make_guides(
        PilotLight(*place, points, brightness_met(*place, light), 1, np.zeros((2, 0), int)), np.zeros(2), 512
    )
    assert len(guides.key) > 0
    rays = np.repeat([[4.0], [0.5]], solver.on_device.n_emitters, axis=1)
    samples = read_points(
        solver.on_device,
        solver.on_device_elements,
        light,
        sensor.position,
        sensor.normal,
        Effort(rays, rays > 2.0, few, guides, np.array([1, 3])),
        rules=PathRules(1, 0.5, 1.0),
        seed=1,
    )
    irradiance = plan.columns.to_bands(samples.irradiance)
    assert irradiance.shape == (2, bands)
    assert (irradiance > 0.0).all()
    assert (np.diff(irradiance, axis=1) >= 0.0).all()


def test_an_image(device):
    """Tables and pixels with spectra, from a solution without readings; a lamp, a solid and a guide each."""
    scene, lit = replace(furnished_cube(1), sensors=()), lit_fronts(furnished_cube(1))
    options = Options(element_size=1.0, rays_per_element=32, light_points=2, replicates=2)
    plan = make_plan(scene, options, lit)
    solver = SurfaceSolver(device, scene, build_bvh(device, scene.patches), lit, plan, options, Record())
    solver.replicate(1)
    record = {"options": {"seed": 0}}
    solution = Solution(scene, plan, solver.elements, solver.surfaces(), {}, 1, True, record)
    view = View("v", np.array([0.1, 0.1, 0.5]), np.array([0.8, 0.7, -0.2]), np.array([0.0, 0.0, 1.0]), 80.0, 4, 3)
    image = gather_image(solution, device, view, samples=4, spectra=True, on_device=solver.on_device)
    assert image.spectrum.shape == (3, 4, 1) and (image.xyz[..., 1] > 0.0).all()


def test_readings_that_weigh_directions(device):
    """Direct light and paths of a sphere's planes, by the solver and without bias."""
    place = np.array([[0.8, 0.2, 0.5]])
    ball = curved_sensor("ball", place, "spherical", axis=np.array([0.0, 0.0, 1.0]))
    scene = replace(furnished_cube(1), sensors=(ball,))
    options = Options(
        element_size=1.0, rays_per_element=32, light_points=2, light_samples=2, gather_samples=4, replicates=2
    )
    lit = lit_fronts(scene)
    plan = make_plan(scene, options, lit)
    solver = SurfaceSolver(device, scene, build_bvh(device, scene.patches), lit, plan, options, Record())
    samples = read_points(
        solver.on_device,
        solver.on_device_elements,
        solver.replicate(1),
        ball.position,
        ball.normal,
        Effort.even((4, solver.on_device.n_emitters), 4, 4, lookup=1),
        rules=PathRules(1, 0.5, 1.0),
        seed=1,
        response=ball.parts.response,
    )
    on_device = solver.on_device
    paths = trace_referee(
        on_device, scene, ball.position, ball.normal, paths=8, seed=1, scrambles=2, response=ball.parts.response
    )
    for found in (samples.irradiance, paths.irradiance):
        assert np.isfinite(found).all()
        assert found.sum() > 0.0


def test_lamps_tried_by_chance(device, monkeypatch):
    """What each lamp could send without obstacles, and direct light of those that are tried."""
    monkeypatch.setattr(lamp_choice, "TRIED", 0.5)
    scene = furnished_cube(1)
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    elements = build_elements(scene.patches, lit_fronts(scene).space, np.ones(len(scene.materials), bool), 1.0)
    uploaded = upload_elements(device, elements)
    clear, emission = (
        lamp_choice.light_without_obstacles(on_device, uploaded, roughly=True),
        np.ones((2, 8), np.float32),
    )
    chance = lamp_choice.lamp_probability(on_device, clear, emission, None)
    assert chance is not None and (chance >= lamp_choice.LEAST_PROBABILITY).all() and chance.min() < 0.5
    hits = trace_rows(on_device, uploaded, 8, 1)
    direct = direct_on_rows(on_device, uploaded, hits, 2, 1, device.upload(chance))
    assert (direct >= 0.0).all() and direct.any() and (direct == 0.0).any()
    sums = lamp_choice.drawn_at_hits(on_device, device.upload(direct), device.upload(clear), emission)
    assert (np.diff(device.fetch(sums), axis=1) > 0.0).all()


def test_unbiased_paths(device):
    scene = furnished_cube(3)
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    sensor = scene.sensors[0]
    samples = trace_referee(
        on_device, scene, sensor.position, sensor.normal, paths=8, seed=1, scrambles=2, depth_limit=4
    )
    assert (samples.irradiance > 0.0).all()
    np.testing.assert_allclose(samples.irradiance, samples.irradiance[:, :1].repeat(3, axis=1), rtol=1e-5)


def test_hemicube(device):
    scene = furnished_cube(1)
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    elements = build_elements(scene.patches, lit_fronts(scene).space, np.ones(len(scene.materials), bool), 0.5)
    sensor = scene.sensors[0]
    views = Hemicube(on_device, scene.patches, elements, 8).views(sensor.position, sensor.normal, np.array([0.3, 1.7]))
    total = np.asarray(views.factor.sum(axis=1)).ravel() + views.covered + views.unlit
    np.testing.assert_allclose(total, 1.0, atol=1e-5)


def test_camera(device):
    scene = furnished_cube(1)
    view = View("in", np.array([0.5, 0.05, 0.5]), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]), 70.0, 6, 4)
    hits = trace_view(build_bvh(device, scene.patches), view, 1)
    assert (hits.side >= 0).all()
    assert np.isfinite(hits.depth).all()


def test_form_factors_of_pairs(device):
    """Every method, with a card between; a pentagon fills its row of corners partly."""
    angle = 2.0 * np.pi * np.arange(5) / 5.0
    floor = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    ceiling, card = floor[::-1] + [0.1, 0.0, 1.0], 0.2 * floor[:3] + [0.0, 0.0, 0.5]
    wall = np.array([[1.2, -1.0, -0.5], [1.2, -1.0, 1.0], [1.2, 1.0, 1.0]])
    far = ceiling + [0.0, 0.0, 30.0]
    for method in METHODS:
        drawn = method in ("quasi-hemisphere", "hemicube", "hemisphere")
        found = form_factor(
            floor,
            [ceiling, wall, far],
            occluders=[card],
            method=method,
            samples=2 if drawn else 64,
            resolution=8,
            visibility_tolerance=0.5,
            device=device,
        )
        assert found.value[0] > 0.1 and ((found.value >= 0.0) & (found.value < 0.8)).all()
        assert found.visibility[0] < 1.0


def test_hierarchical_links(device):
    """Refinement, sampling and a product over two levels, with two groups of columns."""
    scene = furnished_cube(1)
    lit = lit_fronts(scene)
    bvh = build_bvh(device, scene.patches)
    elements = build_elements(scene.patches, lit.space, np.ones(len(scene.materials), bool), 0.35)
    on_device, nodes = upload_scene(device, scene, bvh, occlusion=True), build_nodes(scene.patches, elements)
    finder = LinkFinder(on_device, nodes)
    rules = Refinement(form_factor=0.3, occlusion=True, reach=1.0, seed=1)
    linked = link_nodes(finder, nodes, np.zeros(len(nodes.roots)), rules, 2)
    hits = trace_rows(on_device, upload_elements(device, elements), 4, 1)
    operator = LinkOperator(device, build_link_exchange(linked, hits, elements, 1))
    product = operator.apply(np.ones((len(elements), 16), np.float32))
    assert nodes.n_levels == 2 and (product > 0.0).any() and np.isfinite(product).all()


def test_pairs_of_rows(device):
    """Proofs and samples between all pairs of elements, with solids that cover some of their points."""
    scene = furnished_cube(1)
    lit = lit_fronts(scene)
    bvh = build_bvh(device, scene.patches)
    elements = build_elements(scene.patches, lit.space, np.ones(len(scene.materials), bool), 0.8)
    on_device, uploaded = upload_scene(device, scene, bvh, occlusion=True), upload_elements(device, elements)
    cells = CellPairs(bvh, scene.patches, elements, np.zeros(len(elements), np.int64))
    pairs = cells.by_rows("point", 1, cells.prove(1.0))
    share, error, rays = open_share(on_device, uploaded, trace_rows(on_device, uploaded, 4, 1), pairs, 1)
    assert rays > 0 and (share >= 0.0).all() and (share <= 1.0 + 1e-6).all() and (error >= 0.0).all()

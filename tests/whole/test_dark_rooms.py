"""Where a slab, a wall or a floor reaches into a room without light, the light must not follow."""

from dataclasses import replace

import numpy as np
import pytest
from box_rooms import CASES, FACES, expected
from rooms import SceneBuilder, moved
from scipy.spatial.transform import Rotation

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.spectrum import Bands
from hradiosity.options import Options
from hradiosity.radiosity import make_solver, solve

CASE = CASES["cube-iso-rho0.50"]
SIDE = CASE["dims"][0]
RAYS = Options(elements=1500, gather_samples=1024, light_samples=16, rays_per_element=128, light_points=32)
CLASSIC = Options(mode="classic", replicates=2, element_size=0.25 * SIDE, hemicube_resolution=128, light_points=32)
TURN = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
PLACES = {
    "as it is": {},
    "turned, far off": {"rotation": TURN, "shift": (1e4, -1e4, 1e4)},
    "of millimetres": {"factor": 1e-3},
}


def two_cubes(thickness):
    """The cube of the case, and a dark, shorter one beyond a partition; four faces go through both."""
    b = SceneBuilder(1)
    paints = [b.material(CASE["rho"][face]) for face in FACES]
    far = 1.3 * SIDE + thickness
    b.box((0, 0, 0), (far, SIDE, SIDE), paints, inward=True)
    if thickness:
        b.box((SIDE, 0, 0), (SIDE + thickness, SIDE, SIDE), paints[1], solid=True)
    else:
        b.patch((SIDE, 0, 0), (0, 0, SIDE), (0, SIDE, 0), paints[1])
    bands = Bands.explicit([550.0, 560.0])
    b.point((SIDE / 2, SIDE / 2, SIDE / 2), 10000.0 / (4.0 * np.pi * luminous_weights(bands)[0]))
    position, normal = [], []
    for point in CASE["points"]:
        face = FACES.index(point["face"])
        position.append(np.insert([point["a"], point["b"]], face // 2, SIDE * (face % 2)))
        normal.append(np.eye(3)[face // 2] * (1 - 2 * (face % 2)))
    b.sensor(position, normal, "lit")
    edge = SIDE + thickness
    dark = [(edge + 1, 2, 2), (edge + 1e-3, 0.3, 1e-3), (far - 0.1, 0.9, 0.02), (edge + 0.4, 0.5, SIDE - 0.01)]
    b.sensor(dark, [(0, 0, 1), (0, 0, 1), (1, 0, 0), (0, 0, -1)], "dark")
    return replace(b.scene(), bands=bands)


def check_two_cubes(scene, options, device, factor, tolerance):
    solution = make_solver(scene, options, device)
    for _ in solution.states():
        pass
    solution = solution.solution()
    lit, dark = solution.readings["lit"].illuminance, solution.readings["dark"].illuminance
    assert np.abs(lit * factor**2 / expected(CASE) - 1).max() < tolerance
    assert not dark.any()
    assert np.isfinite(solution.surfaces.irradiance).all()
    return solution


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("thickness", (0.0, 0.1), ids=("sheet", "wall"))
def test_light_stays_on_its_side_of_a_partition(device, thickness, place):
    """1024 paths: three standard errors of the noisiest point are 2 %."""
    where = PLACES[place]
    scene = moved(two_cubes(thickness), **where)
    solution = check_two_cubes(scene, RAYS, device, where.get("factor", 1.0), 0.02)
    assert len(solution.scene.patches) == len(scene.patches) + (8 if thickness else 4)
    area = 6 * (SIDE * where.get("factor", 1.0)) ** 2
    assert solution.elements.area.sum() == pytest.approx(area, rel=1e-6)


@pytest.mark.parametrize("thickness", (0.0, 0.1), ids=("sheet", "wall"))
def test_light_of_hemicubes_stays_on_its_side_of_a_partition(device, thickness):
    """Elements of a quarter of an edge and their parts hold one value each: 4 % in the corners."""
    check_two_cubes(two_cubes(thickness), CLASSIC, device, 1.0, 0.045)


@pytest.mark.parametrize("method", ("auto", "hemicube"))
@pytest.mark.parametrize("thickness", (0.0, 0.1), ids=("sheet", "wall"))
def test_light_of_form_factors_stays_on_its_side_of_a_partition(device, thickness, method):
    options = replace(RAYS, form_factors=method, elements=600, replicates=2, hemicube_resolution=64)
    check_two_cubes(two_cubes(thickness), options, device, 1.0, 0.02)


def covered_floor(solid):
    """A cube with a block on its floor: a solid one, or five faces without a bottom."""
    b = SceneBuilder(1)
    grey = b.material(0.5)
    b.box((0, 0, 0), (1, 1, 1), grey, inward=True)
    faces = b.box((0.2, 0.3, 0.0), (0.65, 0.7, 0.4), grey, solid=solid)
    if not solid:
        del b.rows[faces[4]]
    b.point((0.5, 0.5, 0.8), 1.0)
    b.sensor([(0.5, 0.9, 0.0), (0.1, 0.1, 0.0), (0.9, 0.5, 0.5)], [(0, 0, 1), (0, 0, 1), (-1, 0, 0)], "lit")
    if solid:
        return b.scene()
    b.sensor([(0.4, 0.5, 0.1), (0.21, 0.31, 0.001), (0.6, 0.5, 0.39)], [(0, 0, 1), (0, 0, 1), (0, 0, -1)], "inside")
    return b.scene()


@pytest.mark.parametrize("place", PLACES)
def test_a_box_without_bottom_is_dark_inside_and_like_a_solid_one_outside(device, place):
    scenes = [moved(covered_floor(solid), **PLACES[place]) for solid in (False, True)]
    hollow, full = (solve(scene, RAYS, device) for scene in scenes)
    assert not hollow.readings["inside"].irradiance.any()
    ratio = hollow.readings["lit"].illuminance / full.readings["lit"].illuminance
    assert np.abs(ratio - 1).max() < 0.03
    assert hollow.elements.area.sum() == pytest.approx(full.elements.area.sum(), rel=1e-6)


@pytest.mark.parametrize(
    ("corner", "edge_u", "edge_v"),
    [((3, 0, 0), (1.1, 4, 0), (0, 0, 3)), ((3, -0.05, -0.05), (0, 4.1, 0), (0, 0, 3.1))],
    ids=("oblique", "through the walls"),
)
def test_behind_other_partitions_it_is_dark(device, corner, edge_u, edge_v):
    b = SceneBuilder(1)
    grey = b.material(0.5)
    b.box((0, 0, 0), (6, 4, 3), grey, inward=True)
    b.patch(corner, edge_u, edge_v, grey)
    b.point((1, 1, 2), 1.0)
    b.sensor([(5, 2, 0.01), (5.5, 1, 1.5), (4.6, 3.9, 2.9)], [(0, 0, 1), (-1, 0, 0), (0, 0, -1)], "dark")
    b.sensor((2, 2, 0), (0, 0, 1), "lit")
    readings = solve(b.scene(), RAYS, device).readings
    assert not readings["dark"].irradiance.any()
    assert readings["lit"].irradiance.all()

"""Coarser elements: cells merge by fours, small faces by cubes of twice the edge; what belongs apart stays apart."""

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity.options import Options
from hradiosity.radiosity.solver import RadiositySolver
from hradiosity.space.companion import coarser_rows
from hradiosity.space.hierarchy import build_elements, side_materials

TWO_SIDED = np.array([True, True])
SQUARE = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


def patches_of(faces, triangle=False, material=0):
    """Patches of (origin, edge_u, edge_v), facing up."""
    room = SceneBuilder()
    room.material(0.5)
    room.material(0.2)
    for face, paint in zip(faces, np.broadcast_to(material, len(faces))):
        room.patch(*face, int(paint), triangle=triangle)
    return room.scene().patches


def merged(patches, size, space=None):
    space = np.where([True, False], 0, -1) * np.ones((len(patches), 1)) if space is None else space
    elements = build_elements(patches, space.astype(np.int32), TWO_SIDED, size)
    first = elements.cell_side[elements.row_cell[elements.row_start[:-1]]]
    paint = side_materials(patches, TWO_SIDED)
    return elements, coarser_rows(patches, elements, space.ravel()[first].astype(np.int32), paint, size)


@pytest.mark.parametrize("triangle", [False, True])
def test_cells_merge_by_fours(triangle):
    elements, parent = merged(patches_of([SQUARE], triangle), 0.125)
    assert (np.bincount(parent) == 4).all()
    area = np.bincount(parent, elements.area)
    np.testing.assert_allclose(area, 4.0 * elements.area[0], rtol=1e-6)


def test_small_faces_of_one_kind_merge_and_others_do_not():
    """Tiles 5 cm apart have rows of their own at h = 5 cm and a common one at 10 cm; other paint keeps apart."""
    tiles = [((0.02 + 0.05 * (i % 2), 0.02 + 0.05 * (i // 2), 0.0), (0.01, 0, 0), (0, 0.01, 0)) for i in range(4)]
    far = ((0.5, 0.5, 0.0), (0.01, 0.0, 0.0), (0.0, 0.01, 0.0))
    patches = patches_of([*tiles, far])
    elements, parent = merged(patches, 0.05)
    assert len(elements) == 5 and len(np.unique(parent)) == 2
    painted = patches_of([*tiles, far], material=[0, 0, 1, 1, 0])
    assert len(np.unique(merged(painted, 0.05)[1])) == 3


def test_change_by_coarser_elements_foretells_the_error(device):
    """A cube with a bright floor lamp: |fine − finest| is of the order of |coarse − fine|, and shrinks with h."""
    room = SceneBuilder(1)
    grey = room.material(0.8)
    faces = room.box((0, 0, 0), (1, 1, 1), grey, inward=True)
    room.patch((0.0, 0.0, 0.3), (0.5, 0, 0), (0, 0.5, 0), grey)
    room.lamp(faces[5], 100.0)
    room.sensor([(0.1, 0.1, 0.001), (0.45, 0.45, 0.001), (0.9, 0.9, 0.001)], (0, 0, 1))
    changes = []
    for size in (0.5, 0.125):
        options = Options(
            element_size=size, rays_per_element=4096, light_points=64, gather_samples=16384, light_samples=1024
        )
        solver = RadiositySolver(room.scene(), options, device)
        list(solver.states())
        lux = solver.solution().readings["s0"].numbers["illuminance"]
        changes.append(lux.parts["mesh"] / lux.value)
    assert (changes[0] > 1e-4).all()
    assert changes[1].mean() < 0.5 * changes[0].mean()

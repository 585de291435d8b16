"""The light on the row elements over several replicates."""

import numpy as np
from rooms import SceneBuilder

from hradiosity.options import Options
from hradiosity.radiosity.solver import RadiositySolver

FLOOR = 4
"""Of the six faces that `SceneBuilder.box` makes."""
OPTIONS = Options(
    element_size=0.5, rays_per_element=64, light_points=4, light_samples=4, gather_samples=16, replicates=4
)


def test_rows_that_some_replicates_find_covered_are_as_bright_as_the_rest(device):
    """M = (1 − ρ) B everywhere makes E = B, also on strips of 1 cm that few of a row's rays start from."""
    wanted, room = 7.0, SceneBuilder()
    paint = room.material(0.5)
    room.box((0, 0, 0), (2, 2, 2), paint, inward=True)
    room.box((0.51, 0.51, 0), (1.49, 1.49, 1), paint, solid=True)
    for patch in range(len(room.rows)):
        room.lamp(patch, (1 - 0.5) * wanted)
    room.sensor((0.2, 0.2, 1), (0, 0, 1))
    solver = RadiositySolver(room.scene(), OPTIONS, device)
    totals = [
        state.replicate * solver.solution().surfaces.exposed for state in solver.states() if state.stage == "replicate"
    ]
    surfaces, elements = solver.solution().surfaces, solver.solution().elements
    floor = elements.cell_side[elements.row_cell[elements.row_start[:-1]]] == 2 * FLOOR
    of_replicate = np.diff(totals, axis=0, prepend=0.0)[:, floor]
    assert ((of_replicate < 1e-9).any(axis=0) & (of_replicate > 0.01).any(axis=0)).any()
    exposed = floor & (surfaces.exposed > 0.0)
    np.testing.assert_allclose(surfaces.irradiance[exposed], wanted, rtol=1e-3)
    np.testing.assert_allclose(surfaces.irradiance[floor & ~exposed], 0.0)

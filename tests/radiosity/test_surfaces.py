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


def test_sides_found_lit_late_are_in_the_plan_and_the_notes(device):
    """A dark room behind a hole of 11 cm: few rays tell which sides are lit, and miss it."""
    b = SceneBuilder()
    paint = b.material(0.5)
    b.box((0, 0, 0), (2, 2, 2), paint, inward=True)
    b.box((2, 0, 0), (4, 2, 2), paint, inward=True)
    low, high = 0.945, 1.055
    holed = [((0, 0), (2, low)), ((0, high), (2, 2)), ((0, low), (low, high)), ((high, low), (2, high))]
    pieces = [((2, y, z), (0, top - y, 0), (0, 0, upper - z)) for (y, z), (top, upper) in holed]
    b.rows[1] = (*pieces[0], *b.rows[1][3:])
    for piece in pieces[1:]:
        b.patch(*piece, paint)
    del b.rows[6]
    b.lamp(5, 1.0)
    b.sensor((1, 1, 1), (0, 0, 1))
    solver = RadiositySolver(b.scene(), OPTIONS, device)
    planned = solver.plan.n_elements
    for _ in solver.states():
        pass
    solution = solver.solution()
    late = [note for note in solution.scene.notes if "seemed dark" in note.message]
    assert len(late) == 1 and f"into {len(solution.elements)} elements" in late[0].message
    assert solution.plan.n_elements == len(solution.elements) > planned
    assert solution.plan.memory_bytes > 0

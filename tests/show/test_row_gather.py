"""Reflected light gathered once more for smooth pictures, against closed rooms and the solution itself."""

import numpy as np
import pytest
from rooms import cube

from hradiosity.options import Options
from hradiosity.radiosity import make_solver
from hradiosity.show.row_gather import gather_rows


def solved(device, room, **options):
    solver = make_solver(room.scene(), Options(element_size=0.1, **options), device)
    for _ in solver.states():
        pass
    return solver.solution(), solver.on_device


@pytest.mark.parametrize("rho", [0.2, 0.8])
def test_even_light_is_gathered_without_noise(device, rho):
    """All walls send out 1 − ρ of their own and ρ of what they get: whatever a ray meets, it is the same."""
    room = cube(rho, bands=3)
    room.lamp(range(6), 1 - rho)
    solution, on_device = solved(device, room)
    assert solution.plan.weak_emitters.all()
    np.testing.assert_allclose(gather_rows(solution, on_device), 1.0, rtol=1e-4)


def test_the_gathered_light_is_the_solution_with_less_noise(device):
    """Neighbouring elements differ by noise and little else; the mean of each wall stays."""
    room = cube([0.1, 0.3, 0.5, 0.7, 0.9, 0.2])
    room.lamp(room.patch((0.4, 0.4, 0.99), (0, 0.2, 0), (0.2, 0, 0), 0), 1.0)
    solution, on_device = solved(device, room, replicates=4, rays_per_element=64)
    surfaces, elements = solution.surfaces, solution.elements
    indirect = (surfaces.irradiance - surfaces.direct)[:, 0]
    gathered = gather_rows(solution, on_device)[:, 0]
    for side in range(0, 12, 2):
        on_wall = elements.cell_side[elements.row_cell[elements.row_start[:-1]]] == side
        assert gathered[on_wall].mean() == pytest.approx(indirect[on_wall].mean(), rel=0.01)
        divisions = elements.divisions[side // 2]
        rough = [
            np.abs(np.diff(part[on_wall].reshape(divisions[::-1]), n=2, axis=1)).mean() for part in (gathered, indirect)
        ]
        assert rough[0] < 0.8 * rough[1]


def test_nothing_is_reflected_where_reflection_is_left_out(device):
    room = cube(0.5)
    room.lamp(5, 1.0)
    solution, on_device = solved(device, room, interreflection=False)
    assert not gather_rows(solution, on_device).any()

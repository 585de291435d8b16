"""Rays of elements go where readings need them once the first replicate has shown it, and not in an open room."""

import numpy as np
from rooms import SceneBuilder, cube

from hradiosity.options import Options
from hradiosity.radiosity.solver import RadiositySolver

COARSE = Options(
    element_size=0.25, rays_per_element=128, light_points=8, light_samples=32, gather_samples=512, replicates=4, seed=3
)


def gap_rooms():
    """Two rooms joined by a gap of 4 cm in a wall of 8 cm; the lamp in one, readings in the other."""
    b = SceneBuilder()
    paint = b.material(0.7)
    b.box((0, 0, 0), (2.08, 1, 1), paint, inward=True)
    b.box((1, 0, 0), (1.08, 0.48, 1), paint, solid=True)
    b.box((1, 0.52, 0), (1.08, 1, 1), paint, solid=True)
    b.lamp(b.patch((0.25, 0.1, 0.98), (0, 0.2, 0), (0.5, 0, 0), paint), 1000.0)
    x, y = np.meshgrid([1.3, 1.5, 1.7, 1.9], [0.2, 0.5, 0.8])
    b.sensor(np.column_stack([x.ravel(), y.ravel(), np.full(12, 0.5)]), (0, 0, 1))
    return b.scene()


def open_room():
    b = cube(0.5)
    b.lamp(b.patch((0.4, 0.4, 0.99), (0, 0.2, 0), (0.2, 0, 0), b.material(0.5)), 1000.0)
    b.sensor(np.array([[0.3, 0.3, 0.4], [0.7, 0.6, 0.4]]), (0, 0, 1))
    return b.scene()


def lux(solver):
    return solver.solution().readings["s0"].numbers["illuminance"].value


def aiming_of(solver):
    return solver._prepare()._aiming


def test_rays_are_aimed_behind_a_gap_and_in_no_open_room(device):
    solver = RadiositySolver(gap_rooms(), COARSE, device)
    for _ in solver.states():
        pass
    aiming = aiming_of(solver)
    assert aiming.done and aiming.aims is not None and aiming.points is not None
    assert aiming.aims.aims.share.shape[0] == len(solver.solution().elements)
    assert len(solver.record.defects) == COARSE.replicates
    plain = RadiositySolver(open_room(), COARSE, device)
    for _ in plain.states():
        pass
    assert aiming_of(plain).done and aiming_of(plain).aims is None and aiming_of(plain).points is None


def test_a_resumed_run_has_the_same_aims_and_bits(device):
    whole, first, resumed = (RadiositySolver(gap_rooms(), COARSE, device) for _ in range(3))
    for _ in whole.states():
        pass
    for state in first.states():
        if state.replicate == 2:
            break
    resumed.restore(first.checkpoint())
    np.testing.assert_array_equal(aiming_of(resumed).aims.aims.share, aiming_of(first).aims.aims.share)
    for _ in resumed.states():
        pass
    np.testing.assert_array_equal(lux(resumed), lux(whole))

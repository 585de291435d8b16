"""Cases 56 and 60 to 62: replicates that are no replicates, other devices, other numbers of threads, interruptions."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rooms import cube
from truths import QUICK, only

from hradiosity.device import Device
from hradiosity.device.choice import list_devices
from hradiosity.errors import DeviceError, HradiosityError
from hradiosity.radiosity import make_solver, solve


def room():
    """A room with a block, a lamp and three readings, in two bands."""
    b = cube([0.2, 0.4, 0.5, 0.6, 0.3, 0.7], bands=2)
    b.box((0.2, 0.3, 0.05), (0.6, 0.5, 0.4), b.material([0.2, 0.6]), solid=True)
    b.lamp(b.patch((0.7, 0.2, 0.9), (0, 0.2, 0), (0.2, 0, 0), 0), [1.0, 2.0])
    b.sensor([(0.8, 0.8, 0.1), (0.2, 0.2, 0.1), (0.5, 0.5, 0.6)], (0, 0, 1))
    return b.scene()


def test_case_56_replicates_of_one_seed_by_mistake_are_refused(device, monkeypatch):
    """Else all half widths would be 0, and every reading exact."""
    import hradiosity.radiosity.solver as module

    class Stuck:
        def __init__(self, entropy):
            self.entropy = entropy

        def generate_state(self, n):
            return np.full(n, 7, np.uint32)

    monkeypatch.setattr(module.np.random, "SeedSequence", Stuck)
    with pytest.raises(HradiosityError, match="replicates"):
        solve(room(), QUICK, device)


def test_case_56_replicates_of_different_seeds_differ(device):
    readings = only(solve(room(), QUICK, device))
    assert (readings.half_width > 0.0).all() and (readings.half_width < 0.2 * readings.irradiance).all()


CHILD = """
import sys
from pathlib import Path
sys.path[:0] = sys.argv[1:3]
import hradiosity.device.device as module
module.LOCAL_SIZE = int(sys.argv[3])
from test_repeatability import room
from truths import QUICK, only
from hradiosity.device import Device
from hradiosity.radiosity import solve
solution = solve(room(), QUICK, Device())
sys.stdout.write(only(solution).irradiance.tobytes().hex() + solution.surfaces.irradiance.tobytes().hex())
"""


def bits(threads, local_size=64):
    """Readings and light on the surfaces of a run in a process of its own."""
    here = Path(__file__).parent
    return subprocess.run(
        [sys.executable, "-c", CHILD, str(here), str(here.parent), str(local_size)],
        env=os.environ | {"POCL_MAX_PTHREAD_COUNT": str(threads), "PYTHONPATH": str(here.parents[1])},
        capture_output=True,
        text=True,
        check=True,
    ).stdout


def test_case_61_the_same_bits_with_1_and_16_threads():
    one = bits(1)
    assert len(one) > 1000
    assert bits(16) == one


@pytest.mark.slow
def test_case_61_the_same_bits_with_1_2_and_16_threads_and_other_work_groups():
    one = bits(1)
    for threads, local_size in ((2, 64), (16, 64), (2, 16), (2, 128)):
        assert bits(threads, local_size) == one


def test_case_60_one_compute_unit_and_other_devices(device):
    """Every other device there is, a memory checker apart, within both intervals; one thread is case 61."""
    mine = only(solve(room(), QUICK, device))
    others = [i for i in list_devices() if i.rank < 9 and i.index != device.info.index]
    if not others:
        pytest.skip("there is no other device")
    for info in others:
        other = only(solve(room(), QUICK, Device(str(info.index))))
        assert (np.abs(other.irradiance - mine.irradiance) <= np.hypot(other.half_width, mine.half_width)).all()


def test_case_60_a_device_without_double_precision(device, monkeypatch):
    """Rays and readings need none: the solver's sums are taken elsewhere, in another order. Hemicubes do and say so."""
    mine = only(solve(room(), QUICK, device))
    monkeypatch.setattr(device, "info", replace(device.info, has_double=False))
    np.testing.assert_allclose(only(solve(room(), QUICK, device)).irradiance, mine.irradiance, rtol=1e-6)
    for options in (
        replace(QUICK, mode="classic", element_size=0.3),
        replace(QUICK, form_factors="contour", elements=100),
    ):
        with pytest.raises(DeviceError, match="double precision"):
            solve(room(), options, device)


@pytest.mark.parametrize("known", [1, 3])
def test_case_62_interrupted_and_resumed(device, known):
    """The same bits, spectra, half widths and light on the surfaces."""
    whole = solve(room(), QUICK, device)
    first = make_solver(room(), QUICK, device)
    for state in first.states():
        if state.replicate == known:
            break
    kept = {name: np.array(array) for name, array in first.checkpoint().items()}
    second = make_solver(room(), QUICK, device)
    second.restore(kept)
    assert second.replicates == known
    for _ in second.states():
        pass
    resumed = second.solution()
    np.testing.assert_array_equal(only(resumed).irradiance, only(whole).irradiance)
    np.testing.assert_array_equal(only(resumed).half_width, only(whole).half_width)
    np.testing.assert_array_equal(resumed.surfaces.irradiance, whole.surfaces.irradiance)

"""What the plan says of the classic mode, and the reciprocity that its hemicubes lack."""

import numpy as np
import pytest
from box_rooms import CASES, box_room
from scipy.sparse import csr_array

from hradiosity.io.cache import CACHE_VARIABLE
from hradiosity.io.calibration import load_calibration, measure, store
from hradiosity.options import Options
from hradiosity.plan import Calibration, ClassicCalibration
from hradiosity.planning_classic import pixels_drawn, products
from hradiosity.radiosity import RadiositySolver
from hradiosity.radiosity.classic import ClassicSolver
from hradiosity.radiosity.shooting import ShootingPoints, ShootingRows
from hradiosity.transport.form_factor.hemicube import Views

SPEEDS = ClassicCalibration(1e-8, 1e-9)


def room():
    return box_room(CASES["room443-panel-752"])


def classic(**changes):
    return Options(**({"mode": "classic", "element_size": 1.0, "hemicube_resolution": 32} | changes))


@pytest.fixture(scope="module")
def finished(device):
    solver = ClassicSolver(room(), classic(), device)
    for _ in solver.states():
        pass
    return solver.solution()


def test_hemicubes_and_shots_are_foreseen(finished):
    plan, record = finished.plan, finished.record
    assert plan.hemicubes == pytest.approx(record["hemicubes"]["drawn"], rel=0.05)
    shots = plan.shooters * sum(solved["products"] for solved in record["solver"])
    assert shots / 1.5 < plan.shots < 1.5 * shots
    assert "hemicubes and" in "\n".join(plan.lines()) and "million rays" not in "\n".join(plan.lines())


def test_measured_speeds_give_back_the_seconds_that_they_were_measured_from(finished, device, monkeypatch):
    """The counts of the plan are off by a few per cent."""
    monkeypatch.setattr("hradiosity.radiosity.rounds.with_geometry", lambda plan, spent: plan)
    speeds = measure(finished)
    again = ClassicSolver(room(), classic(), device, speeds).plan
    stages = finished.record["stage_seconds"]
    assert again.seconds == pytest.approx(sum(stages[s] for s in ("lamps", "shooting", "readings")), rel=0.3)


def test_cost_follows_resolution_patches_and_columns(device, monkeypatch):
    monkeypatch.setattr("hradiosity.radiosity.rounds.with_geometry", lambda plan, spent: plan)
    plans = [
        ClassicSolver(room(), classic(**changes), device, SPEEDS).plan
        for changes in ({}, {"hemicube_resolution": 64}, {"replicates": 16}, {"interreflection": False})
    ]
    base, fine, long, dark = plans
    drawn = base.hemicubes * (pixels_drawn(64, base.n_patches) - pixels_drawn(32, base.n_patches)) * 1e-8
    assert fine.seconds - base.seconds == pytest.approx(drawn, rel=1e-9)
    assert fine.memory_bytes - base.memory_bytes == pytest.approx(24 * (64**2 - 32**2) * 64, rel=0.05)
    assert long.seconds == pytest.approx(2 * base.seconds, rel=0.02) and long.shots == 2 * base.shots
    assert dark.shots == 0 and dark.seconds < 0.5 * base.seconds
    assert products(3, 4, 5, 6) == 7 * 5 * 6


def test_speeds_of_one_mode_say_nothing_of_the_other(device, tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    rays = Calibration(2e6, 1e6, 5e5, 3e-7, 1e-8)
    assert store("abacus", [], SPEEDS) and load_calibration("abacus") is None
    assert store("abacus", [], rays)
    assert load_calibration("abacus") == rays and load_calibration("abacus", "classic") == SPEEDS
    assert ClassicSolver(room(), classic(), device, rays).plan.seconds is None
    assert RadiositySolver(room(), Options(), device, SPEEDS).plan.seconds is None


class _Seen:
    """In place of hemicubes: form factors as they stand in a matrix."""

    resolution, batch = 32, 64

    def __init__(self, factor):
        self.n_items, self._factor = len(factor), np.asarray(factor, np.float32)

    def views(self, position, normal, angle, own_patch):
        nothing = np.zeros(len(position))
        return Views(csr_array(self._factor[own_patch]), nothing, nothing, nothing, nothing)


def rows_of(factor, area):
    n = len(area)
    points = ShootingPoints(np.zeros((n, 3)), np.zeros((n, 3)), np.arange(n), np.ones(n, bool), np.zeros(n))
    rows = ShootingRows(_Seen(factor), points, np.asarray(area, float), np.arange(n))
    rows(np.arange(n))
    return rows


def test_reciprocity_defect_of_known_factors():
    """Exchange areas 1.1 and 0.9 differ by 0.2; a pair that one side alone sees, or hardly any pixel, is left out."""
    area = np.array([1.0, 2.0, 4.0, 0.0])
    assert rows_of([[0, 0.2, 0, 0], [0.1, 0, 0, 0], [0, 0, 0.5, 0], [0.5, 0.5, 0, 0]], area).reciprocity_defect() < 1e-6
    off = [[0, 0.22, 0.3, 0], [0.09, 0, 1e-4, 0], [0, 3e-4, 0, 0], [0.9, 0, 0, 0]]
    assert rows_of(off, area).reciprocity_defect() == pytest.approx(0.2, rel=1e-5)
    assert rows_of(np.zeros((4, 4)), area).reciprocity_defect() == 0.0


def test_defect_of_a_room_is_that_of_shooting_from_points(finished):
    """Neighbours in corners see each other from random points, which do not agree to better than some per cent."""
    defects = finished.record["defects_before_closure"]
    assert all(0.02 < found["reciprocity_rms"] < 1.0 for found in defects)


def test_the_hemicubes_of_a_record_survive_a_checkpoint(device):
    solver = ClassicSolver(room(), classic(replicates=2), device)
    states = solver.states()
    next(states), next(states)
    drawn = solver.record.hemicubes
    resumed = ClassicSolver(room(), classic(replicates=2), device)
    resumed.restore(solver.checkpoint())
    assert resumed.record.hemicubes == drawn > 0

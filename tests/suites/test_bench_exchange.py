"""The benchmark of form factors in whole runs."""

import numpy as np
import pytest
from rooms import cube

from hradiosity.options import Options
from hradiosity.suites.bench_exchange import HEADER, METHODS, element_error, measure, reflected, run


def test_a_room_is_measured(device):
    b = cube([0.5, 0.2, 0.5, 0.5, 0.6, 0.7])
    b.point((0.5, 0.5, 0.6), 1.0)
    b.sensor((0.4, 0.5, 0.2), (0, 0, 1))
    scene = b.scene()
    options = Options(element_size=0.5, gather_samples=256, light_points=8, replicates=2)
    best = run(scene, device, options).solution()
    assert element_error(best, best) == 0.0
    assert element_error(run(scene, device, Options(element_size=0.5, seed=5)).solution(), best) > 1e-4
    outcome = measure(scene, device, Options(element_size=0.5, form_factors="auto"), best.readings, best)
    assert outcome.row_sum_rms < 1e-3 and outcome.spectral_rms == pytest.approx(0.0, abs=0.1)
    assert outcome.line().count("|") == HEADER.splitlines()[0].count("|")
    assert np.isfinite(reflected(best)).all()
    assert METHODS[0] == "rays" and len(METHODS) == 9

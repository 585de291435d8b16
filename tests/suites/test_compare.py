"""Errors of readings whose errors are known."""

from dataclasses import replace

import numpy as np
import pytest
from box_rooms import CASES, SENSOR, box_faces, box_room, patches_of, scene_of

from hradiosity.readings.moments import ReadingMoments, ReplicateReadings
from hradiosity.solution import Readings
from hradiosity.suites.compare import compare, counted_bands
from hradiosity.suites.referee_cache import referee_readings, scene_digest

N_POINTS, N_BANDS = 5, 4


def readings_of(spectra) -> dict[str, Readings]:
    """Readings whose replicates are `spectra` (n_replicates, N_POINTS, N_BANDS)."""
    scene = scene_of(
        patches_of(box_faces(1, 1, 1), [0] * 6),
        np.zeros((1, N_BANDS)),
        [],
        np.full((N_POINTS, 3), 0.5),
        np.tile([0.0, 0.0, 1.0], (N_POINTS, 1)),
    )
    moments = ReadingMoments(scene.sensors, scene.bands)
    for sample in spectra:
        moments.add(ReplicateReadings(np.asarray(sample, float), np.zeros(N_POINTS)))
    return moments.readings()


@pytest.fixture
def truth():
    return np.random.default_rng(0).uniform(1.0, 2.0, (N_POINTS, N_BANDS))


def test_a_common_factor_is_all_bias(truth):
    result = compare(readings_of([1.02 * truth] * 2), readings_of([truth] * 2))
    for value in (result.spectral_rms, result.illuminance_rms, result.illuminance_max, result.bias):
        assert value == pytest.approx(0.02, rel=1e-9)
    assert result.covered == 0.0 == result.spectra_covered
    assert result.readings == N_POINTS


def test_intervals_that_reach_the_reference_cover(truth):
    result = compare(readings_of([0.9 * truth, 1.12 * truth]), readings_of([truth] * 2))
    assert result.covered == 1.0 == result.spectra_covered
    assert result.bias == pytest.approx(0.01)


def test_noise_of_the_reference_is_its_standard_error(truth):
    """Two scrambles at ±1 % have the standard error 1 % of the mean; Student's quantile of one degree is 12.706."""
    noisy = readings_of([0.99 * truth, 1.01 * truth])
    result = compare(readings_of([truth] * 2), noisy, quantile=12.7062047)
    assert result.reference_spectral_rms == pytest.approx(0.01, rel=1e-6)
    assert result.reference_illuminance_rms == pytest.approx(0.01, rel=1e-6)


def test_faint_bands_and_dark_readings_do_not_count(truth):
    spectra = truth.copy()
    spectra[:, 3] *= 1e-3
    spectra[0] = 0.0
    wrong = spectra.copy()
    wrong[:, 3] *= 2.0
    assert not counted_bands(spectra)[3]
    result = compare(readings_of([wrong] * 2), readings_of([spectra] * 2))
    assert result.spectral_rms == 0.0
    assert result.readings == N_POINTS - 1


def test_other_sensors_or_shapes_are_refused(truth):
    ours = readings_of([truth] * 2)
    with pytest.raises(ValueError, match="sensors differ"):
        compare({"other": ours[SENSOR]}, ours)
    with pytest.raises(ValueError, match="differ"):
        fewer = {name: found[:2] if found.value.ndim else found for name, found in ours[SENSOR].numbers.items()}
        compare({SENSOR: replace(ours[SENSOR], numbers=fewer)}, ours)
    with pytest.raises(ValueError, match="nothing in the reference"):
        compare(ours, readings_of([0.0 * truth] * 2))


def test_the_cache_serves_the_same_scene_only(device, tmp_path):
    scene, file = box_room(CASES["cube-iso-rho0.20"]), tmp_path / "referee.npz"
    states = []
    first = referee_readings(scene, device, 256, cache=file, progress=states.append)[SENSOR]
    again = referee_readings(scene, device, 256, cache=file, progress=states.append)[SENSOR]
    assert len(states) == 1
    np.testing.assert_array_equal(first.irradiance, again.irradiance)
    np.testing.assert_array_equal(first.half_width, again.half_width)
    other = replace(scene, materials=(*scene.materials[:-1], replace(scene.materials[-1], two_sided=False)))
    assert scene_digest(other) != scene_digest(scene)
    referee_readings(other, device, 256, cache=file, progress=states.append)
    assert len(states) == 2


def test_an_interrupted_reference_is_kept(device, tmp_path, monkeypatch):
    monkeypatch.setattr("hradiosity.readings.paths.ROUND_PATHS", 1 << 12)
    scene, file = box_room(CASES["cube-iso-rho0.20"]), tmp_path / "referee.npz"

    def stop(state):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        referee_readings(scene, device, 4096, cache=file, progress=stop)
    with np.load(file) as kept:
        assert 0 < int(kept["paths"]) < 4096

"""The Cornell box by this program and by two others, each against the same unbiased paths.

All read spectral irradiance at the scene's 275 readings. The path tracer Mitsuba follows four wavelengths a path, as
many paths as fit into the CPU seconds that this program took; Radiance computes 20 bands by its ambient cache, at two
settings whose cost is not ours to choose, and its lamps reflect nothing. Errors are relative, of illuminances and of
bands of 20 nm. Time excludes reading the scene, and what is compiled at first use.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.scene_toml import load_scene
from hradiosity.metrics.photometric import illuminance
from hradiosity.model.scene import Scene
from hradiosity.model.spectrum import Bands
from hradiosity.options import Options
from hradiosity.radiosity import make_solver
from hradiosity.solution import Readings
from hradiosity.suites.bench import peer_radiance
from hradiosity.suites.bench.figure import CPU, ERROR, Figure, figure_of
from hradiosity.suites.bench.scenes import reference, scene_file
from hradiosity.suites.bench.session import Session
from hradiosity.suites.compare import counted_bands

SCENE: Final = "cornell_box"
JOINED: Final = 4
"""So many of the scene's bands make one; the first band is left out, since 81 is not divisible."""


COMPILER: Final = ("LLVM", "In function: drjit")
"""Words of messages that come from Mitsuba's compiler."""


@dataclass(frozen=True)
class Answer:
    """One way to the readings.

    irradiance : (n_readings, n_bands) float64, of the joined bands [W m⁻² per band]
    cpu_seconds : for all of them
    """

    irradiance: NDArray[np.float64]
    cpu_seconds: float


def join_bands(bands: Bands) -> Bands:
    """Without the first ones, so that the others make whole groups."""
    first = len(bands) % JOINED
    return Bands(bands.lower[first::JOINED], bands.upper[first + JOINED - 1 :: JOINED])


def join_light(irradiance: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n_readings, n_bands) power per band, summed over the groups of `join_bands`."""
    n_readings, n_bands = irradiance.shape
    joined: NDArray[np.float64] = irradiance[:, n_bands % JOINED :].reshape(n_readings, -1, JOINED).sum(axis=2)
    return joined


def errors(found: NDArray[np.float64], known: NDArray[np.float64], bands: Bands) -> tuple[float, float]:
    """Root mean square of the relative errors: of the illuminances, and over readings and bands with light.

    Parameters
    ----------
    found, known : (n_readings, n_bands) float64
        Irradiance [W m⁻² per band].
    """
    true_lux = illuminance(known, bands)
    lit = true_lux > 0.0
    lux = illuminance(found, bands)[lit] / true_lux[lit] - 1.0
    counts = (known > 0.0) & counted_bands(known)[None, :]
    spectral = found[counts] / known[counts] - 1.0
    return float(np.sqrt(np.mean(lux**2))), float(np.sqrt(np.mean(spectral**2)))


def measure(session: Session) -> list[Figure]:
    """CPU seconds and errors of each program, repeated with other random numbers."""
    path = scene_file(session, SCENE)
    if path is None:
        return []
    scene = load_scene(path)
    known = reference(session, SCENE, scene)
    turns = 2 if session.quick else 4
    _ours(scene, session, 0)
    own = [_ours(scene, session, seed) for seed in range(1, turns + 1)]
    found = {"hradiosity normal": own}
    if session.has_peer("mitsuba"):
        budget = float(np.median([answer.cpu_seconds for answer in own]))
        found["Mitsuba, as long"] = _mitsuba(session, path, budget, turns)
    if session.has_peer("pyradiance"):
        found["Radiance coarse"] = [_radiance(scene, peer_radiance.COARSE) for _ in range(turns)]
        if not session.quick:
            found["Radiance fine"] = [_radiance(scene, peer_radiance.FINE)]
    truth, bands = join_light(_spectra(scene, known)), join_bands(scene.bands)
    return [figure for name, answers in found.items() if answers for figure in _figures(name, answers, truth, bands)]


def _figures(name: str, answers: list[Answer], truth: NDArray[np.float64], bands: Bands) -> list[Figure]:
    off = [errors(answer.irradiance, truth, bands) for answer in answers]
    of = f"peers: Cornell box, {name}"
    return [
        figure_of(of, [answer.cpu_seconds for answer in answers], CPU),
        figure_of(f"{of}, illuminance rms", [lux for lux, _ in off], ERROR),
        figure_of(f"{of}, spectral rms", [spectral for _, spectral in off], ERROR),
    ]


def _spectra(scene: Scene, readings: dict[str, Readings]) -> NDArray[np.float64]:
    return np.concatenate([readings[sensor.name].irradiance for sensor in scene.sensors])


def _ours(scene: Scene, session: Session, seed: int) -> Answer:
    solver = make_solver(scene, Options.of_quality("normal", seed=seed), session.device)
    for _ in solver.states():
        pass
    return Answer(join_light(_spectra(scene, dict(solver.solution().readings))), solver.cpu_seconds)


def _mitsuba(session: Session, scene: Path, budget: float, turns: int) -> list[Answer]:
    """In a process of its own, since its compiler ends the process where it does not suit the processor."""
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "mitsuba.npz"
        command = ("-m", "hradiosity.suites.bench.peer_mitsuba", str(scene), str(result), str(budget), str(turns))
        done = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False)
        if done.returncode:
            session.notes.append(f"Mitsuba failed and was skipped: {_why(done.stderr)}")
            return []
        with np.load(result) as kept:
            return [Answer(join_light(e), float(s)) for e, s in zip(kept["irradiance"], kept["cpu_seconds"])]


def _why(errors: str) -> str:
    """What its process wrote last, and what helps where that is of its compiler.

    With LLVM 15, which it finds on Debian 12, no instruction could be selected for a recent Xeon; LLVM 22 served.
    """
    lines = [line.strip() for line in errors.splitlines() if line.strip()]
    said = lines[-1] if lines else "it wrote no message"
    if not any(word in errors for word in COMPILER):
        return said
    newer = "a newer LLVM library knows this processor (15 failed on one that 22 worked on)"
    return f"{said}; {newer}: name its file in the environment variable DRJIT_LIBLLVM_PATH"


def _radiance(scene: Scene, settings: tuple[str, ...]) -> Answer:
    bands = join_bands(scene.bands)
    irradiance, seconds = peer_radiance.irradiance(scene, bands, settings)
    return Answer(irradiance, seconds)

"""The light of a run for whoever watches it, and the window of ``render --view``."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Final

import numpy as np

from hradiosity.cli.live_files import Pace
from hradiosity.cli.request import Run
from hradiosity.io.drawn_scene import Light
from hradiosity.io.live_light import LiveWriter, is_watched
from hradiosity.radiosity import RadiositySolver
from hradiosity.radiosity.watching import Glimpse
from hradiosity.solution import Surfaces

SHARE: Final = 0.1
"""Share of the time that writing light may take while somebody watches."""
PAUSE: Final = 0.2
"""Seconds between two versions, at least."""


class LiveLight:
    """Writes the light of a solver into ``OUT.partial/live`` while somebody watches.

    Parameters
    ----------
    partial : Path
    solver : RadiositySolver
    """

    def __init__(self, partial: Path, solver: RadiositySolver) -> None:
        self._partial, self._solver = partial, solver
        self._writer = LiveWriter(partial)
        self._pace = Pace(SHARE, PAUSE)
        solver.watch = self._glimpse

    def _glimpse(self, glimpse: Glimpse) -> None:
        """In the midst of a solution."""
        step = glimpse.progress
        words = (
            f"replicate {glimpse.replicates + 1}: {step.solver}, {step.products:.3g} rounds, {step.residual:.1e} left"
        )
        self._pace.run(lambda: self._write(glimpse, words))

    def _write(self, glimpse: Glimpse, words: str) -> None:
        if is_watched(self._partial):
            light = light_of(glimpse.surfaces(), glimpse.replicates + 1)
            self._writer.write(glimpse.scene, glimpse.elements, light, words, settled=glimpse.replicates > 0)

    def update(self) -> None:
        """Write the mean over the replicates, if that is due."""
        if self._solver.replicates:
            self._pace.run(self._write_mean)

    def _write_mean(self) -> None:
        if is_watched(self._partial):
            solution = self._solver.solution()
            count = solution.replicates
            words = f"{count} replicate{'s' if count > 1 else ''} done"
            light = light_of(solution.surfaces, count)
            self._writer.write(solution.scene, solution.elements, light, words, settled=True)


def light_of(surfaces: Surfaces, replicates: int) -> Light:
    """As a window reads it."""
    return Light(surfaces.irradiance, surfaces.exposed, surfaces.space.astype(np.int32), replicates)


def open_window(run: Run) -> subprocess.Popen[bytes]:
    """A window that follows the run, in a process of its own.

    It has a session of its own as well, so that Ctrl-C in the terminal reaches the run alone, and says nothing there,
    where the run shows its progress.
    """
    words = ["view", str(run.request.scene), "--follow", str(run.out), "--white", run.request.outputs.white.value]
    return subprocess.Popen(
        [sys.executable, "-m", "hradiosity", *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )

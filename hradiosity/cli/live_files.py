"""What a run writes while it goes on: checkpoints and a preview, neither too often."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from hradiosity.cli.interrupts import held_back
from hradiosity.cli.request import PREVIEW, Run, command, short
from hradiosity.errors import OutputError
from hradiosity.io.checkpoint import save_checkpoint
from hradiosity.io.output_folder import close_partial, open_partial
from hradiosity.radiosity import RadiositySolver
from hradiosity.show.preview import Preview
from hradiosity.show.white import WhiteName

LEAST_PAUSE = 1.0
"""Seconds between two versions of a live file, at least."""
TIME_SHARE = 0.05
"""Share of the time that writing one of them may take."""


@dataclass
class Pace:
    """When something is due again.

    share : of the time that it may take
    least : seconds in between
    """

    share: float = TIME_SHARE
    least: float = LEAST_PAUSE
    _due: float = field(default_factory=time.perf_counter)

    def wait(self, seconds: float) -> None:
        """Not before that many seconds from now."""
        self._due = time.perf_counter() + seconds

    def run(self, action: Callable[[], None]) -> None:
        """Do it if it is due; a full disk does not stop a run, which may well find room at its end."""
        start = time.perf_counter()
        if start < self._due:
            return
        with held_back() as came, suppress(OutputError):
            action()
        self.wait(max(self.least, (time.perf_counter() - start) / self.share))
        if came:
            raise KeyboardInterrupt


class LiveFiles:
    """Checkpoints, and a preview if wanted, in ``OUT.partial``.

    Parameters
    ----------
    folder : Path
    solver : RadiositySolver
    digest : str
        Of what the checkpoints belong to.
    preview : bool
        Draw ``pictures/preview.png``.
    white : WhiteName
        What it shows as white.
    """

    def __init__(self, folder: Path, solver: RadiositySolver, digest: str, *, preview: bool, white: WhiteName) -> None:
        self._folder, self._solver, self._digest = folder, solver, digest
        self._white = white
        self._picture = folder / PREVIEW
        self._preview = self._open_preview() if preview and len(solver.scene.patches) else None
        self._checkpoint_pace, self._preview_pace = Pace(), Pace()
        self._checkpoint_pace.wait(LEAST_PAUSE)

    def update(self) -> None:
        """Write what is due.

        Raises
        ------
        KeyboardInterrupt
            When an interrupt came while it wrote.
        """
        if self._solver.replicates:
            if self._preview is not None:
                self._preview_pace.run(self._draw)
            self._checkpoint_pace.run(lambda: save_checkpoint(self._folder, self._solver.checkpoint(), self._digest))

    def _open_preview(self) -> Preview:
        on_device = self._solver.on_device
        return Preview(self._solver.scene, on_device.device, bvh=on_device.bvh, white=self._white)

    def _draw(self) -> None:
        if self._preview is not None:
            self._picture.parent.mkdir(exist_ok=True)
            self._preview.write(self._solver, self._picture)


def rescue(run: Run, solver: RadiositySolver, digest: str) -> str:
    """Keep a checkpoint where there is no room for the results; says what became of it."""
    close_partial(run.out)
    try:
        save_checkpoint(open_partial(run.out), solver.checkpoint(), digest)
    except OutputError:
        run.keep_partial = False
        return f"nor is there room to keep what was computed; {short(run.out)} is as it was"
    return f"what was computed is kept in {short(run.partial)}: make room, then go on with {command()} --resume"

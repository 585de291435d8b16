"""Following a run: its light while it goes on, its result once it is there."""

from __future__ import annotations

from pathlib import Path

from hradiosity.errors import SceneError
from hradiosity.io.live_light import LiveReader, ask_for_light, stop_watching
from hradiosity.io.output_folder import RUN_FILE, partial_of
from hradiosity.io.results_reading import read_result
from hradiosity.show.window.viewer import Viewer


class Follower:
    """Looks for newer light whenever it is asked to.

    Parameters
    ----------
    out : Path
        Folder that the results of the run will have; they grow in ``OUT.partial``.
    """

    def __init__(self, out: Path) -> None:
        self._out, self._partial = out, partial_of(out)
        self._reader = LiveReader(self._partial)
        self._before = _stamp(out)
        self._seen = self._done = False

    def update(self, viewer: Viewer) -> None:
        """Show what is new."""
        if self._done:
            return
        if self._partial.is_dir():
            self._seen = True
            ask_for_light(self._partial)
            found = self._reader.read()
            if found is not None:
                viewer.take_light(found)
        elif _stamp(self._out) not in (None, self._before):
            self._done = True
            self._take_result(viewer)
        elif self._seen:
            self._done = True
            viewer.running = "the run has ended without a result"
            viewer.redraw()

    def close(self) -> None:
        """Nobody watches any longer."""
        stop_watching(self._partial)

    def _take_result(self, viewer: Viewer) -> None:
        try:
            viewer.take_result(read_result(self._out), "")
        except SceneError as error:
            viewer.running = str(error)
            viewer.redraw()


def _stamp(folder: Path) -> int | None:
    """Time at which a result was finished [ns]; None where there is none."""
    try:
        return (folder / RUN_FILE).stat().st_mtime_ns
    except OSError:
        return None

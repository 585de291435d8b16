"""The light of a run that somebody watches, in ``OUT.partial/live``: written by the run, read by a window.

A window asks for it by touching the file ``watched`` again and again; a run that nobody watches writes nothing.
"""

from __future__ import annotations

import io
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import OutputError
from hradiosity.io.drawn_scene import Drawn, Light
from hradiosity.io.output_folder import write_file
from hradiosity.io.results_drawing import write_drawing
from hradiosity.io.results_mesh import cell_numbers, write_mesh, write_names
from hradiosity.io.results_reading import read_drawn
from hradiosity.model.scene import Scene
from hradiosity.space.hierarchy import Elements

LIVE_FOLDER: Final = "live"
_MESH, _LIGHT, _WATCHED = "mesh.h5", "light.h5", "watched"
PATIENCE: Final = 10.0
"""Seconds after which a window that has not asked again is taken to be gone."""


def ask_for_light(partial: Path) -> bool:
    """Let the run in a folder know that somebody watches; returns whether it could be told."""
    folder = partial / LIVE_FOLDER
    try:
        folder.mkdir(exist_ok=True)
        (folder / _WATCHED).touch()
    except OSError:
        return False
    return True


def is_watched(partial: Path) -> bool:
    """Whether somebody asked lately."""
    try:
        return time.time() - (partial / LIVE_FOLDER / _WATCHED).stat().st_mtime < PATIENCE
    except OSError:
        return False


def stop_watching(partial: Path) -> None:
    """Let the run know that nobody watches any longer."""
    try:
        (partial / LIVE_FOLDER / _WATCHED).unlink(missing_ok=True)
    except OSError:
        return


def remove_live(out: Path) -> None:
    """Delete it from a result, once that has its name: a window that still asks no longer finds the folder.

    Raises
    ------
    OutputError
        When it can't be deleted.
    """
    folder = out / LIVE_FOLDER
    try:
        for path in folder.glob("*"):
            path.unlink()
        if folder.exists():
            folder.rmdir()
    except OSError as error:
        raise OutputError(f"{folder} can't be deleted: {error.strerror or error}") from error


class LiveWriter:
    """Writes mesh and light of one run.

    Parameters
    ----------
    partial : Path
        Folder that the results grow in.
    """

    def __init__(self, partial: Path) -> None:
        self._partial = partial
        self._elements: Elements | None = None
        self._mesh = 0
        self._light = 0

    def write(self, scene: Scene, elements: Elements, light: Light, words: str, *, settled: bool) -> None:
        """Write the light, and the mesh before it if it is another one.

        Parameters
        ----------
        words : str
            Where the run stands.
        settled : bool
            Whether at least one replicate is done, so that the light won't grow much.

        Raises
        ------
        OutputError
            When it can't be written.
        """
        import h5py

        folder = self._partial / LIVE_FOLDER
        if elements is not self._elements or not (folder / _MESH).exists():
            self._mesh += 1
            write_file(folder / _MESH, _mesh_file(scene, elements, self._mesh))
            self._elements = elements
        self._light += 1
        memory = io.BytesIO()
        with h5py.File(memory, "w") as file:
            file.attrs["mesh"], file.attrs["number"], file.attrs["words"] = self._mesh, self._light, words
            file.attrs["replicates"], file.attrs["settled"] = light.replicates, settled
            file["irradiance"] = light.irradiance.astype(np.float32)
            file["exposed"], file["space"] = light.exposed, light.space
        write_file(folder / _LIGHT, memory.getvalue())


def _mesh_file(scene: Scene, elements: Elements, number: int) -> bytes:
    import h5py

    memory = io.BytesIO()
    with h5py.File(memory, "w") as file:
        file.attrs["mesh"] = number
        write_mesh(file.create_group("VTKHDF"), scene, elements, cell_numbers(scene, elements))
        own = file.create_group("hradiosity")
        write_names(own, scene)
        own["element_area_m2"] = elements.area
        write_drawing(own, scene, elements)
    return memory.getvalue()


@dataclass(frozen=True)
class Seen:
    """Light of a run: drawn with it; where the run stands, in words; whether a replicate is done."""

    drawn: Drawn
    words: str
    settled: bool


class LiveReader:
    """Follows the light of a run.

    Parameters
    ----------
    partial : Path
    """

    def __init__(self, partial: Path) -> None:
        self._folder = partial / LIVE_FOLDER
        self._drawn: Drawn | None = None
        self._mesh = self._number = 0

    def read(self) -> Seen | None:
        """The newest light; None where nothing is new.

        Half-written files do not exist, but mesh and light may be of two meshes for a moment: then nothing is new.
        """
        import h5py

        try:
            with h5py.File(self._folder / _LIGHT, "r") as file:
                mesh, number = int(file.attrs["mesh"]), int(file.attrs["number"])
                if (mesh, number) == (self._mesh, self._number):
                    return None
                light = Light(
                    np.asarray(file["irradiance"][()]),
                    np.asarray(file["exposed"][()]),
                    np.asarray(file["space"][()], np.int32),
                    int(file.attrs["replicates"]),
                )
                words, settled = str(file.attrs["words"]), bool(file.attrs["settled"])
            if mesh != self._mesh:
                self._drawn = self._read_mesh(mesh)
        except (OSError, KeyError):
            return None
        if self._drawn is None or not _fits(light.irradiance, self._drawn):
            return None
        self._mesh, self._number = mesh, number
        return Seen(replace(self._drawn, light=light), words, settled)

    def _read_mesh(self, number: int) -> Drawn | None:
        import h5py

        with h5py.File(self._folder / _MESH, "r") as file:
            if int(file.attrs["mesh"]) != number:
                return None
        return read_drawn(self._folder / _MESH)


def _fits(irradiance: NDArray[np.floating], drawn: Drawn) -> bool:
    """Whether the light is that of the mesh."""
    n_elements = int(drawn.cells.element.max(initial=-1)) + 1
    return irradiance.shape == (n_elements, len(drawn.words.bands))

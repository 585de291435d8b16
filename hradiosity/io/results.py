"""The results of a run on disk."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from hradiosity.io.checkpoint import MESH_FILE
from hradiosity.io.output_folder import RUN_FILE, write_file
from hradiosity.io.results_glare import glare_table, sources_table
from hradiosity.io.results_mesh import mesh_file
from hradiosity.io.results_tables import luminances, luminances_table, readings_table, spectra_table
from hradiosity.io.results_variants import write_variants
from hradiosity.io.run_record import run_record, to_json
from hradiosity.model.scene import Scene
from hradiosity.model.variants import MAINTAINED
from hradiosity.readings.glare import Glare
from hradiosity.solution import Solution


def write_results(
    folder: Path, solution: Solution, checkpoint: Mapping[str, NDArray[Any]], digest: str, *, parts: bool = False
) -> None:
    """Write tables, of variants too, and mesh into a folder that exists; ``run.json`` comes last, by `write_run`.

    Parameters
    ----------
    parts : bool
        With what the half widths of the illuminances are made of.

    Raises
    ------
    OutputError
        When a file can't be written.
    """
    bands, readings = solution.scene.bands, solution.readings
    kept = solution.variants.get(MAINTAINED)
    maintained = None if kept is None else kept.readings
    write_file(folder / "readings.csv", readings_table(readings, bands, parts=parts, maintained=maintained))
    if luminances(readings):
        write_file(folder / "luminances.csv", luminances_table(readings, bands))
        write_file(folder / "radiances.csv", spectra_table(readings, bands, looked_at=True))
    write_file(folder / "spectra.csv", spectra_table(solution.readings, bands))
    write_file(folder / "spectra_half_width.csv", spectra_table(solution.readings, bands, half_width=True))
    write_variants(folder, solution, parts=parts)
    write_file(folder / MESH_FILE, mesh_file(solution, checkpoint, digest))


def write_glare(folder: Path, scene: Scene, glare: Mapping[str, Glare]) -> None:
    """Write what observers were found to be glared by.

    Raises
    ------
    OutputError
        When a file can't be written.
    """
    write_file(folder / "glare.csv", glare_table(scene, glare))
    write_file(folder / "glare_sources.csv", sources_table(scene, glare))


def write_run(folder: Path, solution: Solution, state: str, more: Mapping[str, Any]) -> None:
    """Write ``run.json``, which says that the folder is whole.

    Parameters
    ----------
    state : str
        See `run_record`.
    more : mapping
        Further entries.

    Raises
    ------
    OutputError
        When it can't be written.
    """
    write_file(folder / RUN_FILE, (to_json(run_record(solution, state, more), indent=1) + "\n").encode())

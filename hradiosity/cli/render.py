"""``hradiosity render``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from hradiosity.cli.settings import EFFORT, OUTPUT, Settings
from hradiosity.cli.values import White
from hradiosity.errors import Fault, SceneError


def render(
    scene: Path,
    /,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"], group=OUTPUT)] = None,
    settings: Settings | None = None,
    resume: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False,
    referee: Annotated[int | None, Parameter(group=EFFORT)] = None,
    audit: Annotated[bool, Parameter(negative="--no-audit", group=EFFORT)] = True,
    pictures: Annotated[bool, Parameter(negative="--no-pictures", group=OUTPUT)] = True,
    white: Annotated[White, Parameter(group=OUTPUT)] = White.as_measured,
    sensitivity: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False,
    interval_parts: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False,
    full_metrics: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False,
    quiet: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False,
    json: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False,
) -> int:
    """Compute the light of a scene: spectra at its sensors and on its surfaces, with 95 % intervals.

    Ctrl-C keeps what is known and says how to go on.

    Exit status: 0 good, 2 bad input, 3 accuracy not reached, 130 interrupted; results are written in all but 2.

    Parameters
    ----------
    scene
        Folder with scene.toml, or the file.
    out
        Folder for the results, replaced as a whole at the end; results/NAME if left out.
    resume
        Go on from an interrupted run, or from the result in the folder.
    referee
        Compare with so many unbiased paths from each reading.
    audit
        Check the intervals by unbiased paths from some readings, which takes up to a quarter of the time again.
    pictures
        Draw the views of the scene.
    white
        What pictures show as white: as-measured, the display's own white, so that warm light looks warm; or lamps,
        the mean light of the scene's lamps, as to an eye that has got used to it.
    sensitivity
        Write sensitivity.csv: what reflectances, lamps and the sky change, which intervals do not cover.
    interval_parts
        In readings.csv, tell what the intervals are made of: sampling, mesh, iteration, spectral, precision.
    full_metrics
        In readings.csv, R1 to R14, Rf and Rg too.
    quiet
        Show nothing but errors.
    json
        One JSON object a line on standard output in place of words.
    """
    from hradiosity.cli.request import Request
    from hradiosity.cli.session import run

    if referee is not None and referee < 1:
        raise SceneError([Fault("command line", "", f"referee must be at least 1, is {referee}", "")])
    chosen = settings or Settings()
    return run(
        Request(
            scene=scene,
            out=out if out is not None else Path("results") / name_of(scene),
            options=replace(chosen.options(), audit=audit, pictures=pictures, full_metrics=full_metrics),
            device=chosen.device,
            resume=resume,
            referee=referee,
            pictures=pictures,
            white=white.value,
            sensitivity=sensitivity,
            interval_parts=interval_parts,
            quiet=quiet,
            json=json,
        )
    )


def name_of(scene: Path) -> str:
    """The scene's folder, or its file without suffix unless that is ``scene.toml``."""
    path = scene.resolve()
    if path.suffix == ".toml":
        return path.parent.name if path.name == "scene.toml" else path.stem
    return path.name

"""``hradiosity render``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from hradiosity.cli.outputs import Outputs
from hradiosity.cli.settings import EFFORT, OUTPUT, Settings
from hradiosity.errors import Fault, SceneError


def render(
    scene: Path,
    /,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"], group=OUTPUT)] = None,
    settings: Settings | None = None,
    referee: Annotated[int | None, Parameter(group=EFFORT)] = None,
    audit: Annotated[bool, Parameter(negative="--no-audit", group=EFFORT)] = True,
    outputs: Outputs | None = None,
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
    referee
        Compare with so many unbiased paths from each reading.
    audit
        Check the intervals by unbiased paths from some readings, which takes up to a quarter of the time again.
    """
    from hradiosity.cli.request import Request
    from hradiosity.cli.session import run

    if referee is not None and referee < 1:
        raise SceneError([Fault("command line", "", f"referee must be at least 1, is {referee}", "")])
    chosen, wanted = settings or Settings(), outputs or Outputs()
    images = chosen.quality == "image"
    wanted.check(images=images)
    options = replace(
        chosen.options(), audit=audit, pictures=wanted.pictures or bool(wanted.mapped), full_metrics=wanted.full_metrics
    )
    folder = out if out is not None else Path("results") / name_of(scene)
    return run(Request(scene, folder, options, chosen.device, referee, wanted, images))


def name_of(scene: Path) -> str:
    """The scene's folder, or its file without suffix unless that is ``scene.toml``."""
    path = scene.resolve()
    if path.suffix == ".toml":
        return path.parent.name if path.name == "scene.toml" else path.stem
    return path.name

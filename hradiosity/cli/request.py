"""What a render was asked for, and what its parts share while it runs."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hradiosity.cli.display import Display
    from hradiosity.cli.outputs import Outputs
    from hradiosity.device import Device
    from hradiosity.model.scene import Scene
    from hradiosity.options import Options


PREVIEW = Path("pictures", "preview.png")
"""In the folder where results grow: the first picture, and what takes its place until the real ones are drawn."""


@dataclass(frozen=True)
class Request:
    """What the command line asked for; see ``hradiosity render --help``.

    images : whether pictures are images, computed in every pixel, and not of the model
    """

    scene: Path
    out: Path
    options: Options
    device: str | None
    referee: int | None
    outputs: Outputs
    images: bool = False


@dataclass
class Run:
    """One render, once its scene is read and its output folder is proved to be writable.

    request : Request
    scene : Scene
    out, partial : the folder for the results, and the one where they grow
    device : Device
    display : Display
    seconds : wall seconds of each stage that is not the solver's
    more : what run.json and the last event of ``--json`` say beside the solution's record
    closing : titles and lines that the report ends with
    known_builds : kernels that earlier runs had built
    keep_partial : whether the partial folder may hold something worth keeping
    """

    request: Request
    scene: Scene
    out: Path
    partial: Path
    device: Device
    display: Display
    seconds: dict[str, float]
    more: dict[str, Any] = field(default_factory=dict)
    closing: list[tuple[str, list[str]]] = field(default_factory=list)
    known_builds: frozenset[str] = frozenset()
    keep_partial: bool = True


def command() -> str:
    """The command line of this process, without ``--resume``."""
    return shlex.join(["hradiosity", *(word for word in sys.argv[1:] if word != "--resume")])


def short(path: Path) -> str:
    """Relative to the working folder when it lies inside."""
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else str(path)

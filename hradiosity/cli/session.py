"""One render from the scene file to the folder of results.

What is imported here is what the first picture needs; the solver is loaded once that picture is there.
"""

from __future__ import annotations

import time
from contextlib import suppress
from typing import TYPE_CHECKING

from hradiosity.cli.display import open_display
from hradiosity.cli.interrupts import held_back, termination_interrupts
from hradiosity.cli.request import PREVIEW, Request, Run
from hradiosity.device import Device
from hradiosity.errors import OutputError
from hradiosity.io.builds import load_builds
from hradiosity.io.output_folder import CHECKPOINT_FILE, close_partial, open_partial
from hradiosity.io.output_lock import locked
from hradiosity.io.scene_toml import load_scene
from hradiosity.show.first_picture import write_first_picture

if TYPE_CHECKING:
    from hradiosity.cli.computing import Computation


def run(request: Request) -> int:
    """Do it; returns the exit status.

    Raises
    ------
    HradiosityError
        For mistakes of the user, an output that can't be written and devices that fail.
    """
    if request.outputs.view:
        from hradiosity.show.window.display import check_display

        check_display("leave out --view; `hradiosity view OUT --screenshot FILE` shows the result without one")
    start = time.perf_counter()
    scene = load_scene(request.scene)
    request.outputs.check_objects(scene)
    reading = time.perf_counter() - start
    out = request.out.resolve()
    with locked(out):
        with held_back() as came:
            partial = open_partial(out, keep=request.outputs.resume)
        taken_up = request.outputs.resume and (partial / CHECKPOINT_FILE).exists()
        computation: Computation | None = None
        try:
            if came:
                raise KeyboardInterrupt
            with termination_interrupts():
                device = Device(request.device)
                with open_display(quiet=request.outputs.quiet, json=request.outputs.json) as display:
                    started = Run(request, scene, out, partial, device, display, {"reading the scene": reading})
                    computation = _start(started)
                    return computation.run()
        finally:
            if not taken_up and (computation is None or computation.nothing_known):
                close_partial(out)


def _start(run: Run) -> Computation:
    """Open the window and draw the first picture, then load the solver."""
    if run.request.outputs.view:
        from hradiosity.cli.watching import open_window

        open_window(run)
    run.known_builds = load_builds(run.device.description)
    _announce_builds(run)
    if run.request.outputs.pictures and not run.request.outputs.resume:
        start = time.perf_counter()
        _draw_first_picture(run)
        run.seconds["first picture"] = time.perf_counter() - start
    from hradiosity.cli.computing import Computation

    return Computation(run)


def _announce_builds(run: Run) -> None:
    """Say so when a kernel is built that no earlier run had built."""
    said = False

    def listen(build: str) -> None:
        nonlocal said
        if build not in run.known_builds and not said:
            said = True
            run.display.building()

    run.device.on_build = listen


def _draw_first_picture(run: Run) -> None:
    """Show the scene in ``pictures/preview.png`` before anything is solved; a full disk does not stop the run."""
    if not len(run.scene.patches):
        return
    picture = run.partial / PREVIEW
    with suppress(OutputError, OSError):
        picture.parent.mkdir(exist_ok=True)
        write_first_picture(run.scene, run.device, picture, run.request.outputs.white.value)

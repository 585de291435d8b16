"""``hradiosity view``."""

from __future__ import annotations

import math
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

from cyclopts import Parameter

from hradiosity.cli.values import FalseColor, FalseColorScale, White
from hradiosity.errors import Fault, SceneError

if TYPE_CHECKING:
    from hradiosity.show.window.app import Request

ViewMode = Literal["flat", "smooth", "wireframe", "unshaded", "false-color"]
_PATIENCE: Final = 60.0
"""Seconds that a window waits for the first light of a run."""


def view(
    shown: Path,
    other: Path | None = None,
    /,
    *,
    follow: Path | None = None,
    mode: ViewMode = "flat",
    camera: str | None = None,
    false_color: FalseColor | None = None,
    false_color_scale: FalseColorScale | None = None,
    false_color_range: Annotated[tuple[float, float] | None, Parameter(negative="")] = None,
    white: White | None = None,
    exposure: float | None = None,
    difference: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    size: tuple[int, int] = (1280, 800),
    pick: Annotated[tuple[int, int] | None, Parameter(negative="")] = None,
    screenshot: Path | None = None,
    html: Path | None = None,
) -> int:
    """Open a window on a scene before it is solved, on a result, on two results, or on a run that goes on.

    Keys are told by h in the window. Exit status 2 without a display, unless --screenshot or --html is given.

    Parameters
    ----------
    shown
        Folder of a scene or its file; folder of a result; or that of a run that goes on, which is followed.
    other
        A second result, side by side or as a difference: where elements differ, of what is smooth inside of surfaces.
        Or a second scene beside a scene.
    follow
        Folder of a run whose light takes the place of the scene as it is found.
    mode
        What to start with.
    camera
        Name of the camera to start with; the first one if left out.
    false_color
        What false colours stand for: illuminance or luminance; as in the result's pictures if left out.
    false_color_scale
        Linear or log.
    false_color_range
        Lowest and highest number of the false colours, in lx or cd/m².
    white
        What is shown as white: as-measured, or the mean light of the lamps; as in the result's pictures if left out.
    exposure
        Luminance that is shown as white, in cd/m²; as in the result's pictures if left out.
    difference
        Start with the difference of two results.
    size
        Width and height of the window in pixels.
    pick
        Pick what is there: pixels from the left and from the top.
    screenshot
        Write this PNG file in place of opening a window; needs no display.
    html
        Write this page, which opens in a browser without a server, in place of opening a window.
    """
    from hradiosity.show.window.app import Request
    from hradiosity.show.window.look import Look
    from hradiosity.show.window.subject import Choices

    _check(exposure, false_color_range, false_color_scale == "log", size)
    _check_files(follow, pick, size, screenshot, html)
    _check_two(other, html, difference=difference)
    request = Request(
        paths=(shown,) if other is None else (shown, other),
        follow=follow,
        look=Look(
            mode=mode,
            quantity=false_color or "illuminance",
            logarithmic=false_color_scale == "log",
            compare="difference" if difference else "side by side",
        ),
        choices=Choices(exposure, None if white is None else white.value, false_color_range),
        view=camera,
        size=size,
        pick=pick,
        screenshot=screenshot,
        page=html,
        look_chosen=false_color is not None or false_color_scale is not None,
    )
    return _open(request)


def _open(request: Request) -> int:
    """Show what is asked for; a run that goes on there is followed."""
    from hradiosity.show.window.app import running_in, view

    alone = len(request.paths) == 1 and request.follow is None
    running = running_in(request.paths[0]) if alone else None
    view(request if running is None else _of_run(request, running))
    return 0


def _of_run(request: Request, out: Path) -> Request:
    """Follow a run: its mesh is shown as soon as it tells it."""
    from hradiosity.io.live_light import LiveReader, ask_for_light
    from hradiosity.io.output_folder import partial_of
    from hradiosity.show.window.display import check_display

    if request.screenshot is None and request.page is None:
        check_display()
    partial = partial_of(out)
    print(f"waiting for the light of the run in {partial}", file=sys.stderr)
    reader, end = LiveReader(partial), time.monotonic() + _PATIENCE
    while time.monotonic() < end and partial.is_dir():
        ask_for_light(partial)
        found = reader.read()
        if found is not None:
            return replace(request, follow=out, drawn=found.drawn)
        time.sleep(0.2)
    if not partial.is_dir():
        return replace(request, paths=(out,))
    raise SceneError([Fault(str(partial), "", "no run shows its light there", "start or resume it, then look again")])


def _check(exposure: float | None, scale: tuple[float, float] | None, logarithmic: bool, size: tuple[int, int]) -> None:
    """Raise `SceneError` for numbers that make no sense."""
    if exposure is not None and not (math.isfinite(exposure) and exposure > 0.0):
        raise _fault("--exposure", f"is {exposure:g}", "a luminance above 0 cd/m²")
    if scale is not None:
        low, high = scale
        good = math.isfinite(low) and math.isfinite(high) and low < high and (low > 0.0 or not logarithmic)
        if not good:
            wanted = "the lower number first" + (", and above 0 for a logarithmic scale" if logarithmic else "")
            raise _fault("--false-color-range", f"{low:g} {high:g} is no range", wanted)
    if not (320 <= size[0] <= 8192 and 240 <= size[1] <= 8192):
        raise _fault("--size", f"is {size[0]} {size[1]}", "320 × 240 to 8192 × 8192 pixels")


def _check_two(other: Path | None, html: Path | None, *, difference: bool) -> None:
    """Raise `SceneError` for one result in place of two, and for two in place of one."""
    if other is None and difference:
        raise _fault("--difference", "there is one result", "two: hradiosity view FIRST SECOND --difference")
    if other is not None and html is not None:
        raise _fault("--html", "there are two results", "one, which the page shows; or --screenshot, which shows two")


def _check_files(
    follow: Path | None, pick: tuple[int, int] | None, size: tuple[int, int], screenshot: Path | None, html: Path | None
) -> None:
    """Raise `SceneError` for files of another kind, a place outside of the window, a run that no file would show."""
    kinds = (("--screenshot", screenshot, (".png",)), ("--html", html, (".html", ".htm")))
    for entry, file, endings in kinds:
        if file is not None and file.suffix.lower() not in endings:
            raise _fault(entry, f"is {str(file)!r}", f"a file name that ends in {endings[0]}")
    if pick is not None and not (0 <= pick[0] < size[0] and 0 <= pick[1] < size[1]):
        raise _fault("--pick", f"is {pick[0]} {pick[1]}", f"a place in the window of {size[0]} × {size[1]} pixels")
    if follow is not None and (screenshot is not None or html is not None):
        raise _fault(
            "--follow", "given for a file", f"hradiosity view {follow}, which shows the run that goes on there"
        )


def _fault(entry: str, found: str, expected: str) -> SceneError:
    return SceneError([Fault("command line", entry, found, expected)])

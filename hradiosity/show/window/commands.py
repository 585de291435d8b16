"""What each key and button does to the viewer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from hradiosity.errors import OutputError, SceneError
from hradiosity.show.window.look import MODES, NO_LINES, Look, Section
from hradiosity.show.window.marks import scene_size
from hradiosity.show.window.navigation import STEP
from hradiosity.show.window.outlines import hierarchy_levels
from hradiosity.show.window.standpoints import camera_pose, outside_pose

if TYPE_CHECKING:
    from hradiosity.show.window.viewer import Viewer

STOP: Final = 1.0 / 3.0
"""Of exposure, by one key, in factors of two."""
SECTION_STEP: Final = 0.02
TURN: Final = np.radians(4.0)
"""By one key."""


def _change(viewer: Viewer, **changes: Any) -> None:
    viewer.look = replace(viewer.look, **changes)


def _change_with(change: Callable[[Look], Look]) -> Callable[[Viewer], None]:
    """A command that changes the look alone."""

    def command(viewer: Viewer) -> None:
        viewer.look = change(viewer.look)

    return command


def _toggle(name: str) -> Callable[[Viewer], None]:
    """A command that switches one entry of the look."""

    def command(viewer: Viewer) -> None:
        _change(viewer, **{name: not getattr(viewer.look, name)})

    return command


def _switch_quantity(viewer: Viewer) -> None:
    _change(viewer, quantity="luminance" if viewer.look.quantity == "illuminance" else "illuminance")


def _coarser_lines(viewer: Viewer) -> None:
    """One level coarser; none after whole patches, so that one button does."""
    levels = hierarchy_levels(viewer.subject.cells)
    done = viewer.look.lines >= levels
    viewer.look = replace(viewer.look, lines=NO_LINES) if done else viewer.look.next_lines(1, levels)


def _finer_lines(viewer: Viewer) -> None:
    viewer.look = viewer.look.next_lines(-1, hierarchy_levels(viewer.subject.cells))


def _move_section(viewer: Viewer, step: float) -> None:
    _change(viewer, section=(viewer.look.section or Section()).moved(step))


def _flip_section(viewer: Viewer) -> None:
    section = viewer.look.section
    if section is not None:
        _change(viewer, section=replace(section, flipped=not section.flipped))


def _show_next_view(viewer: Viewer) -> None:
    views = viewer.subject.drawn.views
    if not views:
        viewer.message = "the scene has no cameras"
        return
    view = views[viewer.next_view % len(views)]
    viewer.next_view += 1
    viewer.pose = camera_pose(viewer.subject, view, viewer.part_size)
    viewer.message = f"camera {view.name}"


def _show_overview(viewer: Viewer) -> None:
    viewer.pose, viewer.walking = outside_pose(viewer.subject, viewer.part_size), False


def _switch_walk(viewer: Viewer) -> None:
    viewer.walking = not viewer.walking


def _step(viewer: Viewer, ahead: float, right: float, up: float) -> None:
    size = scene_size(viewer.subject.cells)
    length = STEP * size
    if viewer.walking:
        viewer.pose = viewer.pose.walked(length * ahead, length * right, length * up)
    else:
        viewer.pose = viewer.pose.orbited(TURN * right, -TURN * ahead).nearer(up, size)


def _switch_curve(viewer: Viewer) -> None:
    viewer.curve += 1


def _switch_compare(viewer: Viewer) -> None:
    if len(viewer.stands) < 2:
        viewer.message = "a second result is needed: hradiosity view FIRST SECOND"
        return
    if viewer.look.compare == "difference":
        _change(viewer, compare="side by side")
        return
    try:
        viewer.compare()
    except SceneError as error:
        viewer.message = str(error)
    else:
        _change(viewer, compare="difference")


def _switch_help(viewer: Viewer) -> None:
    viewer.help_shown = not viewer.help_shown


def _close(viewer: Viewer) -> None:
    if viewer.help_shown:
        viewer.help_shown = False
    elif viewer.picked is not None:
        viewer.unpick()
    else:
        viewer.closed = True


def _write(viewer: Viewer, suffix: str, write: Callable[[Path], None]) -> None:
    """Write a file with a new name into the working folder, and say so."""
    stem = "".join(c if c.isalnum() or c in "-_" else "_" for c in Path(viewer.names[0]).name) or "view"
    path = next(p for n in range(1, 100000) if not (p := Path(f"{stem}_{n:02d}.{suffix}")).exists())
    try:
        write(path)
    except OutputError as error:
        viewer.message = str(error)
    else:
        viewer.message = f"wrote {path}"


_MOVES: Final = {
    "ahead": (1.0, 0.0, 0.0),
    "back": (-1.0, 0.0, 0.0),
    "left": (0.0, -1.0, 0.0),
    "right": (0.0, 1.0, 0.0),
    "up": (0.0, 0.0, 1.0),
    "down": (0.0, 0.0, -1.0),
}
COMMANDS: Final[dict[str, Callable[[Viewer], None]]] = {
    **{mode: partial(_change, mode=mode) for mode in MODES},
    **{name: partial(_step, ahead=move[0], right=move[1], up=move[2]) for name, move in _MOVES.items()},
    "quantity": _switch_quantity,
    "logarithmic": _toggle("logarithmic"),
    "brighter": _change_with(lambda look: replace(look, stops=look.stops + STOP)),
    "darker": _change_with(lambda look: replace(look, stops=look.stops - STOP)),
    "exposure": _change_with(lambda look: replace(look, stops=0.0)),
    "coarser lines": _coarser_lines,
    "finer lines": _finer_lines,
    "section": _change_with(Look.next_section),
    "section back": partial(_move_section, step=-SECTION_STEP),
    "section ahead": partial(_move_section, step=SECTION_STEP),
    "section flip": _flip_section,
    "backs": _toggle("backs"),
    "marks": _toggle("marks"),
    "gamut": _toggle("gamut"),
    "next view": _show_next_view,
    "overview": _show_overview,
    "walk": _switch_walk,
    "curve": _switch_curve,
    "compare": _switch_compare,
    "screenshot": lambda viewer: _write(viewer, "png", viewer.write_screenshot),
    "page": lambda viewer: _write(viewer, "html", viewer.write_page),
    "help": _switch_help,
    "close": _close,
}

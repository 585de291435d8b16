"""The window without its events: every key and button is a method, which works without a display as well."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import OutputError, SceneError
from hradiosity.io.drawn_scene import Drawn
from hradiosity.io.live_light import Seen
from hradiosity.model.scene import View
from hradiosity.show.files import png_bytes, write_bytes
from hradiosity.show.scale_bar import Scale
from hradiosity.show.window.difference import check_same_mesh, difference, difference_bytes, difference_scale
from hradiosity.show.window.facts import Facts, facts_of, joined_facts
from hradiosity.show.window.look import MODES, NO_LINES, Look, Section
from hradiosity.show.window.marks import scene_size
from hradiosity.show.window.navigation import STEP, Pose, overview, pose_of_view
from hradiosity.show.window.outlines import hierarchy_levels
from hradiosity.show.window.overlays import Overlays
from hradiosity.show.window.picking import Picked, pick
from hradiosity.show.window.stand import Stand, cut_plane
from hradiosity.show.window.subject import Paint, Subject

SIZE: Final = (1280, 800)
SAMPLES: Final = 8
"""Of each pixel of a screenshot; a window that moves has one, which software draws three times as fast."""
STOP: Final = 1.0 / 3.0
"""Of exposure, by one key, in factors of two."""
SECTION_STEP: Final = 0.02
TURN: Final = np.radians(4.0)
"""By one key."""


class Viewer:
    """One or two subjects in a window, or in none.

    Parameters
    ----------
    subjects : sequence of Subject
        One, or two of one mesh.
    names : sequence of str
        Of them, for the status line and files.
    size : (int, int)
        Of the window [pixels].
    off_screen : bool
    look : Look
    view : str, optional
        Name of the camera to start with; the first one if left out.
    """

    def __init__(
        self,
        subjects: Sequence[Subject],
        names: Sequence[str],
        *,
        size: tuple[int, int] = SIZE,
        off_screen: bool,
        look: Look | None = None,
        view: str | None = None,
    ) -> None:
        self.look, self.names = look or Look(), tuple(names)
        self.plotter = _plotter(len(subjects), size, off_screen)
        self.stands = [Stand(r, s) for r, s in zip(self.plotter.renderers, subjects)]
        self.overlays = Overlays(self.plotter.ren_win)
        self._picked: list[Picked | None] = []
        self.curve = 0
        self.walking = False
        self.help_shown = False
        self.running = ""
        self.message = ""
        self.closed = False
        self._settled = False
        self._next_view = 0
        self._commands = self._make_commands()
        self.pose = self._first_pose(view)
        self.refresh()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the window [pixels]."""
        width, height = self.plotter.ren_win.GetSize()
        return int(width), int(height)

    @property
    def part_size(self) -> tuple[int, int]:
        """Of the part that one subject is shown in."""
        width, height = self.size
        return (width // 2 if self.split else width), height

    @property
    def split(self) -> bool:
        """Whether two results are shown side by side."""
        return len(self.stands) == 2 and self.look.compare == "side by side"

    @property
    def subject(self) -> Subject:
        """The first one."""
        return self.stands[0].subject

    def command(self, name: str) -> None:
        """Do what a key or button says, and draw."""
        self.message = ""
        self._commands[name]()
        self.refresh()

    def refresh(self) -> None:
        """Colours, marks and legends anew, and draw."""
        self._arrange()
        if self.shows_difference:
            self.stands[0].show(self.look, self._difference_paint()[0])
        else:
            for stand in self.stands:
                stand.show(self.look)
        self.redraw()

    def redraw(self) -> None:
        """Draw with the camera where it is, and what lies over the picture."""
        self._drawn_size = self.size
        for stand in self.stands:
            stand.look_from(self.pose)
        self.overlays.update(self)
        self.plotter.ren_win.Render()

    def resized(self) -> None:
        """Put what lies over the picture where it belongs in a window of another size."""
        if self.size != self._drawn_size:
            self.redraw()

    def pixels(self) -> NDArray[np.uint8]:
        """(height, width, 3) what the window shows."""
        import pyvista
        from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

        window = self.plotter.ren_win
        window.SetMultiSamples(SAMPLES)
        window.Render()
        grab = vtkWindowToImageFilter()
        grab.SetInput(self.plotter.ren_win)
        grab.SetInputBufferTypeToRGB()
        grab.ReadFrontBufferOff()
        grab.Update()
        image = grab.GetOutput()
        width, height, _ = image.GetDimensions()
        window.SetMultiSamples(0)
        flat: NDArray[np.uint8] = pyvista.convert_array(image.GetPointData().GetScalars())
        return flat.reshape(height, width, 3)[::-1].copy()

    def write_screenshot(self, path: Path) -> None:
        """Write what the window shows as a PNG file.

        Raises
        ------
        OutputError
            When it can't be written.
        """
        write_bytes(path, png_bytes(self.pixels(), {"Title": " and ".join(self.names)}))

    def click(self, x: float, y: float) -> None:
        """Press a button, or pick what is there; x, y in pixels from the lower left corner."""
        button = self.overlays.button_at(x, self.size[1] - y)
        if button is not None:
            self.command(button.command)
            return
        width, height = self.part_size
        place = x - width if self.split and x >= width else x, y
        self._picked = [self._pick(stand, place, (width, height)) for stand in self.stands]
        self.curve = 0
        for stand, picked in zip(self.stands, self._picked, strict=True):
            stand.mark(picked)
        self.redraw()

    def _pick(self, stand: Stand, place: tuple[float, float], size: tuple[int, int]) -> Picked | None:
        drawn = stand.subject.drawn
        sensors = drawn.sensors.position if self.look.marks else np.zeros((0, 3))
        return pick(drawn.cells, sensors, self.pose, place, size, cut_plane(drawn.cells, self.look.section))

    @property
    def picked(self) -> Picked | None:
        """In the first subject that shows something there."""
        return next((picked for picked in self._picked if picked is not None), None)

    def drag(self, dx: float, dy: float, *, move: bool) -> None:
        """Turn or move by pixels to the right and upwards."""
        height = self.part_size[1]
        if move:
            metres = 2.0 * self.pose.distance * np.tan(0.5 * self.pose.angle) / height
            self.pose = self.pose.panned(-metres * dx, -metres * dy)
        elif self.walking:
            angle = self.pose.angle / height
            self.pose = self.pose.turned(dx * angle, -dy * angle)
        else:
            self.pose = self.pose.orbited(-np.pi * dx / height, np.pi * dy / height)
        self.redraw()

    def wheel(self, notches: float) -> None:
        """Nearer or farther; ahead or back on foot."""
        size = scene_size(self.subject.cells)
        self.pose = (
            self.pose.walked(2.0 * STEP * size * notches, 0.0, 0.0) if self.walking else self.pose.nearer(notches, size)
        )
        self.redraw()

    def facts(self) -> Facts | None:
        """About what was picked; of both results where two are shown."""
        pairs = [
            (stand.subject.drawn, picked) for stand, picked in zip(self.stands, self._picked) if picked is not None
        ]
        found = [facts_of(drawn, drawn.light, picked) for drawn, picked in pairs]
        if not found:
            return None
        return found[0] if len(found) == 1 else joined_facts(found[0], found[1])

    def take_light(self, seen: Seen) -> None:
        """Show newer light of a run that is followed; a new mesh takes the place of the old one.

        The exposure is chosen with the first light, and once more when a replicate is done; then it stays.
        """
        stand, keep = self.stands[0], self.subject.drawn
        if stand.subject.cells is not seen.drawn.cells or (seen.settled and not self._settled):
            drawn = replace(seen.drawn, views=seen.drawn.views or keep.views, sensors=keep.sensors)
            stand.take_subject(Subject(drawn, stand.subject.choices))
            self._picked = []
        elif seen.drawn.light is not None:
            stand.subject.take_light(seen.drawn.light)
        self._settled = seen.settled
        self.running = seen.words
        self.refresh()

    def take_result(self, drawn: Drawn, words: str) -> None:
        """Show the result that a followed run ended with."""
        self.stands[0].take_subject(Subject(drawn, self.subject.choices))
        self._picked, self.running = [], words
        self.refresh()

    def legend(self) -> tuple[Scale, NDArray[np.float64] | None, str] | None:
        """Scale, colours other than the pictures', and a note, where colours stand for numbers."""
        if self.shows_difference:
            from hradiosity.show.window.difference import difference_colours

            return self._difference_paint()[1], difference_colours(), "second − first"
        if self.look.mode == "false-color":
            return self.subject.scale(self.look), None, ""
        return None

    @property
    def shows_difference(self) -> bool:
        """Whether the difference of two results is shown."""
        return len(self.stands) == 2 and self.look.compare == "difference"

    def _difference_paint(self) -> tuple[Paint, Scale]:
        first, second = (stand.subject.values for stand in self.stands)
        if first is None or second is None:
            raise ValueError("a difference needs two results")
        quantity = self.look.quantity
        change = difference(first, second, quantity)
        scale = difference_scale(change, ~first.shining, quantity)
        end = scale.high * 2.0**-self.look.stops
        scale = replace(scale, low=-end, high=end)
        return Paint(difference_bytes(change, scale)), scale

    def _arrange(self) -> None:
        """Share the window among its parts."""
        if len(self.stands) == 2:
            self.stands[0].renderer.SetViewport(0.0, 0.0, 0.5 if self.split else 1.0, 1.0)
            self.stands[1].renderer.SetViewport(0.5, 0.0, 1.0, 1.0)
            self.stands[1].renderer.SetDraw(self.split)

    def _first_pose(self, name: str | None) -> Pose:
        views = self.subject.drawn.views
        chosen = next((k for k, view in enumerate(views) if view.name == name), 0)
        if not views:
            return self._overview()
        self._next_view = chosen + 1
        return self._pose_of(views[chosen])

    def _pose_of(self, view: View) -> Pose:
        width, height = self.part_size
        return pose_of_view(view, width / height, 0.35 * scene_size(self.subject.cells))

    def _overview(self) -> Pose:
        corners = self.subject.cells.corners
        width, height = self.part_size
        if not len(corners):
            return overview(np.zeros(3), np.ones(3), width / height)
        return overview(corners.min(axis=(0, 1)), corners.max(axis=(0, 1)), width / height)

    def _make_commands(self) -> dict[str, Callable[[], None]]:
        modes: dict[str, Callable[[], None]] = {mode: partial(self._change, mode=mode) for mode in MODES}
        moves = {
            "ahead": (1.0, 0.0, 0.0),
            "back": (-1.0, 0.0, 0.0),
            "left": (0.0, -1.0, 0.0),
            "right": (0.0, 1.0, 0.0),
            "up": (0.0, 0.0, 1.0),
            "down": (0.0, 0.0, -1.0),
        }
        return {
            **modes,
            **{name: partial(self._step, *step) for name, step in moves.items()},
            "quantity": self._switch_quantity,
            "logarithmic": lambda: self._change(logarithmic=not self.look.logarithmic),
            "brighter": lambda: self._change(stops=self.look.stops + STOP),
            "darker": lambda: self._change(stops=self.look.stops - STOP),
            "exposure": lambda: self._change(stops=0.0),
            "coarser lines": self._coarser_lines,
            "finer lines": lambda: self._set_look(self.look.next_lines(-1, self._levels())),
            "section": lambda: self._set_look(self.look.next_section()),
            "section back": lambda: self._move_section(-SECTION_STEP),
            "section ahead": lambda: self._move_section(SECTION_STEP),
            "section flip": self._flip_section,
            "backs": lambda: self._change(backs=not self.look.backs),
            "marks": lambda: self._change(marks=not self.look.marks),
            "gamut": lambda: self._change(gamut=not self.look.gamut),
            "next view": self._show_next_view,
            "overview": self._show_overview,
            "walk": self._switch_walk,
            "curve": self._switch_curve,
            "compare": self._switch_compare,
            "screenshot": lambda: self._write("png", self.write_screenshot),
            "page": lambda: self._write("html", self.write_page),
            "help": self._switch_help,
            "close": self._close,
        }

    def write_page(self, path: Path) -> None:
        """Write an HTML page that shows the first subject.

        Raises
        ------
        OutputError
            When it can't be written.
        """
        from hradiosity.show.window.page import page_bytes

        write_bytes(path, page_bytes(self.subject, self.look, self.pose, self.names[0]))

    def _write(self, suffix: str, write: Callable[[Path], None]) -> None:
        """Write a file with a new name into the working folder, and say so."""
        stem = "".join(c if c.isalnum() or c in "-_" else "_" for c in Path(self.names[0]).name) or "view"
        path = next(p for n in range(1, 100000) if not (p := Path(f"{stem}_{n:02d}.{suffix}")).exists())
        try:
            write(path)
        except OutputError as error:
            self.message = str(error)
        else:
            self.message = f"wrote {path}"

    def _set_look(self, look: Look) -> None:
        self.look = look

    def _change(self, **changes: Any) -> None:
        self.look = replace(self.look, **changes)

    def _switch_quantity(self) -> None:
        self._change(quantity="luminance" if self.look.quantity == "illuminance" else "illuminance")

    def _levels(self) -> int:
        return hierarchy_levels(self.subject.cells)

    def _coarser_lines(self) -> None:
        """One level coarser; none after whole patches, so that one button does."""
        done = self.look.lines >= self._levels()
        self.look = replace(self.look, lines=NO_LINES) if done else self.look.next_lines(1, self._levels())

    def _move_section(self, step: float) -> None:
        section = self.look.section or Section()
        self._change(section=section.moved(step))

    def _flip_section(self) -> None:
        if self.look.section is not None:
            self._change(section=replace(self.look.section, flipped=not self.look.section.flipped))

    def _show_next_view(self) -> None:
        views = self.subject.drawn.views
        if not views:
            self.message = "the scene has no cameras"
            return
        view = views[self._next_view % len(views)]
        self._next_view += 1
        self.pose, self.message = self._pose_of(view), f"camera {view.name}"

    def _show_overview(self) -> None:
        self.pose, self.walking = self._overview(), False

    def _switch_walk(self) -> None:
        self.walking = not self.walking

    def _step(self, ahead: float, right: float, up: float) -> None:
        length = STEP * scene_size(self.subject.cells)
        if self.walking:
            self.pose = self.pose.walked(length * ahead, length * right, length * up)
        else:
            self.pose = self.pose.orbited(TURN * right, -TURN * ahead)
            self.pose = self.pose.nearer(up, scene_size(self.subject.cells)) if up else self.pose

    def _switch_curve(self) -> None:
        self.curve += 1

    def _switch_compare(self) -> None:
        if len(self.stands) < 2:
            self.message = "a second result is needed: hradiosity view FIRST SECOND"
            return
        if self.look.compare == "difference":
            self._change(compare="side by side")
            return
        first, second = (stand.subject.drawn for stand in self.stands)
        try:
            check_same_mesh(first, second, (self.names[0], self.names[1]))
        except SceneError as error:
            self.message = str(error)
        else:
            self._change(compare="difference")

    def _switch_help(self) -> None:
        self.help_shown = not self.help_shown

    def _close(self) -> None:
        if self.help_shown:
            self.help_shown = False
        elif self.picked is not None:
            self._picked = []
            for stand in self.stands:
                stand.mark(None)
        else:
            self.closed = True


def _plotter(n_parts: int, size: tuple[int, int], off_screen: bool) -> Any:
    import pyvista

    plotter: Any = pyvista.Plotter(
        off_screen=off_screen, shape=(1, n_parts), window_size=list(size), lighting="none", border=False
    )
    plotter.ren_win.SetMultiSamples(0)
    return plotter

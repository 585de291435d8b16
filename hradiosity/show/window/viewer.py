"""The window without its events: every key and button is a method, which works without a display as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.io.drawn_scene import Drawn
from hradiosity.io.live_light import Seen
from hradiosity.show.files import png_bytes, write_bytes
from hradiosity.show.window.commands import COMMANDS
from hradiosity.show.window.difference import (
    Comparison,
    Summary,
    difference_colours,
    painted_difference,
)
from hradiosity.show.window.facts import Facts, facts_of_both
from hradiosity.show.window.look import NO_LINES, Look
from hradiosity.show.window.marks import scene_size
from hradiosity.show.window.navigation import STEP, Pose
from hradiosity.show.window.overlays import Overlays
from hradiosity.show.window.panels import Legend
from hradiosity.show.window.picking import Picked, pick
from hradiosity.show.window.stage import open_window, window_pixels
from hradiosity.show.window.stand import Stand, cut_plane
from hradiosity.show.window.standpoints import camera_pose, outside_pose
from hradiosity.show.window.subject import Paint, Subject

SIZE: Final = (1280, 800)


class Viewer:
    """One or two subjects in a window, or in none.

    Parameters
    ----------
    subjects : sequence of Subject
        One, or two.
    names : sequence of str
        Of them, for the status line and files.
    size : (int, int)
        Of the window [pixels].
    off_screen : bool
    look : Look
    view : str, optional
        Name of the camera to start with; the first one if left out.

    Raises
    ------
    SceneError
        When a difference is asked for that can't be shown.
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
        self._comparison: Comparison | None = None
        if len(subjects) == 2 and self.look.compare == "difference":
            self._comparison = Comparison(subjects[0], subjects[1], (names[0], names[1]))
        self.summary: Summary | None = None
        self.window, renderers = open_window(len(subjects), size, off_screen)
        self.stands = [Stand(r, s) for r, s in zip(renderers, subjects, strict=True)]
        self.overlays = Overlays(self.window)
        self._picked: list[Picked | None] = []
        self._facts: Facts | None = None
        self.curve = 0
        self.facts_right = False
        self.walking = False
        self.help_shown = False
        self.running = ""
        self.message = ""
        self.legend: Legend | None = None
        self.closed = False
        self._settled, self._lit = False, self.subject.values is not None
        self.next_view = 0
        self.pose = self._first_pose(view)
        self.refresh()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the window [pixels]."""
        width, height = self.window.GetSize()
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
        self.message, before = "", self.look
        COMMANDS[name](self)
        if self.look == before:
            self.redraw()
        else:
            self.refresh()

    def unpick(self) -> None:
        """Forget what was picked."""
        self._take_picks([])
        for stand in self.stands:
            stand.mark(None)

    def refresh(self) -> None:
        """Colours, marks and legends anew, and draw."""
        self._arrange()
        self.legend = self.summary = None
        if self.shows_difference:
            comparison = self.compare()
            shown = painted_difference(comparison, self.look)
            self.summary, self.legend = shown.summary, Legend(shown.scale, difference_colours(), comparison.words)
            self.stands[comparison.base].show(shown.look, Paint(shown.colours))
        else:
            for stand in self.stands:
                stand.show(self.look)
            if self.look.mode == "false-color":
                self.legend = Legend(self.subject.scale(self.look), None, "")
        self.redraw()

    def redraw(self) -> None:
        """Draw with the camera where it is, and what lies over the picture."""
        self._drawn_size = self.size
        for stand in self.stands:
            stand.look_from(self.pose)
        self.overlays.update(self)
        self.window.Render()

    def resized(self) -> None:
        """Put what lies over the picture where it belongs in a window of another size."""
        if self.size != self._drawn_size:
            self.redraw()

    def pixels(self) -> NDArray[np.uint8]:
        """(height, width, 3) what the window shows."""
        return window_pixels(self.window)

    def write_screenshot(self, path: Path) -> None:
        """Write what the window shows as a PNG file.

        Raises
        ------
        OutputError
            When it can't be written.
        """
        write_bytes(path, png_bytes(self.pixels(), {"Title": " and ".join(self.names)}))

    def write_page(self, path: Path) -> None:
        """Write an HTML page that shows the first subject.

        Raises
        ------
        OutputError
            When it can't be written.
        """
        from hradiosity.show.window.page import page_bytes

        write_bytes(path, page_bytes(self.subject, self.look, self.pose, self.names[0]))

    def click(self, x: float, y: float) -> None:
        """Press a button, or pick what is there; x, y in pixels from the lower left corner."""
        button = self.overlays.button_at(x, self.size[1] - y)
        if button is not None:
            self.command(button.command)
            return
        width, height = self.part_size
        place = x - width if self.split and x >= width else x, y
        self._take_picks([self._pick(stand, place, (width, height)) for stand in self.stands])
        self.curve, self.facts_right = 0, x < 0.45 * self.size[0]
        for stand, picked in zip(self.stands, self._picked, strict=True):
            stand.mark(picked)
        self.redraw()

    def _pick(self, stand: Stand, place: tuple[float, float], size: tuple[int, int]) -> Picked | None:
        drawn = stand.subject.drawn
        sensors = stand.sensor_marks if self.look.marks else np.zeros((0, 3))
        return pick(drawn.cells, sensors, self.pose, place, size, cut_plane(drawn.cells, self.look.section))

    @property
    def picked(self) -> Picked | None:
        """In the first subject that shows something there."""
        return next((picked for picked in self._picked if picked is not None), None)

    def drag(self, dx: float, dy: float, *, move: bool, draw: bool = True) -> None:
        """Turn or move by pixels to the right and upwards, and draw unless somebody else does that soon."""
        height = self.part_size[1]
        if move:
            metres = 2.0 * self.pose.distance * np.tan(0.5 * self.pose.angle) / height
            self.pose = self.pose.panned(-metres * dx, -metres * dy)
        elif self.walking:
            angle = self.pose.angle / height
            self.pose = self.pose.turned(dx * angle, -dy * angle)
        else:
            self.pose = self.pose.orbited(-np.pi * dx / height, np.pi * dy / height)
        if draw:
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
        return self._facts

    def _take_picks(self, picks: list[Picked | None]) -> None:
        """What was picked in each subject, and what is known of it."""
        self._picked = picks
        pairs = zip(self.stands, picks)
        self._facts = facts_of_both([(stand.subject.drawn, found) for stand, found in pairs if found is not None])

    def take_light(self, seen: Seen) -> None:
        """Show newer light of a run that is followed; a new mesh takes the place of the old one.

        The exposure is chosen with the first light, and once more when a replicate is done; then it stays.
        """
        stand, keep = self.stands[0], self.subject.drawn
        if stand.subject.cells is not seen.drawn.cells or (seen.settled and not self._settled):
            drawn = replace(seen.drawn, views=seen.drawn.views or keep.views, sensors=keep.sensors)
            stand.take_subject(Subject(drawn, stand.subject.choices))
            self._take_picks([])
        elif seen.drawn.light is not None:
            stand.subject.take_light(seen.drawn.light)
            self._take_picks(self._picked)
        if not self._lit:
            self.look, self._lit = replace(self.look, lines=NO_LINES), True
        self._settled = seen.settled
        self.running = seen.words
        self.refresh()

    def take_result(self, drawn: Drawn, words: str) -> None:
        """Show the result that a followed run ended with."""
        self.stands[0].take_subject(Subject(drawn, self.subject.choices))
        self.running = words
        self._take_picks([])
        self.refresh()

    @property
    def shows_difference(self) -> bool:
        """Whether the difference of two results is shown."""
        return len(self.stands) == 2 and self.look.compare == "difference"

    def compare(self) -> Comparison:
        """The two results beside each other.

        Raises
        ------
        SceneError
            When they can't be compared.
        """
        if self._comparison is None:
            first, second = (stand.subject for stand in self.stands)
            self._comparison = Comparison(first, second, (self.names[0], self.names[1]))
        return self._comparison

    def _arrange(self) -> None:
        """Share the window among its parts."""
        if len(self.stands) == 2:
            base = self.compare().base if self.shows_difference else None
            for number, stand in enumerate(self.stands):
                left, right = (0.5 * number, 0.5 + 0.5 * number) if self.split else (0.0, 1.0)
                stand.renderer.SetViewport(left, 0.0, right, 1.0)
                stand.renderer.SetDraw(self.split or number == base)

    def _first_pose(self, name: str | None) -> Pose:
        views = self.subject.drawn.views
        chosen = next((k for k, view in enumerate(views) if view.name == name), 0)
        if not views:
            return outside_pose(self.subject, self.part_size)
        self.next_view = chosen + 1
        return camera_pose(self.subject, views[chosen], self.part_size)

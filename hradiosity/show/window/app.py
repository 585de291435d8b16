"""``hradiosity view``: what is opened, and whether a window or a picture comes of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from hradiosity.errors import Fault, SceneError
from hradiosity.io.drawn_scene import Drawn
from hradiosity.io.output_folder import RUN_FILE, RUNNING, partial_of, read_run
from hradiosity.io.results_reading import read_result
from hradiosity.show.files import write_bytes
from hradiosity.show.window.display import check_display, use_off_screen
from hradiosity.show.window.look import NO_LINES, Look, Quantity
from hradiosity.show.window.page import page_bytes
from hradiosity.show.window.standpoints import first_pose
from hradiosity.show.window.subject import Choices, Subject
from hradiosity.show.window.viewer import SIZE, Viewer

FEW_CELLS: Final = 10_000
"""Patches of a scene whose outlines are shown at the start: without light they tell shapes."""
_RESULT_SUFFIX: Final = ".vtkhdf"


@dataclass(frozen=True)
class Request:
    """What the command line asked for; see ``hradiosity view --help``.

    paths : a scene or a result; or two results
    follow : folder of a run to follow
    look, choices : to start with
    view : name of the camera
    size : of the window [pixels]
    pick : place in pixels from the upper left corner
    screenshot, page : files to write in place of a window
    look_chosen : whether what false colours stand for was asked for; else it is that of the result's pictures
    drawn : what is shown in place of what the path names
    """

    paths: tuple[Path, ...]
    follow: Path | None = None
    look: Look = Look()  # noqa: RUF009 - frozen
    choices: Choices = Choices()  # noqa: RUF009 - frozen
    view: str | None = None
    size: tuple[int, int] = SIZE
    pick: tuple[int, int] | None = None
    screenshot: Path | None = None
    page: Path | None = None
    look_chosen: bool = False
    drawn: Drawn | None = None


def view(request: Request) -> None:
    """Open the window, or write the files.

    Raises
    ------
    SceneError
        When what is to be shown can't be, or there is no display.
    OutputError
        When a file can't be written.
    """
    to_files = request.screenshot is not None or request.page is not None
    if not to_files:
        check_display()
    subjects = load_subjects(request)
    camera = _known_view(request, subjects[0].drawn)
    look = _first_look(request, subjects[0])
    if request.page is not None:
        pose = first_pose(subjects[0], camera, request.size)
        write_bytes(request.page, page_bytes(subjects[0], look, pose, request.paths[0].resolve().name))
    if request.screenshot is not None:
        use_off_screen()
    elif to_files:
        return
    viewer = Viewer(subjects, names_of(request.paths), size=request.size, off_screen=to_files, look=look, view=camera)
    if request.pick is not None:
        viewer.click(request.pick[0], request.size[1] - request.pick[1])
    if request.screenshot is not None:
        viewer.write_screenshot(request.screenshot)
    else:
        _run(viewer, request)


def names_of(paths: Sequence[Path]) -> list[str]:
    """Last parts of paths, with as many of those before as tell two of them apart."""
    parts = [path.resolve().parts for path in paths]
    length = next(
        (n for n in range(1, max(map(len, parts))) if len({part[-n:] for part in parts}) == len(set(parts))), 1
    )
    return [Path(*part[-length:]).as_posix() for part in parts]


def _first_look(request: Request, subject: Subject) -> Look:
    """Marks, and outlines of not too many patches, on what is not solved; false colours as in the result's pictures."""
    unsolved = subject.values is None
    look = replace(request.look, marks=unsolved, lines=0 if unsolved and len(subject.cells) <= FEW_CELLS else NO_LINES)
    if request.look_chosen:
        return look
    chosen = subject.drawn.exposure
    quantity: Quantity = "luminance" if chosen.quantity == "luminance" else "illuminance"
    return replace(look, quantity=quantity, logarithmic=chosen.logarithmic)


def _run(viewer: Viewer, request: Request) -> None:
    from hradiosity.show.window.events import Events
    from hradiosity.show.window.following import Follower

    follower = None if request.follow is None else Follower(request.follow)
    viewer.window.SetWindowName(f"hradiosity: {' | '.join(viewer.names)}")
    try:
        Events(viewer, None if follower is None else lambda: follower.update(viewer)).run()
    finally:
        if follower is not None:
            follower.close()
        viewer.window.Finalize()


def load_subjects(request: Request) -> list[Subject]:
    """What the paths name.

    Raises
    ------
    SceneError
        When one of them is neither, or is damaged, or there is one of each.
    """
    drawn = [load_drawn(path) for path in request.paths] if request.drawn is None else [request.drawn]
    _check_pair(request, drawn)
    first = Subject(drawn[0], request.choices)
    return [first, *(Subject(other, request.choices, like=first) for other in drawn[1:])]


def _check_pair(request: Request, drawn: list[Drawn]) -> None:
    """A result and a scene have neither an exposure nor a scale in common."""
    if len({one.light is None for one in drawn}) > 1:
        which = next(path for path, one in zip(request.paths, drawn, strict=True) if one.light is None)
        raise SceneError(
            [Fault(str(which), "", "this is a scene, the other one a result", "two results, or two scenes")]
        )


def load_drawn(path: Path) -> Drawn:
    """A result, or a scene.

    Raises
    ------
    SceneError
        When it is neither, or damaged.
    """
    if path.suffix == _RESULT_SUFFIX or (path.is_dir() and (path / RUN_FILE).exists()):
        return read_result(path)
    from hradiosity.io.scene_drawing import draw_scene
    from hradiosity.io.scene_toml import load_scene

    return draw_scene(load_scene(path))


def running_in(path: Path) -> Path | None:
    """The folder whose run goes on, if `path` is one: ``OUT`` or ``OUT.partial``."""
    path = path if path.name else path.resolve()  # "." has no name
    out = path.with_name(path.name.removesuffix(".partial"))
    run = read_run(partial_of(out))
    return out if run is not None and run.get("state") == RUNNING else None


def _known_view(request: Request, drawn: Drawn) -> str | None:
    names = [view.name for view in drawn.views]
    if request.view is not None and request.view not in names:
        expected = f"one of {', '.join(names)}" if names else "the scene has no cameras"
        raise SceneError([Fault("view", "--camera", f"there is no camera {request.view!r}", expected)])
    return request.view

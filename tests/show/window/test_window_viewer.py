"""Keys and buttons without a display, and ``hradiosity view`` on the command line."""

import shutil
import sys
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from window_room import NEEDS_GL

from hradiosity.cli import main
from hradiosity.cli.watching import light_of
from hradiosity.io.live_light import LiveWriter, is_watched
from hradiosity.io.results_reading import read_result
from hradiosity.io.scene_drawing import draw_scene
from hradiosity.show.window.app import names_of
from hradiosity.show.window.commands import COMMANDS
from hradiosity.show.window.keys import BUTTONS, KEYS, command_of
from hradiosity.show.window.look import MODES, NO_LINES, Look
from hradiosity.show.window.overlays import status_words
from hradiosity.show.window.picking import pick
from hradiosity.show.window.standpoints import camera_pose
from hradiosity.show.window.subject import Choices, Subject

SIZE = (480, 360)


def test_each_key_and_button_has_a_command():
    named = {key.command for key in KEYS if key.command}
    assert named == set(COMMANDS)
    assert {button.command for button in BUTTONS} <= named
    symbols = [symbol for key in KEYS for symbol in key.symbols]
    assert len(symbols) == len(set(symbols))
    assert command_of("5") == "false-color" and command_of("F9") is None


@pytest.fixture(scope="module")
def off_screen():
    """VTK draws with EGL, whatever display there is."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
        yield


@pytest.fixture
def viewer(off_screen, subject):
    from hradiosity.show.window.viewer import Viewer

    return Viewer([subject], ["room"], size=SIZE, off_screen=True)


def inner(viewer):
    """Where no button, legend or word is."""
    return viewer.pixels()[130:-40, : SIZE[0] - 120]


@NEEDS_GL
def test_modes_differ_and_come_back(viewer):
    pictures = {}
    for mode in MODES:
        viewer.command(mode)
        pictures[mode] = inner(viewer)
    for one in MODES:
        for other in MODES:
            assert (one == other) == np.array_equal(pictures[one], pictures[other])
    viewer.command("flat")
    np.testing.assert_array_equal(inner(viewer), pictures["flat"])


@NEEDS_GL
def test_the_window_shows_the_colours_of_the_cells(viewer):
    """Where picking finds a cell, the pixel has its colour."""
    viewer.command("marks")
    picture, colours = viewer.pixels(), viewer.subject.paint(viewer.look).colours
    cells, compared = viewer.subject.cells, 0
    for x in range(60, 360, 29):
        for y in range(140, 310, 19):
            around = picture[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3)
            if np.ptp(around, axis=0).any():
                continue  # an edge between two cells
            found = pick(cells, np.zeros((0, 3)), viewer.pose, (x + 0.5, SIZE[1] - y - 0.5), SIZE, None)
            assert np.abs(picture[y, x].astype(int) - colours[found.number]).max() <= 1
            compared += 1
    assert compared > 50


@NEEDS_GL
def test_each_command_works_and_leaves_the_window_alive(viewer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in COMMANDS:
        viewer.command(name)
    assert not viewer.closed or viewer.picked is None
    assert {path.suffix for path in tmp_path.iterdir()} == {".png", ".html"}
    assert Image.open(next(tmp_path.glob("*.png"))).size == SIZE


@NEEDS_GL
def test_a_click_on_a_button_is_its_key(viewer):
    bar = viewer.overlays.button_at
    found = {bar(x, y).command: (x, y) for x in range(0, SIZE[0], 4) for y in range(0, 130, 4) if bar(x, y)}
    assert set(found) == {button.command for button in BUTTONS}
    x, y = found["unshaded"]
    viewer.click(x, SIZE[1] - y)
    assert viewer.look.mode == "unshaded"
    assert viewer.picked is None


@NEEDS_GL
def test_help_pick_and_window_close_in_turn(viewer):
    viewer.click(240, 180)
    assert viewer.facts() is not None
    viewer.command("help")
    for closed in (False, False, True):
        viewer.command("close")
        assert viewer.closed is closed
    assert viewer.facts() is None


@NEEDS_GL
def test_sections_lines_backs_and_marks_are_seen(viewer):
    viewer.command("overview")
    before = inner(viewer)
    for name in ("section", "coarser lines", "marks", "gamut", "backs"):
        changed = viewer.look
        viewer.command(name)
        assert viewer.look != changed
        if name != "gamut":
            assert not np.array_equal(inner(viewer), before), name
        before = inner(viewer)
    while viewer.look.lines != NO_LINES:
        viewer.command("coarser lines")
    assert viewer.look.lines == NO_LINES


@NEEDS_GL
def test_moves_change_the_picture_and_views_bring_it_back(viewer):
    start = inner(viewer)
    viewer.drag(30, 10, move=False)
    viewer.wheel(2.0)
    viewer.command("walk")
    viewer.command("ahead")
    viewer.drag(5, 5, move=True)
    assert not np.array_equal(inner(viewer), start)
    viewer.command("next view")
    assert viewer.message == "camera corner"
    viewer.command("next view")
    np.testing.assert_array_equal(inner(viewer), start)


@NEEDS_GL
def test_two_results_side_by_side_and_as_a_difference(off_screen, solved, darker):
    from hradiosity.show.window.viewer import Viewer

    first = Subject(read_result(solved[1]), Choices())
    viewer = Viewer([first, Subject(read_result(darker), Choices(), like=first)], "ab", size=SIZE, off_screen=True)
    viewer.command("unshaded")
    picture = viewer.pixels()[130:320]
    assert not np.array_equal(picture[:, : SIZE[0] // 2], picture[:, SIZE[0] // 2 :])
    viewer.click(120, 150)
    left = viewer.facts()
    viewer.click(120 + SIZE[0] // 2, 150)
    assert viewer.facts().lines == left.lines, "the same place in both halves"
    viewer.command("compare")
    assert viewer.shows_difference and viewer.legend.scale.low == -viewer.legend.scale.high
    viewer.command("compare")
    assert viewer.split


@NEEDS_GL
def test_a_scene_is_shown_before_it_is_solved(off_screen, room):
    from hradiosity.show.window.viewer import Viewer

    viewer = Viewer([Subject(draw_scene(room), Choices())], ["room"], size=SIZE, off_screen=True)
    viewer.command("false-color")
    assert viewer.legend.scale.unit == "1"
    viewer.click(240, 180)
    assert viewer.facts().curves[-1].name == "reflectance"


def test_names_of_two_folders_tell_them_apart(tmp_path):
    assert names_of([tmp_path / "a" / "office", tmp_path / "b" / "office"]) == ["a/office", "b/office"]
    assert names_of([tmp_path / "a", tmp_path / "b"]) == ["a", "b"]
    assert names_of([tmp_path / "a", tmp_path / "a"]) == ["a", "a"]
    assert names_of([Path()]) == [Path.cwd().name]


@NEEDS_GL
def test_equal_results_say_so_and_show_the_room(off_screen, solved):
    from hradiosity.show.window.viewer import Viewer

    drawn = read_result(solved[1])
    first = Subject(drawn, Choices())
    same = [first, Subject(drawn, Choices(), like=first)]
    viewer = Viewer(same, ["a", "b"], size=SIZE, off_screen=True, look=Look(compare="difference"))
    assert any("both are equal" in words for words, _ in status_words(viewer))
    assert 0.005 < (inner(viewer).max(axis=2) < 120).mean() < 0.3, "outlines on white"


@NEEDS_GL
@pytest.mark.parametrize("size", [(640, 620), (1280, 800)])
@pytest.mark.parametrize("side", [0.2, 0.8])
def test_what_lies_over_a_difference_covers_nothing_else(off_screen, solved, darker, size, side):
    from hradiosity.show.window.viewer import Viewer

    first = Subject(read_result(solved[1]), Choices())
    pair = [first, Subject(read_result(darker), Choices(), like=first)]
    viewer = Viewer(pair, ["a", "b"], size=size, off_screen=True, look=Look(compare="difference"))
    viewer.click(side * size[0], 0.4 * size[1])
    places = viewer.overlays.places
    assert set(places) == {"buttons", "legend", "facts", "status"}
    for one, other in combinations(places.values(), 2):
        apart = one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]
        assert apart, (places, size)


@NEEDS_GL
def test_outlines_of_a_floor_that_reaches_behind_the_eye_leave_it_its_colour(off_screen, room):
    from hradiosity.show.window.viewer import Viewer

    subject = Subject(draw_scene(room), Choices())
    pictures = []
    for lines in (NO_LINES, 0):
        viewer = Viewer([subject], ["room"], size=SIZE, off_screen=True, look=Look(lines=lines))
        amid = replace(room.views[0], position=np.array([1.5, 1.0, 1.6]), direction=np.array([-0.772, 0.154, -0.617]))
        viewer.pose = camera_pose(viewer.subject, amid, viewer.part_size)
        viewer.redraw()
        pictures.append(inner(viewer).astype(np.int64))
    changed = (np.abs(pictures[0] - pictures[1]) > 8).any(axis=2).mean()
    assert 0.0 < changed < 0.1, "lines, and not faces, are drawn"


@NEEDS_GL
def test_a_run_is_followed_from_its_scene_to_its_result(off_screen, room, solved, tmp_path):
    from hradiosity.show.window.following import Follower
    from hradiosity.show.window.viewer import Viewer

    solution, folder = solved
    viewer = Viewer([Subject(draw_scene(room), Choices())], ["room"], size=SIZE, off_screen=True)
    out, partial = tmp_path / "out", tmp_path / "out.partial"
    follower = Follower(out)
    follower.update(viewer)
    assert viewer.subject.values is None
    partial.mkdir()
    follower.update(viewer)
    assert is_watched(partial), "the window asks for light"
    writer, light = LiveWriter(partial), light_of(solution.surfaces, 1)
    dim = replace(light, irradiance=0.1 * light.irradiance)
    writer.write(solution.scene, solution.elements, dim, "first shots", settled=False)
    follower.update(viewer)
    white = viewer.subject.luminance(viewer.look)
    assert viewer.running == "first shots"
    assert [view.name for view in viewer.subject.drawn.views] == ["door", "corner"]
    assert len(viewer.subject.drawn.sensors) == 8
    viewer.click(240, 180)
    before = viewer.facts()
    writer.write(solution.scene, solution.elements, light, "more shots", settled=False)
    follower.update(viewer)
    assert viewer.subject.luminance(viewer.look) == white, "the exposure stays while light grows"
    assert viewer.facts().title == before.title and viewer.facts().lines != before.lines
    writer.write(solution.scene, solution.elements, light, "1 replicate done", settled=True)
    follower.update(viewer)
    assert viewer.subject.luminance(viewer.look) > 5.0 * white, "and is chosen once more now"
    shutil.rmtree(partial)
    shutil.copytree(folder, out)
    follower.update(viewer)
    assert viewer.running == ""
    assert viewer.subject.drawn.sensors.numbers


@NEEDS_GL
def test_a_run_that_ends_without_a_result_is_told(off_screen, room, tmp_path):
    from hradiosity.show.window.following import Follower
    from hradiosity.show.window.viewer import Viewer

    viewer = Viewer([Subject(draw_scene(room), Choices())], ["room"], size=SIZE, off_screen=True)
    follower = Follower(tmp_path / "out")
    (tmp_path / "out.partial").mkdir()
    follower.update(viewer)
    shutil.rmtree(tmp_path / "out.partial")
    follower.update(viewer)
    assert "without a result" in viewer.running
    follower.close()


@NEEDS_GL
def test_the_command_line_writes_pictures_and_pages(solved, room_file, tmp_path, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    picture, page = tmp_path / "a.png", tmp_path / "a.html"
    size = ("--size", "480", "360")
    assert main(["view", str(solved[1]), *size, "--screenshot", str(picture), "--html", str(page)]) == 0
    assert Image.open(picture).size == SIZE
    assert page.stat().st_size > 20_000
    assert main(["view", str(room_file), *size, "--screenshot", str(picture), "--mode", "unshaded"]) == 0


@pytest.fixture
def refused(capsys, monkeypatch):
    """Runs ``view`` with arguments that are refused; returns what it says in its one line."""
    monkeypatch.delenv("DISPLAY", raising=False)

    def run(*arguments):
        assert main(["view", *map(str, arguments)]) == 2
        said = capsys.readouterr()
        assert said.out == ""
        assert said.err.count("\n") == 1
        assert "Traceback" not in said.err
        return said.err

    return run


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere windows do not depend on a variable")
def test_without_a_display_one_line_says_so(refused, solved, monkeypatch):
    assert "no display" in refused(solved[1])
    monkeypatch.setenv("DISPLAY", ":4242")
    assert "does not answer" in refused(solved[1])


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere windows do not depend on a variable")
def test_a_run_with_a_window_does_not_start_without_a_display(room_file, tmp_path, monkeypatch, capsys):
    monkeypatch.delenv("DISPLAY", raising=False)
    assert main(["render", str(room_file), "-o", str(tmp_path / "out"), "--view"]) == 2
    said = capsys.readouterr().err
    assert "no display" in said and "leave out --view" in said
    assert not list(tmp_path.iterdir())


def test_what_can_t_be_shown_is_told(refused, solved, room_file, tmp_path):
    shot = ("--screenshot", tmp_path / "a.png")
    assert "no such file" in refused(tmp_path / "nothing", *shot)
    (tmp_path / "empty").mkdir()
    assert "scene.toml" in refused(tmp_path / "empty", *shot)
    (tmp_path / "a.vtkhdf").write_text("no", encoding="utf-8")
    assert "damaged" in refused(tmp_path / "a.vtkhdf", *shot)
    assert "there is one result" in refused(solved[1], "--difference", *shot)
    assert "one, which the page" in refused(solved[1], solved[1], "--html", tmp_path / "a.html")
    for extra in ((), ("--difference",)):
        assert "this is a scene, the other one a result" in refused(solved[1], room_file, *extra, *shot)
    assert "two results" in refused(room_file, room_file, "--difference", *shot)
    assert "door, corner" in refused(solved[1], "--camera", "window", *shot)
    assert "no range" in refused(solved[1], "--false-color-range", 5, 1, *shot)
    assert "above 0" in refused(solved[1], "--exposure", -1, *shot)
    assert "pixels" in refused(solved[1], "--size", 1, 1, *shot)
    assert "ends in .png" in refused(solved[1], "--screenshot", tmp_path / "a.gif")
    assert "ends in .html" in refused(solved[1], "--html", tmp_path / "a.pdf")
    assert "in the window" in refused(solved[1], "--pick", 1280, 0, *shot)
    assert "given for a file" in refused(solved[1], "--follow", tmp_path / "out", *shot)


@NEEDS_GL
def test_the_folder_that_one_stands_in_is_shown(solved, tmp_path, monkeypatch):
    monkeypatch.chdir(solved[1])
    assert main(["view", ".", "--size", "480", "360", "--screenshot", str(tmp_path / "a.png")]) == 0
    assert Image.open(tmp_path / "a.png").text["Title"] == solved[1].name


@NEEDS_GL
def test_a_place_that_can_t_be_written_is_told(refused, solved, tmp_path):
    assert "can't be written" in refused(solved[1], "--screenshot", tmp_path / "none" / "a.png", "--size", 480, 360)

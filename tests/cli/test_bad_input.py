"""Mistakes of the user: exit status 2, file and entry named, all at once, no traceback."""

import os
from pathlib import Path

import pytest
from cli_room import QUICK, ROOM

from hradiosity.cli import closing
from hradiosity.errors import OutputError
from hradiosity.io.output_lock import locked

POINT = '[[sensor]]\nname = "s"\nkind = "points"\npositions = [[1, 1, 1]]\n'
MESH = '[[mesh]]\nname = "thing"\nfile = "thing.obj"\nunit = "m"\nup = "z"\nmaterials = { "grey" = "wall" }\n'
TRIANGLE = "v 0 0 1\nv 1 0 1\nv 0 1 1\nusemtl blue\nf 1 2 3\n"
LAMP = ROOM[ROOM.index('[[rectangle]]\nname = "lamp"') : ROOM.index("[[sensor]]")]
WHITE = ROOM.replace("{ steps = [[380, 560, 0.3], [560, 740, 0.6]] }", "1.0").replace("0.2\n", "1\n")
FROM_FILE = ROOM.replace("0.2\n", '{ file = "p.csv" }\n')
FLAT = ROOM.replace("edge_v = [1.0, 0.0, 0.0]", "edge_v = [0.0, 2.0, 0.0]")

FAULTS = [
    ("syntax", ROOM + "[scene\n", {}, ("scene.toml", "line")),
    ("unknown key", ROOM.replace("luminous_flux_lm", "luminous_flux"), {}, ("luminaires.lamp", "did you mean")),
    ("wrong unit", ROOM.replace('unit = "m"', 'unit = "metre"'), {}, ("scene.unit", "known: cm")),
    ("reflectance above 1", ROOM.replace("0.2\n", "80\n"), {}, ("materials.floor", "percent")),
    ("negative reflectance", ROOM.replace("0.2\n", "-0.2\n"), {}, ("materials.floor", "0 to 1")),
    ("not a number", FROM_FILE, {"p.csv": "380,0.1\n500,nan\n"}, ("p.csv", "nan")),
    ("empty spectrum", FROM_FILE, {"p.csv": ""}, ("p.csv", "empty")),
    ("unsorted", FROM_FILE, {"p.csv": "500,0.1\n400,0.2\n"}, ("p.csv", "400 after 500")),
    ("mesh missing", ROOM + MESH, {}, ("mesh[0].file", "thing.obj")),
    ("mesh empty", ROOM + MESH, {"thing.obj": ""}, ("thing.obj",)),
    ("mesh garbage", ROOM + MESH, {"thing.obj": "\x00\x01\x7f garbage" * 50}, ("thing.obj",)),
    ("mesh without the material", ROOM + MESH, {"thing.obj": TRIANGLE}, ("blue", "mesh[0]")),
    ("face without area", FLAT, {}, ("rectangle[0]", "area")),
    ("no emitter", ROOM.replace(LAMP, ""), {}, ("nothing gives light",)),
    ("zero normal", ROOM + POINT + "normal = [0, 0, 0]\n", {}, ("sensor[2].normal", "no direction")),
    ("grid of 0 points", ROOM.replace("counts = [3, 2]", "counts = [0, 2]"), {}, ("sensor[0].counts", "1")),
    ("closed white room", WHITE, {}, ("materials", "without end")),
    ("effect that is not built", ROOM + "[sun]\nelevation = 30\n", {}, ("the sun", "not simulated")),
]


@pytest.mark.parametrize(("text", "files", "parts"), [case[1:] for case in FAULTS], ids=[case[0] for case in FAULTS])
def test_faults_in_the_scene(tmp_path, call, text, files, parts):
    (tmp_path / "scene.toml").write_text(text)
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    for verb in (("render", tmp_path, "-o", tmp_path / "out"), ("plan", tmp_path)):
        outcome = call(*verb)
        assert outcome.code == 2
        assert outcome.out == ""
        assert "Traceback" not in outcome.err
        for part in (str(tmp_path), *parts):
            assert part in outcome.err
    assert not (tmp_path / "out").exists()
    assert not (tmp_path / "out.partial").exists()


def test_no_such_scene(tmp_path, call):
    outcome = call("render", tmp_path / "nowhere")
    assert outcome.code == 2
    assert "no such file" in outcome.err


def test_all_faults_are_counted(tmp_path, call):
    (tmp_path / "scene.toml").write_text(ROOM.replace("0.2\n", "80\n").replace("[3, 2]", "[0, 2]"))
    outcome = call("render", tmp_path)
    assert outcome.err.startswith("2 faults:\n")
    assert len(outcome.err.splitlines()) == 3


def test_debug_shows_where_it_was_noticed(tmp_path, call):
    from hradiosity.errors import SceneError

    with pytest.raises(SceneError):
        call("render", tmp_path / "nowhere", "--debug")


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (("--accuracy", "5"), "5%"),
        (("--accuracy", "0%"), "between 0 and 100"),
        (("--accuracy", "good"), "like 1%"),
        (("--time", "2 weeks"), "like 30s"),
        (("--time", "0s"), "longer than 0"),
        (("--replicates", "1"), "replicates must be at least 2"),
        (("--rays-per-element", "3"), "rays-per-element must be at least 16"),
        (("--element-size", "-1"), "element-size must be > 0"),
        (("--element-size", "inf"), "element-size must be > 0"),
        (("--element-size", "1e-6"), "elements at most"),
        (("--seed", "-1"), "seed must lie between 0"),
        (("--seed", str(2**32)), "seed must lie between 0"),
        (("--referee", "0"), "referee must be at least 1"),
        (("--lookup", "7"), "lookup must be"),
        (("--replicates", "90", "--gather-samples", "60"), "gather-samples must be at least the 90 replicates"),
        (("--occlusion", "maybe"), "on"),
        (("--form-factors", "spheres"), "quasi-hemisphere"),
        (("--form-factors", "contour", "--mode", "classic"), "form-factors must be hemicube in the classic mode"),
        (("--form-factors", "contour", "--links", "hierarchical"), "links must be rows"),
        (("--form-factors", "contour", "--element-size", "0.05"), "--elements"),
        (("--device", "abacus"), "no OpenCL device fits 'abacus'"),
        (("--acuracy", "1%"), "--accuracy"),
    ],
)
def test_arguments(room, call, tmp_path, arguments, part):
    outcome = call("render", room, "-o", tmp_path / "out", *arguments)
    assert outcome.code == 2
    shown = outcome.out + outcome.err
    assert part in " ".join(shown.replace("│", " ").split())
    assert "Traceback" not in shown
    assert not (tmp_path / "out.partial").exists()


def test_out_below_a_file(room, call, tmp_path):
    (tmp_path / "file").write_text("mine")
    outcome = call("render", room, "-o", tmp_path / "file" / "out", *QUICK)
    assert outcome.code == 2
    assert "file" in outcome.err
    assert outcome.out == ""
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a folder that nobody can write to")
def test_out_that_nobody_can_write(room, call):
    outcome = call("render", room, "-o", "/proc/out", *QUICK)
    assert outcome.code == 2
    assert "can't be made" in outcome.err
    assert outcome.out == ""


def test_out_with_other_things_in_it(room, call, tmp_path):
    out = tmp_path / "documents"
    out.mkdir()
    (out / "thesis.txt").write_text("years")
    outcome = call("render", room, "-o", out, *QUICK)
    assert outcome.code == 2
    assert "is left as it is" in outcome.err
    assert (out / "thesis.txt").read_text() == "years"


def test_nothing_to_resume(room, call, tmp_path):
    outcome = call("render", room, "-o", tmp_path / "out", "--resume", *QUICK)
    assert outcome.code == 2
    assert "nothing to resume" in outcome.err
    assert not (tmp_path / "out.partial").exists()


def test_full_disk(room, call, small_disk):
    """The earlier result stays as it is, and nothing else is left."""
    out = small_disk / "out"
    out.mkdir()
    (out / "run.json").write_text('{"program": "hradiosity", "state": "complete"}')
    (out / "readings.csv").write_text("earlier")
    outcome = call("render", room, "-o", out, *QUICK)
    assert outcome.code == 2
    assert "no space left" in outcome.err
    assert "Traceback" not in outcome.err
    assert "nor is there room" in outcome.err
    assert (out / "readings.csv").read_text() == "earlier"
    assert [path.name for path in small_disk.iterdir()] == ["out"]


def test_disk_with_room_for_a_checkpoint_only(room, call, tmp_path, monkeypatch):
    """What was computed is written by the next run, without computing it again."""

    def full(*arguments, **keywords):
        raise OutputError("solution.vtkhdf can't be written: no space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(closing, "write_results", full)
        outcome = call("render", room, "-o", tmp_path / "out", *QUICK)
    assert outcome.code == 2
    assert "make room" in outcome.err
    assert "--resume" in outcome.err
    again = call("render", room, "-o", tmp_path / "out", "--resume", *QUICK)
    assert again.code == 0
    assert "going on from replicate 8" in again.out
    assert not (tmp_path / "out.partial").exists()


def test_a_second_run_into_one_folder_is_refused(room, call, tmp_path):
    with locked(tmp_path / "out"):
        outcome = call("render", room, "-o", tmp_path / "out", *QUICK)
    assert outcome.code == 2
    assert f"another run (process {os.getpid()} on " in outcome.err and "wait until it has ended" in outcome.err
    assert call("render", room, "-o", tmp_path / "out", *QUICK).code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "room"]

"""A solved room, once for all tests of the window."""

from dataclasses import replace

import pytest
from window_room import QUICK, ROOM

from hradiosity.io.results import write_results
from hradiosity.io.results_reading import read_result
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.variants import make_variant
from hradiosity.radiosity import make_solver
from hradiosity.show.window.subject import Choices, Subject


@pytest.fixture(scope="session")
def room_file(tmp_path_factory):
    file = tmp_path_factory.mktemp("window") / "room.toml"
    file.write_text(ROOM, encoding="utf-8")
    return file


@pytest.fixture(scope="session")
def room(room_file):
    return load_scene(room_file)


def write_solved(folder, scene, device, options=QUICK):
    solver = make_solver(scene, options, device)
    for _ in solver.states():
        pass
    solution = solver.solution()
    folder.mkdir()
    write_results(folder, solution, {}, "digest")
    (folder / "run.json").write_text('{"program": "hradiosity", "state": "complete"}', encoding="utf-8")
    return solution


@pytest.fixture(scope="session")
def solved(tmp_path_factory, room, device):
    """The solution, and the folder with its results."""
    folder = tmp_path_factory.mktemp("solved") / "room"
    return write_solved(folder, room, device), folder


@pytest.fixture(scope="session")
def darker(tmp_path_factory, room, device):
    """The folder of the same room with a darker floor."""
    folder = tmp_path_factory.mktemp("solved") / "darker"
    variant = make_variant(room, "darker", materials={"wall": 0.1})
    write_solved(folder, replace(room, materials=variant.materials), device)
    return folder


@pytest.fixture(scope="session")
def finer(tmp_path_factory, room, device):
    """The folder of the same room with smaller elements."""
    folder = tmp_path_factory.mktemp("solved") / "finer"
    write_solved(folder, room, device, replace(QUICK, element_size=0.25))
    return folder


@pytest.fixture(scope="session")
def subject(solved):
    return Subject(read_result(solved[1]), Choices())

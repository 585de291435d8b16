"""``hradiosity render --map`` from end to end."""

import json

import numpy as np
import pytest
from cli_room import QUICK


@pytest.fixture
def render(room, call, tmp_path):
    def run(*words):
        return call("render", room, "-o", tmp_path / "out", "--no-audit", *QUICK, *words)

    return run


def test_maps_of_named_objects(render, tmp_path):
    outcome = render("--map", "room", "--map", "room:up", "--map-error", "3%")
    assert outcome.code == 0, outcome.err
    folder = tmp_path / "out" / "maps"
    kinds = ("png", "csv", "npz")
    assert {path.name for path in folder.iterdir()} == {f"{n}.{kind}" for n in ("room", "room_up") for kind in kinds}
    told = json.loads((tmp_path / "out" / "run.json").read_text())["maps"]
    floor = told["room:up"]
    table = np.genfromtxt(folder / "room_up.csv", delimiter=",", names=True)
    assert len(table) == floor["cells"] and floor["error_asked_for"] == 0.03
    assert (table["normal_z"] == 1.0).all() and np.abs(table["z_m"]).max() < 1e-3
    mean = np.average(table["illuminance_lx"], weights=table["area_m2"])
    assert mean == pytest.approx(floor["mean_lx"], rel=1e-3) and mean > 0.0
    assert (table["lowest_lx"] <= table["illuminance_lx"] + 1e-3).all() and (table["half_width_lx"] > 0.0).all()
    whole = np.genfromtxt(folder / "room.csv", delimiter=",", names=True)
    assert whole["area_m2"].sum() > 4 * table["area_m2"].sum()
    arrays = np.load(folder / "room_up.npz")
    assert arrays["corners"].shape == (len(table), 4, 3) and arrays["corner_lux"].shape == (len(table), 4)
    assert "map of room:up: cut and read until the rms error is 3 %" in outcome.out
    assert "Illuminance maps" in outcome.out


def test_objects_that_are_not_there(render):
    outcome = render("--map", "room", "--map", "tabel", "--map", "room:north")
    assert outcome.code == 2
    assert "no object 'tabel', 'room:north'" in outcome.err and "'room'" in outcome.err and ":up" in outcome.err


@pytest.mark.parametrize("error", ["0", "150%", "2 lx"])
def test_errors_that_are_none(render, error):
    outcome = render("--map", "room", "--map-error", error)
    assert outcome.code == 2 and "map-error" in outcome.err


def test_a_result_that_is_only_taken_up_keeps_no_light_to_map(render, tmp_path):
    assert render().code == 0
    outcome = render("--map", "room", "--resume")
    assert outcome.code == 0
    assert "no map of 'room': a map needs light computed in this run" in outcome.out
    assert "none" in json.loads((tmp_path / "out" / "run.json").read_text())["maps"]["room"]

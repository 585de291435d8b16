"""Findings about sensors, cameras and lamps; each with a scene that has it and one without."""

import numpy as np
import pytest
from check_rooms import HEADER, LAMP, ROOM, SOUND, box, camera, findings, grave, of_kind, points, rectangle

from hradiosity.errors import SceneError
from hradiosity.io.scene_toml import load_scene
from hradiosity.space.check import raise_faults

TABLE = box("table top", (1, 1, 0.70), (1, 1, 0.03))
CABINET = box("cabinet", (2.5, 0, 0), (1, 1, 1.5))


@pytest.mark.parametrize(
    ("positions", "severity", "count"),
    [([(3, 0.5, 1)], "fault", "sensor 'eye' is"), ([(3, 0.5, 1), (1, 2, 1)], "warning", "1 of 2 readings of")],
)
def test_readings_inside_a_solid(device, tmp_path, positions, severity, count):
    (finding,) = of_kind(findings(device, tmp_path, SOUND + CABINET + points("eye", positions)), "sensor-in-solid")
    assert finding.severity == severity
    assert finding.message.startswith(count)
    assert "only the inside of 'cabinet'" in finding.message
    np.testing.assert_allclose(finding.place, positions[0])


@pytest.mark.parametrize(
    ("position", "normal", "words"),
    [
        ((1.5, 1.5, 0.6995), (0, 0, 1), "0.5 mm under 'table top'"),
        ((1.5, 1.5, 0.7305), (0, 0, -1), "0.5 mm above 'table top'"),
        ((0.0005, 2, 1), (-1, 0, 0), "0.5 mm in front of 'room'"),
    ],
)
def test_readings_that_a_surface_covers(device, tmp_path, position, normal, words):
    found = findings(device, tmp_path, SOUND + TABLE + points("eye", [position], normal))
    (finding,) = of_kind(found, "sensor-covered")
    assert words in finding.message


@pytest.mark.parametrize(
    ("position", "normal"),
    [
        ((1.5, 1.5, 0.73), (0, 0, 1)),
        ((1.5, 1.5, 0.7), (0, 0, -1)),
        ((0, 2, 1), (1, 0, 0)),
        ((1.5, 1.5, 0.6), (0, 0, 1)),
    ],
)
def test_readings_on_surfaces_and_well_below_them_are_fine(device, tmp_path, position, normal):
    assert grave(findings(device, tmp_path, SOUND + TABLE + points("eye", [position], normal))) == []


@pytest.mark.parametrize(
    ("position", "normal", "cuts"),
    [
        ((2, 0, 0), (0, 0, 1), ["room"]),
        ((0, 0, 0), (0, 0, 1), ["room"]),
        ((2, 0, 0), (0, 0.6, 0.8), ["room"]),
        ((1.5, 1.0, 0.715), (0, -1, 0), []),
        ((2, 1e-4, 0), (0, 0, 1), []),
        ((2, 2, 0), (0, 0, 1), []),
    ],
    ids=("edge", "corner", "tilted", "side of a table", "beside the edge", "floor"),
)
def test_readings_in_edges(device, tmp_path, position, normal, cuts):
    found = findings(device, tmp_path, SOUND + TABLE + points("eye", [position], normal))
    cutting = of_kind(found, "sensor-in-edge")
    assert [finding.message.split("'")[3] for finding in cutting] == cuts
    assert all("reads a part of the light only" in finding.effect for finding in cutting)


def test_readings_turned_round_outside_and_in_the_dark(device, tmp_path):
    turned = findings(device, tmp_path, SOUND + points("eye", [(0, 2, 1)], (-1, 0, 0)))
    assert grave(turned) == ["sensor-turned-round"]
    outside = findings(device, tmp_path, SOUND + points("eye", [(9, 2, 1)], (0, 1, 0)))
    assert grave(outside) == ["sensor-outside"]
    sealed = box("dark room", (6, 0, 0), (2, 2, 2), "inside = true")
    dark = findings(device, tmp_path, SOUND + sealed + points("eye", [(7, 1, 1)]))
    assert grave(dark) == []
    assert len(of_kind(dark, "sensor-dark")) == 1


def test_a_reading_that_sees_a_small_lamp_only_is_not_in_the_dark(device, tmp_path):
    lamp = rectangle("lamp", (0, 0, 3), (0, 0.01, 0), (0.01, 0, 0), luminaire="lamp")
    assert grave(findings(device, tmp_path, HEADER + lamp + points("eye", [(1, 1, 0)]))) == []
    assert grave(findings(device, tmp_path, HEADER + lamp + points("eye", [(1, 1, 0)], (0, 0, -1)))) == [
        "sensor-outside"
    ]


@pytest.mark.parametrize(
    ("position", "target", "expected"),
    [
        ((3, 0.5, 1), (1, 1, 1), ["camera-in-solid"]),
        ((-0.1, 1, 1), (2, 1, 1), ["camera-in-wall"]),
        ((9, 1, 1), (2, 1, 1), ["camera-dark"]),
        ((0.1, 0.1, 1), (2, 1, 1), []),
    ],
)
def test_cameras(device, tmp_path, position, target, expected):
    outer = box("outer wall", (-0.2, -0.2, -0.2), (4.4, 3.4, 2.9), "inside = true")
    scene = SOUND + CABINET + outer + camera("eye", position, target)
    assert grave(findings(device, tmp_path, scene)) == expected


def test_lamps_inside_solids(device, tmp_path):
    lamp = rectangle("panel", (2.8, 0.3, 1), (0, 0.3, 0), (0.3, 0, 0), luminaire="lamp")
    (finding,) = of_kind(findings(device, tmp_path, ROOM + CABINET + lamp), "lamp-in-solid")
    assert (finding.severity, finding.object) == ("fault", "panel")
    assert "'cabinet'" in finding.message
    point = '[[point_source]]\nposition = [{}, 0.5, 1]\nluminaire = "lamp"\n'
    assert grave(findings(device, tmp_path, ROOM + CABINET + point.format(3))) == ["lamp-in-solid"]
    assert grave(findings(device, tmp_path, ROOM + CABINET + point.format(2))) == []


@pytest.mark.parametrize(("gap", "expected"), [(0.0, ["lamp-covered"]), (5e-4, ["lamp-covered"]), (0.05, [])])
def test_lamps_that_shine_into_a_surface(device, tmp_path, gap, expected):
    """The top of a shining box right under the ceiling: it has 2 of 3 of the shining area."""
    glowing = box("tray", (1, 1, 2.4 - gap), (0.5, 0.5, 0.1), 'luminaires = { top = "lamp", left = "lamp" }')
    found = findings(device, tmp_path, ROOM + glowing)
    assert grave(found) == expected
    assert all("83.3 %" in f.message and "'room'" in f.message for f in of_kind(found, "lamp-covered"))


def test_lamps_with_their_back_to_the_room(device, tmp_path):
    floor = rectangle("floor", (0, 0, 0), (4, 0, 0), (0, 4, 0))
    up = rectangle("panel", (1, 1, 2), (1, 0, 0), (0, 1, 0), luminaire="lamp")
    down = rectangle("panel", (1, 1, 2), (0, 1, 0), (1, 0, 0), luminaire="lamp")
    assert grave(findings(device, tmp_path, HEADER + floor + up)) == ["lamp-turned-away"]
    assert grave(findings(device, tmp_path, HEADER + floor + down)) == []


def test_faults_are_raised_all_at_once(device, tmp_path):
    text = SOUND + CABINET + points("eye", [(3, 0.5, 1)]) + camera("eye", (3, 0.5, 1), (1, 1, 1))
    found = findings(device, tmp_path, text)
    with pytest.raises(SceneError) as error:
        raise_faults(found, load_scene(tmp_path / "scene.toml"))
    assert len(error.value.faults) == 2
    raise_faults(findings(device, tmp_path, ROOM + LAMP), load_scene(tmp_path / "scene.toml"))

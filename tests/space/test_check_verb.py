"""``hradiosity check``: words, JSON, exit status."""

import json

from check_rooms import SOUND, box, camera, points

from hradiosity.cli import main


def scene(folder, text):
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    return str(folder)


def test_a_sound_scene(tmp_path, capsys):
    assert main(["check", scene(tmp_path, SOUND)]) == 0
    assert "no fault, no warning" in capsys.readouterr().out


def test_findings_are_printed_with_their_fix_and_a_fault_is_status_2(tmp_path, capsys):
    bad = SOUND + box("cabinet", (2.5, 0, 0), (1, 1, 1.5)) + camera("front", (3, 0.5, 1), (0, 0, 1))
    assert main(["check", scene(tmp_path, bad)]) == 2
    out = capsys.readouterr().out
    assert "camera-in-solid: camera 'front' at (3, 0.5, 1) m is inside 'cabinet'" in out
    assert "→ move it out of 'cabinet'" in out
    assert "no fault, no warning" not in out


def test_json_holds_place_and_severity(tmp_path, capsys):
    bad = SOUND + points("eye", [(0, 2, 1)], (-1, 0, 0))
    assert main(["check", scene(tmp_path, bad), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["findings"]
    assert found[0]["kind"] == "sensor-turned-round"
    assert found[0]["place"] == [0.0, 2.0, 1.0]
    assert found[0]["severity"] == "warning"
    lamp = next(f for f in found if f["kind"] == "lamp-cut-off")
    assert lamp["place"] is None


def test_json_of_an_unreadable_scene_lists_its_faults(tmp_path, capsys):
    assert main(["check", scene(tmp_path, SOUND.replace("reflectance = 0.3", "reflectance = 80")), "--json"]) == 2
    faults = json.loads(capsys.readouterr().out)["faults"]
    assert len(faults) == 1
    assert "percent" in faults[0]["found"] + faults[0]["expected"]

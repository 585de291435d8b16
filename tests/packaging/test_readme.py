"""What README tells a newcomer is so."""

import re

import pytest
from fresh_environment import OWN_SUITE

from hradiosity.cli.app import make_app
from hradiosity.io.results_tables import LIGHT_COLUMNS, PLACE_COLUMNS
from hradiosity.io.scene_toml import load_scene

README = (OWN_SUITE / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


def test_the_scene_can_be_loaded(tmp_path):
    text, sensors, variants = blocks("toml")
    (tmp_path / "spectra").mkdir()
    (tmp_path / "spectra" / "wall.csv").write_text("380,0.5\n780,0.7\n")
    (tmp_path / "scene.toml").write_text(text + sensors + variants)
    scene = load_scene(tmp_path)
    assert [sensor.n_readings for sensor in scene.sensors] == [35, 7 * 5, 2, 1, 1, 2, 1]
    assert len(scene.views) == 1
    assert [variant.name for variant in scene.variants] == ["dark walls", "tubes"]
    lamp = scene.emitters.patch[0]
    assert scene.patches.normal[lamp][2] == pytest.approx(-1.0)


def test_programs_are_python():
    for text in blocks("python"):
        compile(text, "README.md", "exec")


def test_form_factors_of_the_readme(capsys):
    """The last line prints what its remark says."""
    (text,) = [block for block in blocks("python") if "form_factor" in block]
    exec(compile(f"import hradiosity\n{text}", "README.md", "exec"))
    assert float(capsys.readouterr().out.splitlines()[-1]) == pytest.approx(0.1945, abs=2e-4)


def test_both_commands_are_single_lines_and_ci_finds_the_second():
    commands = [line for line in README.splitlines() if line.startswith("python3.11 -m venv")]
    assert len(commands) == 2
    assert "hradiosity render scenes/office" in commands[0]
    assert commands[1].endswith("pytest -n 2")
    marked = README.split("<!-- set up and test -->")[1]
    assert re.search(r"^python.*", marked, flags=re.MULTILINE)[0] == commands[1]


def test_verbs_exist():
    verbs = set(re.findall(r"`(?:\S*/)?hradiosity (\w+)", README))
    assert verbs >= {"render", "plan", "check", "devices", "new", "schema"}
    for verb in verbs:
        assert verb in make_app()


def test_chapters_exist():
    titles = re.findall(r"^##+ (.*)$", README, flags=re.MULTILINE)
    anchors = {re.sub(r"[^a-z0-9 -]", "", title.casefold()).replace(" ", "-") for title in titles}
    linked = re.findall(r"\]\(#([^)]+)\)", README)
    assert linked
    assert set(linked) <= anchors


def test_files_exist():
    for name in re.findall(r"\]\(([^#)]+)\)", README):
        assert (OWN_SUITE / name).is_file(), name
    for name in re.findall(r"\b(?:scenes|examples)/\w+(?:\.py)?", README):
        if name != "scenes/open_plan":
            assert list(OWN_SUITE.glob(f"{name}*")), name


def test_columns_are_those_that_are_written():
    (row,) = [line for line in README.splitlines() if line.startswith("| `readings.csv`")]
    for column in (*PLACE_COLUMNS, *LIGHT_COLUMNS[:2]):
        assert column in row

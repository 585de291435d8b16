"""The picture of a check: what is found can be seen in it, where it is."""

import numpy as np
import pytest
from check_rooms import SOUND, box, points, rectangle
from PIL import Image

from hradiosity.cli import main
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.geometry import NONE
from hradiosity.show.camera import project
from hradiosity.show.findings_view import Stage, close_view, draw, is_in_sight, overview
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.check import check_scene
from hradiosity.space.lit_sides import find_lit_sides

RED = (0.8, 0.0, 0.0)
RUG = rectangle("rug", (1, 1, 0), (1, 0, 0), (0, 1, 0), material="other")


@pytest.fixture
def stage_of(device, tmp_path):
    def make(text):
        (tmp_path / "scene.toml").write_text(text)
        scene = load_scene(tmp_path)
        bvh = build_bvh(device, scene.patches)
        lit = find_lit_sides(scene, bvh)
        return Stage(scene, bvh, lit.lit), check_scene(scene, bvh, lit)

    return make


def is_red(pixels):
    return pixels[..., 0] > 2.0 * pixels[..., 1].astype(float)


def test_a_rug_in_the_floor_is_coloured_all_over_and_nothing_else(stage_of):
    """Rays meet rug or floor by chance; the picture shows the rug, in the area that its corners span."""
    stage, findings = stage_of(SOUND + RUG)
    (finding,) = [f for f in findings if f.kind == "coincident-surfaces"]
    assert [stage.scene.objects[stage.scene.patches.object[p]] for p in finding.patches] == ["rug"]
    view = close_view(stage, finding.patches, finding.place, finding.size, 320, 240)
    assert is_in_sight(stage, view, finding.place, finding.patches)
    red = is_red(draw(stage, view, finding.patches, RED))
    (corners,) = stage.scene.patches.corners()[list(finding.patches)]
    x, y = project(view, corners).T
    area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    assert red.sum() == pytest.approx(area, rel=0.03)
    assert red.mean() > 0.03


@pytest.mark.parametrize("inside", [True, False])
def test_a_room_is_looked_into_whatever_its_walls_are_like(stage_of, inside):
    """A thin shell that faces inwards, and walls with a thickness: the lamp can be seen from outside."""
    text = SOUND
    if not inside:
        walls = ((-0.2, -0.2, -0.2), (4.4, 3.4, 0.2)), ((-0.2, -0.2, 2.5), (4.4, 3.4, 0.2))
        walls += ((-0.2, -0.2, 0), (4.4, 0.2, 2.5)), ((-0.2, 3, 0), (4.4, 0.2, 2.5))
        walls += ((-0.2, 0, 0), (0.2, 3, 2.5)), ((4, 0, 0), (0.2, 3, 2.5))
        room = SOUND[SOUND.index("[[box]]") : SOUND.index("[[rectangle]]")]
        text = SOUND.replace(room, "".join(box(f"wall {k}", *wall) for k, wall in enumerate(walls)))
    stage, _ = stage_of(text)
    view = overview(stage, 320, 240)
    (lamp,) = stage.scene.emitters.patch[stage.scene.emitters.patch != NONE]
    assert is_red(draw(stage, view, [int(lamp)], RED)).sum() > 100
    low, high = stage.scene.patches.bounds()
    seen = project(view, np.array([low, high, [low[0], high[1], low[2]], [high[0], low[1], low[2]]]))
    assert (seen > 0).all() and (seen < [320, 240]).all()


def test_what_is_inside_a_solid_is_said_to_be_hidden(stage_of):
    stage, findings = stage_of(SOUND + box("block", (1, 1, 0.3), (1, 1, 1)) + points("eye", [(1.5, 1.5, 0.8)]))
    (finding,) = [f for f in findings if f.kind == "sensor-in-solid"]
    view = close_view(stage, finding.patches, finding.place, finding.size, 320, 240)
    assert not is_in_sight(stage, view, finding.place, finding.patches)


def test_the_verb_writes_a_sheet_with_a_close_up_of_each_finding(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(SOUND + RUG + box("block", (2, 2, 0.5), (0.5, 0.5, 0.5), "inside = true"))
    assert main(["check", str(tmp_path), "--picture", str(tmp_path / "a.png")]) == 0
    image = np.asarray(Image.open(tmp_path / "a.png"))
    assert image.shape[1] == 1500 and image.shape[0] > 1000
    orange = (image[..., 0] > 150) & (image[..., 2] < 60)
    assert orange[700:, :500].mean() > 0.02 and orange[700:, 500:1000].mean() > 0.02
    assert not orange[700:, 1010:].any()
    assert "inside-out" in capsys.readouterr().out


def test_a_place_that_cannot_be_written_is_said(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(SOUND)
    assert main(["check", str(tmp_path), "--picture", str(tmp_path / "no" / "a.png")]) == 2
    assert "a.png can't be written" in capsys.readouterr().err

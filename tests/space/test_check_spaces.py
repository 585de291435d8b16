"""Findings about spaces and spectra, and that the scenes which come with the program have no fault."""

from pathlib import Path

import numpy as np
import pytest
from check_rooms import HEADER, LAMP, ROOM, SOUND, box, findings, grave, of_kind, points, rectangle

from hradiosity.io.scene_toml import load_scene
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.check import check_scene
from hradiosity.space.check.finding import MOST_OF_A_KIND

SCENES = Path(__file__).parents[2] / "scenes"
FIVE_WALLS = HEADER + box("room", (0, 0, 0), (4, 3, 2.5), 'inside = true\nomit = ["left"]') + LAMP


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(path.parent.name, marks=pytest.mark.slow if path.stat().st_size > 500_000 else ())
        for path in sorted(SCENES.glob("*/scene.toml"))
    ],
)
def test_shipped_scenes_have_no_fault(device, name):
    scene = load_scene(SCENES / name)
    found = check_scene(scene, build_bvh(device, scene.patches))
    assert [str(finding) for finding in found if finding.severity == "fault"] == []
    assert of_kind(found, "space")


def test_spaces_are_listed_with_what_is_in_them(device, tmp_path):
    second = box("annexe", (6, 0, 0), (2, 2, 2), "inside = true")
    second += rectangle("annexe lamp", (6.5, 0.5, 1.9), (0, 1, 0), (1, 0, 0), luminaire="lamp")
    found = of_kind(findings(device, tmp_path, SOUND + second + points("desk", [(1, 1, 1), (1, 2, 1)])), "space")
    assert len(found) == 2
    main = next(finding for finding in found if finding.object == "room")
    assert "closed space" in main.message
    assert "1 lamp, 2 readings" in main.message
    other = next(finding for finding in found if finding.object == "annexe")
    assert "1 lamp, 0 readings" in other.message
    assert "nothing looks at it" in other.effect


@pytest.mark.parametrize(("gap", "leaks"), [(0.0, False), (0.02, True), (1.0, False)])
def test_a_crack_is_found_where_it_is(device, tmp_path, gap, leaks):
    wall = rectangle("left wall", (0, 0, 0), (0, 3 - gap, 0), (0, 0, 2.5))
    found = findings(device, tmp_path, FIVE_WALLS + wall)
    cracks = of_kind(found, "leak")
    assert len(cracks) == int(leaks)
    if leaks:
        assert abs(cracks[0].place[0]) < 0.01
        assert 3 - 2 * gap < cracks[0].place[1] < 3 + 1e-3
    assert ("open space" in of_kind(found, "space")[0].message) == (gap > 0.1)


def test_a_floor_that_goes_on_beyond_the_walls_is_no_leak(device, tmp_path):
    room = HEADER + box("room", (0, 0, 0), (4, 3, 2.5), 'inside = true\nomit = ["bottom"]') + LAMP
    slab = rectangle("slab", (-0.02, -0.02, 0), (4.04, 0, 0), (0, 3.04, 0))
    assert grave(findings(device, tmp_path, room + slab)) == []


def test_all_white_closed_rooms_are_refused(device, tmp_path):
    """The loader sees only rooms that are one shell: here edges meet in T-junctions."""
    white = FIVE_WALLS.replace("reflectance = 0.5", "reflectance = 1.0")
    low = rectangle("low wall", (0, 0, 0), (0, 3, 0), (0, 0, 1))
    wall = low + rectangle("high wall", (0, 0, 1), (0, 3, 0), (0, 0, 1.5))
    (finding,) = of_kind(findings(device, tmp_path, white + wall), "no-absorption")
    assert finding.severity == "fault"
    grey = rectangle("high wall", (0, 0, 1), (0, 3, 0), (0, 0, 1.5), material="other")
    assert grave(findings(device, tmp_path, white + low + grey)) == []
    assert grave(findings(device, tmp_path, white)) == []


@pytest.mark.parametrize(("reflectance", "expected"), [(0.97, 1), (0.9, 0)])
def test_bright_rooms_converge_slowly(device, tmp_path, reflectance, expected):
    bright = SOUND.replace("reflectance = 0.5", f"reflectance = {reflectance}")
    found = of_kind(findings(device, tmp_path, bright), "slow-convergence")
    assert len(found) == expected
    assert all("33.3 times" in finding.effect for finding in found)


def test_guessed_reflectances(device, tmp_path):
    guessed = SOUND.replace(
        "[materials.other]\nreflectance = 0.3",
        '[materials.other]\nreflectance = { rgb = [0.5, 0.4, 0.3], upsample = "mallett2019" }',
    )
    rug = rectangle("rug", (1, 1, 0.01), (1, 0, 0), (0, 2, 0), material="other")
    (finding,) = of_kind(findings(device, tmp_path, guessed + rug), "not-measured")
    assert finding.object == "other"
    assert of_kind(findings(device, tmp_path, guessed), "not-measured") == []


def test_lines_bands_and_ends_of_lamps(device, tmp_path):
    fine = SOUND.replace("first = 400, last = 700, step = 50", "first = 380, last = 780, step = 5")
    assert len(of_kind(findings(device, tmp_path, fine), "lamp-cut-off")) == 1
    assert of_kind(findings(device, tmp_path, fine), "line-in-band") == []
    assert of_kind(findings(device, tmp_path, fine), "bands-miss-light") == []
    sodium = fine.replace("{ constant = 1.0 }", "{ lines = [[589.0, 1.0]] }")
    found = findings(device, tmp_path, sodium)
    (finding,) = of_kind(found, "line-in-band")
    assert finding.message.startswith("100 % of the light of luminaire 'lamp'")
    assert "at 589 nm" in finding.message
    assert of_kind(found, "lamp-cut-off") == []
    red = SOUND.replace("first = 400, last = 700, step = 50", "first = 600, last = 700, step = 50")
    assert len(of_kind(findings(device, tmp_path, red), "bands-miss-light")) == 1


def test_many_findings_of_a_kind_are_counted(device, tmp_path):
    strips = "".join(rectangle(f"strip {k}", (1, 0.1 * k + 0.1, 1), (2, 0, 0), (0, 0.001, 0)) for k in range(20))
    found = of_kind(findings(device, tmp_path, SOUND + strips), "sliver")
    assert len(found) == MOST_OF_A_KIND
    assert f"and {20 - MOST_OF_A_KIND} more of this kind" in found[-1].message


def test_findings_do_not_depend_on_where_the_scene_is(device, tmp_path):
    """The same furnished room 100 km away: kinds and objects are the same."""
    rug = rectangle("rug", (1, 1, 0), (1, 0, 0), (0, 2, 0), material="other")
    here = findings(device, tmp_path, ROOM + LAMP + rug)
    far = 1e5
    moved = HEADER + box("room", (far, far, 0), (4, 3, 2.5), "inside = true")
    moved += rectangle("panel", (far + 1.5, far + 1, 2.3), (0, 0.5, 0), (0.5, 0, 0), luminaire="lamp")
    moved += rectangle("rug", (far + 1, far + 1, 0), (1, 0, 0), (0, 2, 0), material="other")
    there = findings(device, tmp_path, moved)
    assert [(f.kind, f.object) for f in here] == [(f.kind, f.object) for f in there]
    np.testing.assert_allclose(there[0].place - here[0].place, [far, far, 0], atol=1e-9)

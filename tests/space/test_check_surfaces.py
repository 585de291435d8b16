"""Findings about surfaces: what lies in one place, shapes, shells; each with a scene that has it and one without."""

import numpy as np
import pytest
from check_rooms import HEADER, LAMP, ROOM, SOUND, box, findings, grave, of_kind, points, rectangle

from hradiosity.space.overlaps import overlap_areas, overlapping_boxes


def test_a_sound_room_has_nothing_grave(device, tmp_path):
    found = findings(device, tmp_path, SOUND)
    assert grave(found) == []
    assert [f.kind for f in found if f.kind != "lamp-cut-off" and f.kind != "bands-miss-light"] == ["space"]


def test_contact_is_no_fault(device, tmp_path):
    """A box on the floor, one on top of it, one beside it, one against the wall, a lamp box under the ceiling."""
    stacked = (
        box("low", (1, 1, 0), (1, 1, 0.5))
        + box("high", (1.2, 1.2, 0.5), (0.5, 0.5, 0.5), material="other")
        + box("beside", (2, 1, 0), (0.5, 1, 0.5), material="other")
        + box("shelf", (0, 0.5, 1), (0.3, 1, 0.5))
        + box("lamp box", (3, 1, 2.4), (0.5, 0.5, 0.1), 'luminaires = { bottom = "lamp" }')
    )
    assert grave(findings(device, tmp_path, ROOM + stacked)) == []


def test_a_lamp_in_the_plane_of_the_ceiling_is_named_with_its_area(device, tmp_path):
    flush = rectangle("panel", (1.5, 1.0, 2.5), (0, 0.5, 0), (0.5, 0, 0), luminaire="lamp")
    (finding,) = of_kind(findings(device, tmp_path, ROOM + flush), "lamp-in-surface")
    assert "'panel'" in finding.message
    assert "'room'" in finding.message
    assert "0.25 m²" in finding.message
    assert finding.severity == "warning"
    np.testing.assert_allclose(finding.place, [1.75, 1.25, 2.5], atol=1e-12)
    assert finding.size == pytest.approx(0.5, rel=1e-5)


@pytest.mark.parametrize(("rise", "expected"), [(0.0, 1), (1e-6, 1), (1e-3, 0)])
def test_a_rug_in_the_floor(device, tmp_path, rise, expected):
    rug = rectangle("rug", (1, 1, rise), (1, 0, 0), (0, 2, 0), material="other")
    found = of_kind(findings(device, tmp_path, SOUND + rug), "coincident-surfaces")
    assert len(found) == expected
    assert all("2 m²" in finding.message for finding in found)


def test_faces_twice(device, tmp_path):
    twins = "".join(rectangle(name, (1, 1, 1), (1, 0, 0), (0, 1, 0)) for name in ("board", "board again"))
    (finding,) = of_kind(findings(device, tmp_path, SOUND + twins), "duplicate-faces")
    assert "'board' and 'board again'" in finding.message
    apart = rectangle("board", (1, 1, 1), (1, 0, 0), (0, 1, 0)) + rectangle("more", (2, 1, 1), (1, 0, 0), (0, 1, 0))
    assert grave(findings(device, tmp_path, SOUND + apart)) == []


@pytest.mark.parametrize(
    ("material", "kind", "severity"),
    [
        ("paint", "sheet-modelled-twice", "info"),
        ("other", "coincident-back-to-back", "info"),
        ("shield", "coincident-back-to-back", "info"),
    ],
)
def test_a_sheet_of_two_faces_matters_when_they_differ(device, tmp_path, material, kind, severity):
    front = rectangle("front", (1, 1, 1), (1, 0, 0), (0, 1, 0), material="paint")
    back = rectangle("back", (1, 1, 1), (0, 1, 0), (1, 0, 0), material=material)
    (finding,) = of_kind(findings(device, tmp_path, SOUND + front + back), kind)
    assert finding.severity == severity


def test_slivers(device, tmp_path):
    thin = rectangle("strip", (1, 1, 1), (2, 0, 0), (0, 0.001, 0))
    (finding,) = of_kind(findings(device, tmp_path, SOUND + thin), "sliver")
    assert (finding.object, finding.size) == ("strip", 2.0)
    wider = rectangle("strip", (1, 1, 1), (2, 0, 0), (0, 0.003, 0))
    assert of_kind(findings(device, tmp_path, SOUND + wider), "sliver") == []


def test_far_parts_and_the_detail_that_they_cost(device, tmp_path):
    detail = rectangle("screw", (1, 1, 1), (0.001, 0, 0), (0, 0.001, 0))
    assert grave(findings(device, tmp_path, SOUND + detail)) == []
    far = rectangle("leftover", (20_000, 0, 0), (1, 0, 0), (0, 1, 0))
    found = findings(device, tmp_path, SOUND + detail + far)
    (part,) = of_kind(found, "far-part")
    assert part.object == "leftover"
    assert part.size == pytest.approx(2e4, rel=1e-2)
    assert {lost.object for lost in of_kind(found, "unresolved-detail")} == {"screw", "panel", "leftover"}
    (ratio,) = of_kind(found, "size-range")
    assert ratio.object == "screw"


def test_tiny_faces(device, tmp_path):
    speck = rectangle("speck", (1, 1, 1), (2e-5, 0, 0), (0, 2e-5, 0))
    (finding,) = of_kind(findings(device, tmp_path, SOUND + speck), "tiny-face")
    assert finding.object == "speck"


def test_furniture_inside_out(device, tmp_path):
    turned = box("cupboard", (1, 1, 0.5), (1, 1, 1), "inside = true")
    (finding,) = of_kind(findings(device, tmp_path, SOUND + turned), "inside-out")
    assert finding.object == "cupboard"
    np.testing.assert_allclose(finding.place, [1.5, 1.5, 1.0])
    right = box("cupboard", (1, 1, 0.5), (1, 1, 1))
    assert of_kind(findings(device, tmp_path, SOUND + right), "inside-out") == []


def test_a_box_without_a_face_is_not_closed(device, tmp_path):
    lidless = box("bin", (1, 1, 0.5), (0.5, 0.5, 0.5), 'omit = ["top"]')
    (finding,) = of_kind(findings(device, tmp_path, SOUND + lidless), "open-body")
    assert (finding.object, finding.severity) == ("bin", "info")
    assert "4 of its 12 edges" in finding.message
    np.testing.assert_allclose(finding.place, [1.25, 1.25, 1.0])


@pytest.mark.parametrize(("material", "expected"), [("shield", ["black-back"]), ("paint", [])])
def test_one_sided_backs_in_the_light(device, tmp_path, material, expected):
    screen = rectangle("screen", (2, 1, 0.5), (0, 1, 0), (0, 0, 1), material=material)
    found = findings(device, tmp_path, SOUND + screen)
    assert grave(found) == expected
    assert all("1 m²" in f.message and f.object == "screen" for f in of_kind(found, "black-back"))


def test_a_room_facing_outwards_is_refused(device, tmp_path):
    room = HEADER + box("room", (0, 0, 0), (4, 3, 2.5)) + LAMP + points("desk", [(1, 1, 0.7)])
    found = findings(device, tmp_path, room)
    assert grave(found) == ["lamp-in-solid", "sensor-in-solid"]
    assert all(f.severity == "fault" and "'room'" in f.message for f in found if f.severity != "info")


def test_areas_of_overlaps_against_known_ones():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    triangle = np.array([[0.0, 0], [1, 0], [0, 1], [0, 1]])
    diamond = np.array([[0.5, 0], [1, 0.5], [0.5, 1], [0, 0.5]])
    cases = [
        (square, square, 1.0),
        (square, square[::-1], 1.0),
        (square, square + np.array([0.25, 0.5]), 0.375),
        (square, square + np.array([1.0, 0.0]), 0.0),
        (square, square + np.array([3.0, 0.0]), 0.0),
        (square, triangle, 0.5),
        (triangle, triangle[[3, 1, 0, 0]], 0.5),
        (square, diamond, 0.5),
        (square, 0.1 * square + 0.3, 0.01),
        (0.1 * square + 0.3, square, 0.01),
        (triangle, 1 - triangle, 0.0),
    ]
    a, b, exact = (np.array(column) for column in zip(*cases, strict=True))
    np.testing.assert_allclose(overlap_areas(a, b), exact, atol=3e-6)


def test_overlapping_boxes_against_all_pairs():
    rng = np.random.default_rng(3)
    low = rng.random((400, 2))
    high = low + 10.0 ** rng.uniform(-4, 0, (400, 2))
    group = rng.integers(0, 3, 400)
    common = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    wanted = (common > 1e-3).all(axis=2) & (group[:, None] == group)
    np.testing.assert_array_equal(overlapping_boxes(low, high, group, 1e-3), np.argwhere(np.triu(wanted, 1)))

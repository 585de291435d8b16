"""The cases of `hradiosity validate`: their references, their scenes, and how numbers are judged."""

import math

import numpy as np
import pytest

from hradiosity.io.scene_toml import load_scene
from hradiosity.options import Options
from hradiosity.reference.point_factors import points_to_polygon
from hradiosity.show.charts import ChartPoint, curve_chart, nice_ticks
from hradiosity.suites.validation import closed_forms, data
from hradiosity.suites.validation.catalogue import all_cases, all_not_run, chosen
from hradiosity.suites.validation.running import judge
from hradiosity.suites.validation.values import Case, Job, Measured, Point

CASES = all_cases()


def factor(point, corners):
    return points_to_polygon(np.array([point["p"]], float), np.array([point["n"]], float), np.array(corners, float))[0]


def rectangle(low, high, z):
    return [(low[0], low[1], z), (high[0], low[1], z), (high[0], high[1], z), (low[0], high[1], z)]


def references(name):
    points = data.cie171()[name]["points"]
    return points.values(), np.array([point["value"] for point in points.values()])


def test_a_cosine_source_by_formula():
    """1000 cos θ cd at 3 m: E = 1000 cos⁴θ / 9."""
    points, known = references("5.2-lambertian")
    expected = [1000 / 9 * (9 / (9 + p["p"][0] ** 2 + p["p"][1] ** 2)) ** 2 for p in points]
    np.testing.assert_allclose(known, expected, rtol=1e-11)


@pytest.mark.parametrize(
    ("name", "corners", "scale", "digits"),
    [
        ("5.3", rectangle((1.5, 1.5), (2.5, 2.5), 3), 1000 * math.pi, 1e-10),
        ("5.6-2", rectangle((0, 0), (4, 4), 0), 100, 1e-10),
        ("5.6-3", rectangle((-248, -248), (252, 252), 0), 100, 1e-10),
        ("5.9-1x1-t5", rectangle((1.5, 1.5), (2.5, 2.5), 3), 100, 1e-7),
    ],
)
def test_single_polygons_by_lambert(name, corners, scale, digits):
    points, known = references(name)
    np.testing.assert_allclose(known, [scale * factor(point, corners) for point in points], rtol=digits)


def test_window_and_ground_by_lambert():
    """From the floor the opening shows sky, to the ceiling it shows ground of 0.3 times its exitance."""
    points, known = references("5.11-2x1-t5")
    opening = [(1, 0, 1), (3, 0, 1), (3, 0, 2), (1, 0, 2)]
    for point, value in zip(points, known):
        if point["n"][2]:
            share = 1.0 if point["n"][2] > 0 else 0.3
            assert value == pytest.approx(100 * share * factor(point, opening), rel=1e-6)


def test_closures():
    shares = [point["value"] for point in data.cie171()["5.4"]["points"].values()]
    assert sum(shares) == pytest.approx(1.0, abs=1e-12)
    for point in data.cie171()["5.8-average"]["points"].values():
        rho = point["rho"]
        assert point["value"] == pytest.approx(rho * 10000 / (96 * (1 - rho)), abs=1e-9)
    for room in data.box_rooms().values():
        x, y, z = room["dims"]
        area = {"x0": y * z, "x1": y * z, "y0": x * z, "y1": x * z, "floor": x * y, "ceiling": x * y}
        absorbed = sum((1 - room["rho"][f]) * area[f] * mean["total"] for f, mean in room["face_means"].items())
        source = room["source"]
        offset = 5000 * 0.72 if "0.6x1.2" in source else 1000 * math.pi
        sent = 10000 if "isotropic" in source else 16000 if "whole" in source else offset
        assert absorbed == pytest.approx(sent, rel=1e-3), room["id"]


def test_names_are_unique_and_each_case_of_the_data_is_run_or_named():
    names = [case.name for case in CASES] + [case.name for case in all_not_run()]
    assert len(set(names)) == len(names)
    assert set(data.cie171()) <= set(names)
    points = {point.name for case in CASES if case.name.startswith("form-factors") for point in case.points}
    rest = {name.removeprefix("form-factors-") for name in names}
    assert {entry["id"] for entry in data.form_factors()} - points - rest == {"C03"}  # the cube, a case of its own


def test_choice():
    assert [case.name for case in chosen(["5.7"])[0]] == ["5.7-wall", "5.7-floor"]
    assert len(chosen(["cube-iso-*"])[0]) == 7
    assert len(chosen([])[0]) == len(CASES)


def test_scenes_can_be_loaded(tmp_path):
    """All that need no mesh; every point has its reading."""
    jobs = dict.fromkeys(job for case in CASES for job in case.jobs if not job.files)
    for number, job in enumerate(jobs):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / "scene.toml").write_text(job.text, encoding="utf-8")
        scene = load_scene(folder)
        assert len(scene.sensors[0].position) >= 1
        job.options(None), job.options("draft")


def test_a_quality_takes_the_place_of_a_case_s_own_effort():
    job = Job("", effort=(("gather_samples", 7000),), fixed=(("element_size", 0.3),))
    own, draft = job.options(None), job.options("draft")
    assert (own.gather_samples, own.element_size) == (7000, 0.3)
    assert (draft.gather_samples, draft.element_size) == (Options.of_quality("draft").gather_samples, 0.3)
    assert job.settings("draft") == "quality draft, element_size = 0.3"


@pytest.mark.parametrize("inwards", [False, True])
def test_spheres(inwards):
    corner, triangle = closed_forms.sphere(2.0, 2, inwards=inwards)
    assert len(triangle) == 320
    first, second, third = (corner[triangle[:, k]] for k in range(3))
    across = np.cross(second - first, third - first)
    assert np.linalg.norm(across, axis=1).sum() / 2 == pytest.approx(16 * math.pi, rel=1e-12)
    assert ((np.einsum("td,td->t", across, first) < 0) == inwards).all()


def case_of(*references):
    points = tuple(Point(str(k), value, 0.01) for k, value in enumerate(references))
    return Case("c", "t", "g", "q", "1", points, lambda bench: [])


def test_judgement():
    rows = judge(case_of(2.0, 4.0, 0.0), [Measured(2.01, 0.02), Measured(4.1), Measured(0.01)])
    assert [row.deviation for row in rows] == pytest.approx([0.005, 0.025, 0.005])
    assert [row.passed for row in rows] == [True, False, True]
    assert rows[0].relative_half_width == pytest.approx(0.01) and rows[1].relative_half_width is None
    assert not judge(case_of(1.0), [Measured(math.nan)])[0].passed
    with pytest.raises(ValueError, match="2 numbers for 1 points"):
        judge(case_of(1.0), [Measured(1.0), Measured(1.0)])


@pytest.mark.parametrize("references", [(0.0,), (0.0, 0.0), (-1.0, 2.0), (5.0,), (1e-7, 1.0), tuple(range(40))])
def test_charts_of_any_numbers(references):
    points = [ChartPoint(f"<{k}>", value, value, 0.0, None, 0.01) for k, value in enumerate(references)]
    svg = curve_chart("a & b", "x [lx]", [*points, ChartPoint("nan", math.nan, 1.0, math.nan, None, 0.01)])
    assert "&lt;0&gt;" in svg and "a &amp; b" in svg and "nan " not in svg.replace("nan</text>", "")
    assert svg.count("<circle") == 1 + 3 * len(references) + 1


def test_ticks_are_round():
    assert nice_ticks(0.0, 10.0) == pytest.approx([0, 2, 4, 6, 8, 10])
    assert nice_ticks(-0.0125, 0.0125, 4) == pytest.approx([-0.01, 0.0, 0.01])

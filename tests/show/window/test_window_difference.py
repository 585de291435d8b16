"""Two results: which fit together, what their difference looks like, and what is told of a place in both."""

from dataclasses import replace

import numpy as np
import pytest

from hradiosity.errors import SceneError
from hradiosity.io.results_reading import read_result
from hradiosity.io.scene_drawing import draw_scene
from hradiosity.model.spectrum import Bands
from hradiosity.show.window.difference import (
    Comparison,
    difference_bytes,
    difference_colours,
    difference_scale,
    painted_difference,
)
from hradiosity.show.window.facts import facts_of, joined_facts, light_lines
from hradiosity.show.window.locating import middles
from hradiosity.show.window.look import NO_LINES, Look
from hradiosity.show.window.picking import Picked
from hradiosity.show.window.subject import Choices, Subject


@pytest.fixture(scope="module")
def pair(solved, darker):
    first = Subject(read_result(solved[1]), Choices())
    return first, Subject(read_result(darker), Choices(), like=first)


def test_darker_walls_take_light(pair):
    first, second = pair
    compared = Comparison(first, second, ("a", "b"))
    before, after = compared.values("illuminance")
    assert (after - before).mean() < 0.0
    np.testing.assert_array_equal(before, first.values.flat.illuminance)
    summary = compared.summary("illuminance")
    assert summary.mean < 0.0 < summary.rms < summary.level and not summary.equal
    assert Comparison(first, first, ("a", "a")).summary("luminance").equal


def test_other_elements_of_one_room_are_compared_by_place(pair, finer):
    """Light of both is the same but for noise and the size of elements, which is a small part of it."""
    first, second = pair[0], Subject(read_result(finer), Choices())
    assert len(second.cells) > 1.5 * len(first.cells)
    compared, other_way = Comparison(first, second, ("a", "b")), Comparison(second, first, ("b", "a"))
    assert (compared.base, other_way.base) == (1, 0) and not compared.same_mesh
    assert compared.lost_share < 0.02
    one, other = compared.summary("illuminance"), other_way.summary("illuminance")
    assert one.mean == pytest.approx(-other.mean) and one.rms == pytest.approx(other.rms)
    assert abs(one.mean) < 0.05 * one.level and 0.0 < one.rms < 0.25 * one.level
    before, after = compared.values("illuminance")
    met = ~compared.lost
    assert np.corrcoef(before[met], after[met])[0, 1] > 0.9
    np.testing.assert_array_equal(np.isnan(before), compared.lost)


def test_light_of_another_mesh_is_read_where_it_is(pair, finer):
    """Light that is linear over the room is so between the elements of either mesh, but for what lies at edges."""
    plane = np.array([30.0, -20.0, 10.0])
    subjects = []
    for subject in (pair[0], Subject(read_result(finer), Choices())):
        cells, light = subject.cells, subject.drawn.light
        middle = middles(cells)[0]
        area = np.bincount(cells.element, cells.area, len(light.irradiance))
        sums = [np.bincount(cells.element, cells.area * column, len(area)) for column in middle.T]
        per_element = 200.0 + np.stack(sums, axis=1) / area[:, None] @ plane
        flat = np.repeat(per_element[:, None], light.irradiance.shape[1], axis=1)
        subjects.append(Subject(replace(subject.drawn, light=replace(light, irradiance=flat)), Choices()))
    summary = Comparison(*subjects, ("a", "b")).summary("illuminance")
    assert abs(summary.mean) < 2e-3 * summary.level
    assert summary.rms < 0.02 * summary.level


def test_where_one_has_no_surface_there_is_no_difference(pair):
    first, second = pair
    kept = second.cells.object != second.cells.object[0]
    fewer = {n: getattr(second.cells, n)[kept] for n in second.cells.__dataclass_fields__}
    part = Subject(replace(second.drawn, cells=type(second.cells)(**fewer)), Choices())
    compared = Comparison(first, part, ("a", "b"))
    assert compared.base == 0 and 0.01 < compared.lost_share < 0.5
    np.testing.assert_array_equal(compared.lost, ~kept)
    shown = painted_difference(compared, Look())
    assert len(np.unique(shown.colours[compared.lost], axis=0)) == 1
    assert shown.look.lines != NO_LINES


def test_two_results_have_one_exposure_and_one_scale(pair):
    first, second = pair
    for look in (Look(), Look(logarithmic=True, quantity="luminance", stops=1.0)):
        assert first.luminance(look) == second.luminance(look)
        assert first.scale(look) == second.scale(look)


def test_the_scale_is_even_to_both_sides():
    scale = difference_scale(np.array([-7.3, 2.0, 900.0]), np.array([True, True, False]), "illuminance")
    assert scale.low == -scale.high
    assert 7.0 < scale.high < 12.0
    assert scale.ticks()[0] == scale.low and scale.ticks()[-1] == scale.high
    colours = difference_bytes(np.array([scale.low, 0.0, scale.high]), scale)
    assert colours[1].min() > 225, "nothing changed: near white"
    assert colours[0, 2] > colours[0, 0] + 60, "less: blue"
    assert colours[2, 0] > colours[2, 2] + 60, "more: brown"


def test_the_colours_get_darker_to_both_sides():
    luminance = difference_colours() ** 2.2 @ [0.2126, 0.7152, 0.0722]
    middle = len(luminance) // 2
    assert (np.diff(luminance[: middle + 1]) > 0.0).all()
    assert (np.diff(luminance[middle:]) < 0.0).all()


def test_colour_blind_eyes_tell_both_ends_apart():
    """Protanopes and deuteranopes lack one of red and green; blue against the mean of both is left to them."""
    ends = difference_colours()[[0, -1]] ** 2.2
    blue_share = ends[:, 2] / ends.sum(axis=1)
    assert blue_share[0] > 0.4 > 0.15 > blue_share[1]


def test_what_does_not_fit_is_told(pair, room):
    first, second = pair
    elsewhere = replace(second.drawn, cells=replace(second.cells, corners=second.cells.corners + 0.1))
    for drawn, words in ((elsewhere, "elsewhere"), (draw_scene(room), "scene")):
        with pytest.raises(SceneError, match=words):
            Comparison(first, Subject(drawn, Choices()), ("a", "b"))


def test_a_place_in_both_tells_what_differs(pair):
    picked = Picked("cell", 5, np.zeros(3))
    found = [facts_of(subject.drawn, subject.drawn.light, picked) for subject in pair]
    both = dict(joined_facts(*found).lines)
    assert " → " in both["illuminance"] and both["illuminance"].endswith(" lx")
    assert " → " not in both["area"]
    assert joined_facts(*found).curves[0].other is not None


def test_facts_of_an_element_are_its_numbers(subject):
    cell = 3
    facts = facts_of(subject.drawn, subject.drawn.light, Picked("cell", cell, np.array([1.0, 2.0, 3.0])))
    lines = dict(facts.lines)
    assert float(lines["illuminance"].split()[0]) == pytest.approx(subject.values.flat.illuminance[cell], rel=1e-3)
    assert float(lines["luminance"].split()[0]) == pytest.approx(subject.values.flat.xyz[cell, 1], rel=1e-3)
    assert lines["point"] == "1.000, 2.000, 3.000 m"
    assert [curve.name for curve in facts.curves] == ["irradiance", "radiance", "reflectance"]
    assert "m²" in lines["area"] and "CCT" in lines and "x, y" in lines


def test_why_there_is_no_colour_temperature_is_told():
    bands = Bands.uniform()
    green = np.where(np.abs(bands.centre - 540.0) < 10.0, 1.0, 0.0)
    found = dict(light_lines(green, bands))
    assert found["CCT"].startswith("none: more than") and found["Duv"] == "none"
    assert dict(light_lines(0.0 * green, bands))["CCT"] == "none: no light"
    assert dict(light_lines(np.ones(len(bands)), bands))["CCT"].endswith(" K")


def test_facts_of_a_sensor_are_its_reading(subject, solved):
    desk = solved[0].readings["desk"]
    facts = facts_of(subject.drawn, subject.drawn.light, Picked("sensor", 4, np.zeros(3)))
    value, _, half, unit = dict(facts.lines)["illuminance"].split()
    assert facts.title == "desk [4]"
    assert float(value) == pytest.approx(desk.illuminance[4], abs=0.06)
    assert float(half) == pytest.approx(desk.illuminance_half_width[4], abs=0.06)
    assert unit == "lx"
    assert facts.curves[0].half_width is not None


def test_facts_of_a_luminance_are_those_of_what_is_looked_at(subject, solved):
    gaze = solved[0].readings["gaze"]
    facts = facts_of(subject.drawn, subject.drawn.light, Picked("sensor", 7, np.zeros(3)))
    value, _, _, unit = dict(facts.lines)["luminance"].split()
    assert facts.title == "gaze [1]"
    assert float(value) == pytest.approx(gaze.illuminance[1], abs=0.06)
    assert unit == "cd/m²"
    assert (facts.curves[0].name, facts.curves[0].half_width) == ("radiance", None)
    assert "illuminance" not in dict(facts.lines)

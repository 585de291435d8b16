"""Results read back for the window: the same numbers, and no other error than one that names the file."""

import shutil

import h5py
import numpy as np
import pytest

from hradiosity.errors import SceneError
from hradiosity.io.results_reading import read_result
from hradiosity.io.scene_drawing import draw_scene
from hradiosity.space.cells import cell_corners


def test_all_comes_back(solved):
    solution, folder = solved
    drawn = read_result(folder)
    scene, cells = solution.scene, drawn.cells
    corners, triangle = cell_corners(scene.patches, solution.elements)
    np.testing.assert_array_equal(cells.corners, corners)
    np.testing.assert_array_equal(cells.is_triangle, triangle)
    np.testing.assert_allclose(drawn.light.irradiance, solution.surfaces.irradiance, rtol=1e-6)
    np.testing.assert_allclose(np.bincount(cells.element, cells.area), solution.elements.area, rtol=1e-9)
    assert drawn.words.materials == tuple(material.name for material in scene.materials)
    assert {drawn.words.luminaires[k] for k in cells.luminaire[cells.luminaire >= 0]} == {"lamp"}
    np.testing.assert_allclose(cells.area[cells.luminaire >= 0].sum(), 1.0)
    assert [view.name for view in drawn.views] == ["door", "corner"]
    np.testing.assert_allclose(drawn.views[0].direction, scene.views[0].direction)


def test_normals_point_to_who_looks(solved):
    drawn = read_result(solved[1])
    cells = drawn.cells
    walls = cells.object == drawn.words.objects.index("room")
    towards = np.array([1.5, 1.0, 1.25]) - cells.corners[walls].mean(axis=1)
    assert (np.einsum("nk,nk->n", cells.normal[walls], towards) > 0.0).all()


def test_sensors_come_back(solved):
    solution, folder = solved
    sensors, width = read_result(folder).sensors, solution.scene.bands.width
    desk, gaze = solution.readings["desk"], solution.readings["gaze"]
    np.testing.assert_allclose(sensors.position, np.concatenate([desk.position, gaze.position]), atol=1e-8)
    np.testing.assert_array_equal(sensors.looks, np.arange(8) >= 6)
    np.testing.assert_allclose(sensors.numbers["illuminance_lx"][:6], desk.illuminance, rtol=1e-6)
    assert np.isnan(sensors.numbers["illuminance_lx"][6:]).all()
    np.testing.assert_allclose(sensors.numbers["luminance_cd_m2"][6:], gaze.illuminance, rtol=1e-6)
    value, half_width = sensors.spectra()
    np.testing.assert_allclose(value[:6], desk.irradiance / width, rtol=1e-6)
    np.testing.assert_allclose(value[6:], gaze.irradiance / width, rtol=1e-6)
    np.testing.assert_allclose(half_width[:6], desk.half_width / width, rtol=1e-6)


def test_a_scene_shows_each_patch_and_the_backs_that_may_be_seen(room):
    cells = draw_scene(room).cells
    names = np.array(room.objects)[cells.object]
    assert np.count_nonzero(names == "room") == 6, "nothing lies behind the walls"
    assert np.count_nonzero(names == "sail") == 2
    assert set(cells.side[names == "lamp"]) == {0, 1}
    assert (cells.luminaire[(names == "lamp") & (cells.side == 0)] == 0).all()
    assert (cells.luminaire[(names == "lamp") & (cells.side == 1)] == -1).all()


@pytest.fixture
def copied(solved, tmp_path):
    return shutil.copytree(solved[1], tmp_path / "copy")


def fault_of(folder):
    with pytest.raises(SceneError) as caught:
        read_result(folder)
    return str(caught.value)


def test_files_that_are_cut_are_named(copied):
    file = copied / "solution.vtkhdf"
    whole = file.read_bytes()
    for share in (0.0, 0.01, 0.3, 0.9, 0.999):
        file.write_bytes(whole[: int(share * len(whole))])
        assert "solution.vtkhdf" in fault_of(copied)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("VTKHDF/CellData/element", lambda values: values + 10**6),
        ("VTKHDF/CellData/material", lambda values: values - 5),
        ("VTKHDF/CellData/irradiance", lambda values: values[:-1]),
        ("VTKHDF/CellData/irradiance", lambda values: values * np.nan),
        ("VTKHDF/Polygons/Offsets", lambda values: values * 2),
        ("hradiosity/drawing/cell_luminaire", lambda values: values + 7),
        ("hradiosity/drawing/views", lambda values: values[:, :5]),
        ("hradiosity/band_upper_nm", lambda values: values[::-1]),
    ],
)
def test_wrong_arrays_are_noticed(copied, name, change):
    with h5py.File(copied / "solution.vtkhdf", "r+") as file:
        values = change(file[name][()])
        del file[name]
        file[name] = values
    assert "solution.vtkhdf" in fault_of(copied)


def test_another_version_is_named(copied):
    with h5py.File(copied / "solution.vtkhdf", "r+") as file:
        file["hradiosity"].attrs["format"] = 99
    assert "another version" in fault_of(copied)
    with h5py.File(copied / "solution.vtkhdf", "r+") as file:
        file["hradiosity"].attrs["format"] = 1
        del file["hradiosity/drawing"]
    assert "another version" in fault_of(copied)


@pytest.mark.parametrize("text", ["", "sensor,index\n", "a,b,c\n1,2,3\n", "\x00\x01"])
def test_damaged_tables_are_named(copied, text):
    (copied / "readings.csv").write_text(text, encoding="utf-8")
    assert "readings.csv" in fault_of(copied)


def test_a_damaged_number_is_named(copied):
    table = (copied / "readings.csv").read_text(encoding="utf-8")
    (copied / "readings.csv").write_text(table.replace("0.8", "o.8", 1), encoding="utf-8")
    assert "readings.csv" in fault_of(copied)

"""Sensors of other kinds than planes in scene files, and what is wrong with some."""

import numpy as np
import pytest
from scene_writing import OPEN_ROOM, faults, load

VIEW = '[[view]]\nname = "a"\nposition = [1, 1, 1]\ntarget = [1, 1, 0]\nup = [0, 1, 0]\nsize = [100, 50]\n'


def sensor(tmp_path, text):
    return load(tmp_path, f'{OPEN_ROOM}{VIEW}[[sensor]]\nname = "s"\n{text}\n').sensors[0]


def faults_of(tmp_path, text):
    return faults(tmp_path, f'{OPEN_ROOM}{VIEW}[[sensor]]\nname = "s"\n{text}\n')


@pytest.mark.parametrize(
    ("keys", "count", "direction"),
    [
        ('response = "cylindrical"', 3, (0, 0, 1)),
        ('response = "cylindrical"\naxis = [2, 0, 0]', 3, (1, 0, 0)),
        ('response = "semi-cylindrical"\nfacing = [3, 0, 4]', 3, (1, 0, 0)),
        ('response = "spherical"', 4, (0, 0, 1)),
    ],
)
def test_points_that_are_no_planes(tmp_path, keys, count, direction):
    found = sensor(tmp_path, f'kind = "points"\npositions = [[1, 1, 1], [2, 1, 1]]\n{keys}')
    assert found.n_readings == 2
    assert found.parts.count == count
    np.testing.assert_array_equal(found.place, [[1, 1, 1], [2, 1, 1]])
    np.testing.assert_allclose(found.direction, [direction, direction], atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(found.normal, axis=1), 1)
    np.testing.assert_array_equal(found.position, np.repeat(found.place, count, axis=0))


GRID = 'kind = "grid"\ncorner = [0, 0, 1]\nedge_u = [4, 0, 0]\nedge_v = [0, 2, 0]\n'


def test_spacing_and_border_of_a_grid(tmp_path):
    found = sensor(tmp_path, GRID + "spacing = 0.6\nborder = 0.5")
    assert found.grid == (2, 5)
    np.testing.assert_allclose(found.place.min(axis=0), [0.8, 0.75, 1])
    np.testing.assert_allclose(found.place.max(axis=0), [3.2, 1.25, 1])
    standard = sensor(tmp_path, GRID + 'spacing = "EN 12464-1"\nresponse = "cylindrical"')
    assert standard.grid == (6, 12)
    assert len(standard.position) == 3 * 6 * 12


def test_border_of_a_slanted_grid_is_as_wide_along_all_edges(tmp_path):
    text = (
        'kind = "grid"\ncorner = [0, 0, 1]\nedge_u = [4, 0, 0]\nedge_v = [2, 2, 0]\ncounts = [400, 200]\nborder = 0.5'
    )
    place = sensor(tmp_path, text).place
    assert place[:, 1].min() == pytest.approx(0.5, abs=0.01)
    slanted = np.array([1.0, -1.0]) / np.sqrt(2)
    assert (place[:, :2] @ slanted).min() == pytest.approx(0.5, abs=0.01)


def test_luminances_know_what_they_look_at(tmp_path):
    found = sensor(
        tmp_path,
        'kind = "luminance"\neye = [0.5, 0.5, 1]\n'
        "targets = [[0.5, 0.5, 0], [0.5, 0.5, 3], [0.5, 0.5, -1], [9, 9, 1.1]]",
    )
    np.testing.assert_allclose(found.place, np.tile([0.5, 0.5, 1.0], (4, 1)))
    np.testing.assert_array_equal(found.parts.looks.material, [0, 0, 0, -1])
    np.testing.assert_array_equal(found.parts.looks.luminaire, [-1, 0, -1, -1])
    np.testing.assert_array_equal(found.parts.looks.sky, [False, False, False, True])
    np.testing.assert_allclose(found.position[:2], [[0.5, 0.5, 0.001], [0.5, 0.5, 2.999]])
    np.testing.assert_allclose(found.normal[:2], [[0, 0, 1], [0, 0, -1]])


def test_rays_of_a_region_go_through_even_cells(tmp_path):
    """Looking straight down from 1 m with 60° over 100 pixels: a pixel is 2 tan 30° / 100 m of the floor."""
    found = sensor(tmp_path, 'kind = "luminance"\nview = "a"\npixels = [50, 0, 100, 25]\nrays = [2, 1]')
    pixel = 2 * np.tan(np.radians(30)) / 100
    assert found.n_readings == 1
    away = found.position[:, :2] - 1
    np.testing.assert_allclose(away, [[12.5 * pixel, 12.5 * pixel], [37.5 * pixel, 12.5 * pixel]], rtol=1e-9)


POINTS = 'kind = "points"\npositions = [[1, 1, 1]]\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (POINTS + 'response = "round"', "response"),
        (POINTS + 'response = "spherical"\nnormal = [0, 0, 1]', "normal"),
        (POINTS + 'response = "semi-cylindrical"', "facing"),
        (POINTS + 'response = "semi-cylindrical"\nfacing = [0, 0, 1]', "along the axis"),
        (POINTS + "normal = [0, 0, 1]\naxis = [0, 0, 1]", "axis"),
        (GRID + "counts = [2, 2]\nspacing = 1", "exactly one"),
        (GRID + "counts = [2, 2]\nborder = 1", "leaves no area"),
        (GRID + 'spacing = "EN"', "spacing"),
        ('kind = "eye"\npositions = [[1, 1, 1]]\ngaze = [1, 0, 0]\nfield = { up = 0 }', "up"),
        ('kind = "eye"\npositions = [[1, 1, 1]]\ngaze = [1, 0, 0]\nfield = { over = 5 }', "over"),
        ('kind = "eye"\npositions = [[1, 1, 1]]\ngaze = [1, 0, 0]\nglare = true\nfield = { up = 9 }', "glare"),
        ('kind = "luminance"\nview = "b"', "no view 'b'"),
        ('kind = "luminance"\nview = "a"\nvoid = 1', "void"),
        ('kind = "luminance"\nview = "a"\npixels = [50, 0, 50, 20]', "no rectangle"),
        ('kind = "luminance"\nview = "a"\nrays = [1000, 1000]', "rays"),
        ('kind = "luminance"\ntargets = [[1, 1, 0]]', "eye: is missing"),
        ('kind = "luminance"\nview = "a"\neye = [1, 1, 1]', "eye given; none of that with a view"),
        ('kind = "eye"\npositions = [[1, 1, 1]]\ngaze = [1, 0, 0]\nglare = "yes"', "true or false"),
        ('kind = "eye"\npositions = [[1, 1, 1]]\ngaze = [1, 0, 0]\nfield = 50', "a table of keys"),
        ('kind = "luminance"\neye = [1, 1, 1]\ntargets = [[1, 1, 1]]', "no direction"),
        ('kind = "luminance"\neye = [1, 1, 1]\ntargets = [[1, 1, 0]]\nrays = [2, 2]', "rays"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, text, words):
    (found,) = faults_of(tmp_path, text)
    assert words in found


def test_maintenance_factors_and_actions(tmp_path):
    (tmp_path / "a.csv").write_text("400,1\n900,1\n")
    text = OPEN_ROOM.replace('unit = "m"', 'unit = "m"\nmaintenance_factor = 0.8') + '[actions.a]\nfile = "a.csv"\n'
    scene = load(tmp_path, text)
    (kept,) = scene.variants
    np.testing.assert_allclose(kept.luminaires[0].exitance, 0.8 * scene.luminaires[0].exitance)
    assert kept.name == "maintained"
    assert any("actions.a" in str(note) and "outside the bands" in str(note) for note in scene.notes)
    (tmp_path / "a.csv").write_text("400,0\n900,0\n")
    (found,) = faults(tmp_path, text)
    assert "all weights are 0" in found
    (tmp_path / "a.csv").write_text("400,1\n900,1\n")
    twice = text + '[[variant]]\nname = "Maintained"\nmaterials = { paint = 0.1 }\n'
    assert "another name" in faults(tmp_path, twice)[0]
    for broken, words in (("factor = 0.8", "factor = 1.2"), ('"a.csv"', '"b.csv"'), ("actions.a", 'actions."a b"')):
        assert len(faults(tmp_path, text.replace(broken, words))) == 1

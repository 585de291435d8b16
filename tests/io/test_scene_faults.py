"""Every mistake in a scene file is named, with its line and a way out."""

import pytest
from scene_writing import FLOOR, HEADER, LAMP, OPEN_ROOM, PAINT, PANEL, faults, load, warnings, write

from hradiosity.errors import SceneError
from hradiosity.io.scene_toml import load_scene

BOX = """
[[box]]
corner = [0.0, 0.0, 0.0]
size = [4.0, 2.0, 3.0]
inside = true
material = "paint"
luminaire = "lamp"
"""
SENSOR = '[[sensor]]\nname = "a"\nkind = "points"\npositions = [[0, 0, 1]]\nnormal = [0, 0, 1]\n'
VIEW = '[[view]]\nname = "a"\nposition = [0, 0, 1]\ndirection = [0, 1, 0]\n'
POINT = '[[point_source]]\nname = "a"\nposition = [1, 1, 2]\nluminaire = "lamp"\n'
INFRARED = OPEN_ROOM.replace("{ constant = 1.0 }", "{ lines = [[950.0, 1.0]] }")


def only(found):
    assert len(found) == 1, found
    return found[0]


def test_the_open_room_is_valid(tmp_path):
    scene = load(tmp_path, OPEN_ROOM)
    assert warnings(scene) == []
    assert scene.sensors == ()


def test_no_such_file(tmp_path):
    with pytest.raises(SceneError, match="no such file"):
        load_scene(tmp_path / "nowhere")


def test_folder_without_scene_names_what_is_there(tmp_path):
    (tmp_path / "room.toml").write_text(OPEN_ROOM)
    with pytest.raises(SceneError, match=r"no scene\.toml.*room\.toml"):
        load_scene(tmp_path)


def test_folder_and_file_are_the_same_scene(tmp_path):
    file = write(tmp_path, OPEN_ROOM)
    assert load_scene(tmp_path).objects == load_scene(file).objects == ("floor", "panel")


def test_syntax_error_has_line_and_column(tmp_path):
    assert "line 2, column" in only(faults(tmp_path, "[scene]\nunit = m\n"))


def test_text_that_is_not_utf8(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_bytes('[scene]\nunit = "m"\ntitle = "Büro"\n'.encode("latin-1"))
    with pytest.raises(SceneError, match="UTF-8"):
        load_scene(file)


def test_byte_order_mark_is_no_fault(tmp_path):
    (tmp_path / "scene.toml").write_bytes(b"\xef\xbb\xbf" + OPEN_ROOM.encode())
    assert load_scene(tmp_path).objects == ("floor", "panel")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (OPEN_ROOM.replace("reflectance", "reflectence"), "did you mean 'reflectance'?"),
        (OPEN_ROOM.replace("edge_u = [4", "edgeu = [4"), "did you mean 'edge_u'?"),
        (OPEN_ROOM.replace("[materials.paint]", "[material.paint]"), "did you mean 'materials'?"),
        (OPEN_ROOM.replace("constant", "constnat"), "{ constant = … }"),
        (OPEN_ROOM + '[[sensor]]\nname = "a"\nkind = "gird"\n', "did you mean 'grid'?"),
        (OPEN_ROOM + '[[sensor]]\nname = "a"\nkind = "points"\nposition = [[0, 0, 1]]\n', "did you mean 'positions'?"),
        (OPEN_ROOM + '[[sensor]]\nname = "a"\n', "kind"),
        (OPEN_ROOM.replace('"m"', '"M"'), "did you mean 'm'?"),
        (OPEN_ROOM.replace('"m"', '"inch"'), "did you mean 'in'?"),
        (OPEN_ROOM.replace('"m"', '"parsec"'), "known: cm, ft, in, m, mm"),
        (OPEN_ROOM.replace('unit = "m"\n', ""), "unit of all lengths"),
        (OPEN_ROOM.replace('"m"\n', '"m"\nbands = { fist = 380 }\n'), "did you mean 'first'?"),
        (OPEN_ROOM.replace('"m"\n', '"m"\nbands = { first = 780, last = 380 }\n'), "first <= last"),
        (OPEN_ROOM.replace('"m"\n', '"m"\nbands = { edges = [500, 400] }\n'), "upper edge"),
        (OPEN_ROOM.replace('material = "paint"', 'material = "piant"', 1), "'piant'; did you mean 'paint'?"),
        (OPEN_ROOM.replace('luminaire = "lamp"', 'luminaire = "Lump"'), "no luminaire 'Lump'; did you mean 'lamp'?"),
        (OPEN_ROOM.replace("[[rectangle]]", "[rectangle]", 1).replace(PANEL, ""), "double brackets"),
        (OPEN_ROOM.replace("corner = [0.0, 0.0, 0.0]", "corner = [0.0, 0.0]"), "three numbers"),
        (OPEN_ROOM.replace("0.5", '"0.5"'), "a number 0 … 1"),
        (OPEN_ROOM.replace("absolute = true\n", ""), "exactly one of luminous_flux_lm"),
        (OPEN_ROOM.replace("absolute = true\n", "absolute = true\nradiant_flux_W = 3\n"), "_W and absolute given"),
        (OPEN_ROOM.replace("absolute = true\n", "radiant_flux_W = -3\n"), "greater than 0"),
        (OPEN_ROOM.replace("absolute = true\n", "absolute = false\n"), "absolute"),
    ],
)
def test_misspelt_or_missing(tmp_path, text, expected):
    assert any(expected in fault for fault in faults(tmp_path, text)), faults(tmp_path, text)


def test_faults_name_the_line(tmp_path):
    found = only(faults(tmp_path, OPEN_ROOM.replace("edge_v = [1.0, 0.0, 0.0]", "edge_v = [1.0, 0.0]")))
    line = OPEN_ROOM.splitlines().index("edge_v = [1.0, 0.0, 0.0]") + 1
    assert f"scene.toml:{line}: rectangle[1].edge_v" in found


def test_all_faults_come_at_once(tmp_path):
    text = (
        OPEN_ROOM.replace('"m"', '"parsec"').replace("0.5", "1.5").replace("edge_u = [4.0, 0.0, 0.0]", "edge_u = 4")
        + '[[view]]\nname = "v"\nposition = [0, 0, 1]\ndirection = [0, 0, 0]\n'
    )
    found = "\n".join(faults(tmp_path, text))
    for part in ("scene.unit", "materials.paint.reflectance", "rectangle[0].edge_u", "view[0].direction"):
        assert part in found


def test_entries_keep_their_numbers_when_an_earlier_one_is_faulty(tmp_path):
    """The second rectangle has a fault that is only found once the first, which is no rectangle, is out of the way."""
    text = OPEN_ROOM.replace("edge_u = [4.0, 0.0, 0.0]", "edge_u = 4")
    text = text.replace('luminaire = "lamp"', 'luminaire = "lomp"')
    lines = text.splitlines()
    first, second = faults(tmp_path, text)
    assert f"scene.toml:{lines.index('edge_u = 4') + 1}: rectangle[0].edge_u" in first
    assert f"scene.toml:{len(lines)}: rectangle[1].luminaire: no luminaire 'lomp'" in second


def test_a_faulty_material_makes_one_fault_and_not_one_for_each_use(tmp_path):
    assert "materials.paint" in only(faults(tmp_path, OPEN_ROOM.replace("reflectance = 0.5", "reflectance = [0.5]")))


@pytest.mark.parametrize(
    ("text", "effect"),
    [
        (OPEN_ROOM + "[sun]\nelevation = 30\n", "the sun"),
        (OPEN_ROOM + "[medium]\nextinction = 0.1\n", "a participating medium"),
        (OPEN_ROOM.replace("reflectance = 0.5", "reflectance = 0.5\ntransmittance = 0.1"), "transmission of light"),
        (OPEN_ROOM.replace("reflectance = 0.5", 'reflectance = 0.5\nfluorescence = "f.csv"'), "fluorescence"),
        (OPEN_ROOM.replace("reflectance = 0.5", "reflectance = 0.5\nspecular = 0.1"), "mirror or glossy reflection"),
        (OPEN_ROOM.replace("reflectance = 0.5", 'reflectance = 0.5\nkind = "mirror"'), "mirror reflection"),
        (OPEN_ROOM.replace("reflectance = 0.5", 'reflectance = 0.5\ntype = "glossy"'), "glossy reflection"),
        (OPEN_ROOM.replace("reflectance = 0.5", 'reflectance = { texture = "wood.png" }'), "a texture"),
        (OPEN_ROOM.replace("absolute = true", 'absolute = true\nies = "a.ies"'), "a photometric file (IES)"),
        (OPEN_ROOM.replace("{ constant = 1.0 }", '{ ldt = "a.ldt" }'), "a photometric file (EULUMDAT)"),
        (OPEN_ROOM + '[sky]\nkind = "perez"\nspectrum = { illuminant = "D65" }\nilluminance_lx = 1\n', "a sky other"),
    ],
)
def test_effects_that_are_not_built_are_refused_by_name(tmp_path, text, effect):
    found = [fault for fault in faults(tmp_path, text) if "is not simulated by this version" in fault]
    assert effect in only(found)


@pytest.mark.parametrize(
    ("reflectance", "expected"),
    [
        ("1.2", "percent"),
        ("80", "percent: write 0.8"),
        ("120.0", "reflectance 120; 0 to 1"),
        ("-0.1", "reflectance -0.1; 0 to 1"),
        ("nan", "a finite number"),
        ("{ steps = [[380, 500, 0.1], [500, 780, 1.4]] }", "reflectance 1.4 at"),
        ("{ steps = [[380, 500, 0.1], [510, 780, 0.4]] }", "without gap"),
        ("{ rgb = [0.1, 0.2, 0.7] }", "upsample: is missing"),
        ('{ rgb = [0.1, 0.2, 1.7], upsample = "mallett2019" }', "0 to 1"),
        ('{ library = "colorchecker/rde" }', "colorchecker/red"),
        ('{ library = "grey/150" }', "between 0 and 100"),
        ('{ file = "nothing.csv" }', "no file"),
        ('{ file = "spectar.csv" }', "did you mean 'spectra.csv'?"),
        ('{ file = "empty.csv" }', "is empty"),
        ('{ file = "nan.csv" }', "'nan' at 500 nm"),
        ('{ file = "percent.csv" }', "percent"),
        ('{ file = "unsorted.csv" }', "wavelength 400 after 500"),
        ('{ file = "short.csv", outside = "refuse" }', "covers 400 to 700 nm"),
        ('{ file = "short.csv", outside = "zero" }', "known: hold, refuse"),
    ],
)
def test_reflectance(tmp_path, reflectance, expected):
    files = {
        "spectra.csv": "380,0.1\n780,0.2\n",
        "empty.csv": "",
        "nan.csv": "380,0.1\n500,nan\n780,0.2\n",
        "percent.csv": "380,10\n780,20\n",
        "unsorted.csv": "380,0.1\n500,0.2\n400,0.1\n780,0.2\n",
        "short.csv": "400,0.1\n700,0.2\n",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    assert expected in only(faults(tmp_path, OPEN_ROOM.replace("reflectance = 0.5", f"reflectance = {reflectance}")))


def test_fault_in_a_spectrum_file_names_file_and_entry(tmp_path):
    (tmp_path / "nan.csv").write_text("380,0.1\n500,nan\n780,0.2\n")
    found = only(faults(tmp_path, OPEN_ROOM.replace("reflectance = 0.5", 'reflectance = { file = "nan.csv" }')))
    assert "nan.csv" in found
    assert "scene.toml:4 materials.paint.reflectance" in found


def test_face_without_area(tmp_path):
    text = OPEN_ROOM.replace("edge_v = [0.0, 2.0, 0.0]", "edge_v = [2.0, 0.0, 0.0]")
    assert "1 face without area" in only(faults(tmp_path, text))


def test_nothing_gives_light(tmp_path):
    found = only(faults(tmp_path, HEADER + PAINT + FLOOR))
    assert "nothing gives light" in found


def test_sky_is_light_enough(tmp_path):
    sky = '[sky]\nkind = "uniform"\nspectrum = { illuminant = "D65" }\nilluminance_lx = 1000\n'
    assert load(tmp_path, HEADER + PAINT + sky + FLOOR).sky is not None


def test_no_surface(tmp_path):
    assert "no surface" in only(faults(tmp_path, HEADER))


def test_closed_room_that_absorbs_nothing(tmp_path):
    text = HEADER + PAINT.replace("0.5", "1.0") + LAMP + BOX
    assert "light would grow without end" in only(faults(tmp_path, text))
    assert faults(tmp_path, text + 'omit = ["top"]\n') == []
    assert faults(tmp_path, HEADER + PAINT.replace("0.5", "0.99") + LAMP + BOX) == []


def test_closed_room_of_rectangles_that_absorbs_nothing_in_one_band(tmp_path):
    steps = PAINT.replace("0.5", "{ steps = [[380, 600, 0.5], [600, 610, 1.0], [610, 780, 0.5]] }")
    room = "[[polygon]]\nvertices = [[0,0,0], [1,0,0], [1,1,0], [0,1,0], [0,0,1], [1,0,1], [1,1,1], [0,1,1]]\n"
    faces = "faces = [[0,1,2,3], [7,6,5,4], [4,5,1,0], [5,6,2,1], [6,7,3,2], [7,4,0,3]]\n"
    text = HEADER + steps + LAMP + room + faces + 'material = "paint"\nluminaire = "lamp"\n'
    assert "at 605 nm: light would grow without end" in only(faults(tmp_path, text))


def test_flux_of_a_spectrum_that_nobody_sees(tmp_path):
    text = INFRARED.replace("absolute = true", "luminous_flux_lm = 1")
    assert "no power that is visible" in only(faults(tmp_path, text))


def test_flux_of_a_spectrum_outside_all_bands(tmp_path):
    text = INFRARED.replace("absolute = true", "radiant_flux_W = 1")
    assert "no power in any band" in only(faults(tmp_path, text))


def test_flux_for_no_area(tmp_path):
    text = OPEN_ROOM.replace("absolute = true", "luminous_flux_lm = 100")
    found = faults(tmp_path, text.replace("edge_v = [1.0, 0.0, 0.0]", "edge_v = [0.0, 0.0, 0.0]"))
    assert any("without area" in fault for fault in found)


def test_exitance_of_a_point(tmp_path):
    text = OPEN_ROOM.replace("absolute = true", "radiant_exitance_W_m2 = 3") + POINT
    assert "has no area" in only(faults(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (OPEN_ROOM + FLOOR, "a second object named 'floor'"),
        (OPEN_ROOM + PAINT, "twice"),
        (OPEN_ROOM + 2 * SENSOR, "a second sensor"),
        (OPEN_ROOM + 2 * VIEW, "a second view"),
        (OPEN_ROOM + 2 * POINT, "a second point source"),
    ],
)
def test_duplicate_names(tmp_path, text, expected):
    assert expected in only(faults(tmp_path, text))


@pytest.mark.parametrize(
    ("sensor", "expected"),
    [
        ('kind = "points"\npositions = [[0, 0, 1]]\nnormal = [0, 0, 0]', "sensor[0].normal: [0, 0, 0] has no"),
        ('kind = "points"\npositions = [[0, 0, 1], [1, 0, 1]]\nnormals = [[0, 0, 1]]', "1 directions for 2 positions"),
        ('kind = "points"\npositions = [[0, 0, 1]]\nnormals = [[0, 0, 0]]', "has no direction"),
        ('kind = "points"\npositions = []\nnormal = [0, 0, 1]', "at least 1"),
        ('kind = "grid"\ncorner = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 1, 0]\ncounts = [0, 3]', "equal to 1"),
        ('kind = "grid"\ncorner = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [2, 0, 0]\ncounts = [3, 3]', "span no area"),
        ('kind = "surface"\nobject = "flor"\ncounts = [3, 3]', "did you mean 'floor'?"),
        ('kind = "surface"\nobject = "floor"\nface = "top"\ncounts = [3, 3]', "has no face 'top'"),
        ('kind = "surface"\nobject = "floor"\nspacing = 0.001', "8e+06 points"),
        ('kind = "surface"\nobject = "floor"\nspacing = 1e-300', "points; 1000000 at most"),
        ('kind = "surface"\nobject = "floor"', "exactly one of counts, spacing"),
        ('kind = "eye"\npositions = [[0, 0, 1]]\ntarget = [0, 0, 1]', "has no direction"),
    ],
)
def test_sensors(tmp_path, sensor, expected):
    assert expected in only(faults(tmp_path, OPEN_ROOM + f'[[sensor]]\nname = "s"\n{sensor}\n'))


@pytest.mark.parametrize(
    ("view", "expected"),
    [
        ("direction = [0, 0, 0]", "view[0].direction: [0, 0, 0] has no direction"),
        ("target = [0, 0, 1]", "view[0].target: [0, 0, 0] has no direction"),
        ("direction = [0, 1, 0]\nup = [0, 2, 0]", "along the line of sight"),
        ("direction = [0, 1, 0]\nfield_of_view_deg = 180", "less than 180"),
        ("direction = [0, 1, 0]\nsize = [0, 10]", "greater than or equal to 1"),
        ("", "exactly one of target, direction"),
    ],
)
def test_views(tmp_path, view, expected):
    assert expected in only(faults(tmp_path, OPEN_ROOM + f'[[view]]\nname = "v"\nposition = [0, 0, 1]\n{view}\n'))


def test_unit_that_looks_wrong(tmp_path):
    text = OPEN_ROOM.replace("edge_u = [4.0, 0.0, 0.0]", "edge_u = [4000.0, 0.0, 0.0]")
    assert "looks like mm" in only(warnings(load(tmp_path, text)))
    assert "is the unit right" in only(warnings(load(tmp_path, OPEN_ROOM.replace('"m"', '"mm"'))))

"""Cases 49 and 57 to 59: effects that are not simulated are refused by name, wherever a user may ask for them."""

import pytest
import scene_writing
from rooms import cube
from truths import uploaded

from hradiosity.cli import main
from hradiosity.readings.path_scene import prepare_referee
from hradiosity.readings.paths import PathTotals, trace_round

TABLES = {
    49: {
        "the sun": ("[sun]\nazimuth = 180.0\naltitude = 5.0\n", "[[sun]]\naltitude = 5.0\n"),
        "daylight other than a uniform sky": ("[daylight]\nlatitude = 50.0\n",),
        "a sky other than the uniform one": (
            '[sky]\nkind = "clear"\nspectrum = { illuminant = "D65" }\nilluminance_lx = 1e4\n',
            '[sky]\nkind = "perez"\nspectrum = { illuminant = "D65" }\nilluminance_lx = 1e4\n',
        ),
    }
}
KEYS = {
    57: {
        "fluorescence": (
            "fluorescence = { excitation = [300, 380], emission = [500, 600], yield = 1.2 }",
            'donaldson = { file = "paint.csv" }',
            "fluorescent = true",
        ),
    },
    58: {
        "transmission of light": ("transmittance = 1.0", "transmission = 0.5", "translucent = true", "opacity = 0.5"),
        "glass": ("glass = true", "refractive_index = 1.5", "ior = 1.5"),
    },
    59: {
        "mirror or glossy reflection": ("specular = 0.9", "specularity = 0.9"),
        "mirror reflection": ("mirror = true",),
        "glossy reflection": ("roughness = 0.1", "gloss = 0.3"),
    },
}


def cases(table):
    return [
        pytest.param(effect, text, id=f"{number}-{text.split()[0].strip('[]')}{i}")
        for number, effects in table.items()
        for effect, texts in effects.items()
        for i, text in enumerate(texts)
    ]


def assert_refused(found, effect):
    """One fault, which names the effect and says that it is not there yet, with its line."""
    assert len(found) == 1, found
    assert f"{effect} is not simulated by this version" in found[0]
    assert "unknown key" not in found[0]
    assert "scene.toml:" in found[0]


@pytest.mark.parametrize(("effect", "text"), cases(TABLES))
def test_case_49_the_sun_is_refused(tmp_path, effect, text):
    assert_refused(scene_writing.faults(tmp_path, scene_writing.OPEN_ROOM + text), effect)


@pytest.mark.parametrize(("effect", "key"), cases(KEYS))
def test_case_57_58_59_materials_that_are_not_simulated_are_refused(tmp_path, effect, key):
    text = scene_writing.OPEN_ROOM.replace("reflectance = 0.5", f"reflectance = 0.5\n{key}")
    assert_refused(scene_writing.faults(tmp_path, text), effect)


@pytest.mark.parametrize("key", ["kind", "type", "model"])
@pytest.mark.parametrize(
    ("word", "effect"), [("mirror", "mirror reflection"), ("glass", "glass"), ("fluorescent", "fluorescence")]
)
def test_case_57_58_59_kinds_of_material_are_refused(tmp_path, key, word, effect):
    text = scene_writing.OPEN_ROOM.replace("reflectance = 0.5", f'reflectance = 0.5\n{key} = "{word}"')
    assert_refused(scene_writing.faults(tmp_path, text), effect)


@pytest.mark.parametrize("form", ["{ mirror = 0.9 }", '{ donaldson = "paint.csv" }', "{ transmittance = 0.3 }"])
def test_case_57_58_59_forms_of_reflectance_are_refused(tmp_path, form):
    text = scene_writing.OPEN_ROOM.replace("reflectance = 0.5", f"reflectance = {form}")
    (found,) = scene_writing.faults(tmp_path, text)
    assert "is not simulated by this version" in found


def test_case_49_57_58_59_all_at_once_and_without_a_traceback(tmp_path, capsys):
    """Every effect is named in one go, by the program too, with status 2."""
    keys = "reflectance = 0.5\nfluorescence = true\ntransmittance = 1.0\nmirror = true"
    file = scene_writing.write(
        tmp_path, scene_writing.OPEN_ROOM.replace("reflectance = 0.5", keys) + "[sun]\naltitude = 5.0\n"
    )
    assert main(["check", str(file)]) == 2
    said = capsys.readouterr().err
    for effect in ("fluorescence", "transmission of light", "mirror reflection", "the sun"):
        assert f"{effect} is not simulated by this version" in said
    assert "Traceback" not in said


def test_case_59_weight_left_at_the_cap_of_bounces_is_a_bound(device):
    """Facing surfaces of ρ = 0.999: what a path still carries when it is given up is ρ to the power of its bounces."""
    room = cube(0.999)
    room.lamp(5, 1.0)
    room.sensor((0.5, 0.5, 0.5), (0, 0, 1))
    scene = room.scene()
    (sensor,) = scene.sensors
    totals = PathTotals(1, 1)
    prepared = prepare_referee(uploaded(scene, device), scene)
    sums = trace_round(prepared, sensor.position, sensor.normal, first_path=0, n_paths=256, seed=0, depth_limit=3)
    totals.add(sums, 256)
    assert totals.samples().lost_weight == pytest.approx(0.999**3, rel=1e-5)

"""A picture on a surface counts with its mean in linear light, as a guess, and only when that was asked for."""

import base64
import io

import numpy as np
import pytest
from PIL import Image
from scene_writing import HEADER, LAMP, PAINT, PANEL, faults, load, warnings
from test_meshes import as_glb, as_gltf, gltf_document

from hradiosity.io.mesh.gltf import read_gltf
from hradiosity.io.mesh.obj import read_obj
from hradiosity.io.mesh.raw import Texture
from hradiosity.io.mesh.texture import mean_colour
from hradiosity.metrics.upsampling import upsample_rgb
from hradiosity.model.spectrum import band_mean

# Texels of 0 and 1 stay 0 and 1 when decoded; the encoded 188/255 is 0.5029 in linear light and no half of 255.
CHECKER = np.array([[[255, 0, 188], [0, 0, 188]], [[255, 255, 188], [255, 0, 188]]], dtype=np.uint8)
GREY_188 = ((188 / 255 + 0.055) / 1.055) ** 2.4
MEAN = np.array([0.75, 0.25, GREY_188])

SHEET = "mtllib sheet.mtl\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nusemtl wood\nf 1 2 3 4\n"
MESH = '[[mesh]]\nname = "sheet"\nfile = "{file}"\nunit = "m"\nup = "z"\n'
UPSAMPLE = 'upsample = "mallett2019"\n'


def encoded(pixels, form="PNG", mode=None):
    stream = io.BytesIO()
    image = Image.fromarray(pixels)
    (image.convert(mode) if mode else image).save(stream, form)
    return stream.getvalue()


def scene_text(file="sheet.obj", more=UPSAMPLE):
    return HEADER + PAINT + LAMP + PANEL + MESH.format(file=file) + more


def obj_scene(folder, picture="wood.png", options="", factor=""):
    (folder / "sheet.obj").write_text(SHEET)
    (folder / "sheet.mtl").write_text(f"newmtl wood\n{factor}map_Kd {options}{picture}\n")
    return scene_text()


def guessed(scene):
    """The only guessed material, and whether the sheet has it."""
    (material,) = [material for material in scene.materials if not material.measured]
    sheet = scene.objects.index(next(name for name in scene.objects if name.startswith("sheet")))
    used = set(scene.patches.material[scene.patches.object == sheet].tolist())
    assert used == {scene.materials.index(material)}
    return material


def assert_mean(scene, mean):
    expected = band_mean(upsample_rgb(mean), scene.bands, "hold").value
    np.testing.assert_allclose(guessed(scene).reflectance, expected, atol=2e-9)


def test_mean_is_taken_in_linear_light(tmp_path):
    text = obj_scene(tmp_path)
    (tmp_path / "wood.png").write_bytes(encoded(CHECKER))
    scene = load(tmp_path, text)
    assert_mean(scene, MEAN)
    assert guessed(scene).name == "sheet/wood"
    (message,) = [line for line in warnings(scene) if "wood" in line]
    for part in ("mesh[0]", "'wood.png'", "0.750 0.250 0.503", "whole picture", "not measured", "mallett2019"):
        assert part in message


def test_factor_of_the_material_multiplies_it(tmp_path):
    text = obj_scene(tmp_path, factor="Kd 0.5 1.0 0.2\n")
    (tmp_path / "wood.png").write_bytes(encoded(CHECKER))
    assert_mean(load(tmp_path, text), MEAN * [0.5, 1.0, 0.2])


def mean_of(picture):
    return mean_colour(Texture("wood.png", picture))


@pytest.mark.parametrize("mode", ["P", "RGBA", "L"])
def test_other_kinds_of_picture(mode):
    grey = np.repeat(CHECKER[:, :, :1], 3, axis=2)
    np.testing.assert_allclose(mean_of(encoded(grey, mode=mode)), np.full(3, 0.75), rtol=1e-12)


def test_sixteen_bits():
    picture = encoded(np.array([[65535, 0], [0, 188 * 257]], dtype=np.uint16))
    np.testing.assert_allclose(mean_of(picture), np.full(3, (1 + GREY_188) / 4), rtol=1e-12)


@pytest.mark.parametrize(
    ("written", "name"),
    [
        ("wood.png", "wood.png"),
        ("-s 2 2 1 -o 0.5 0 0 -clamp on grain of wood.png", "grain of wood.png"),
        ("-mm 0 1 -s 2 -blendu on tex\\oak 2.png", "tex\\oak 2.png"),
        ("-s 1 2 3", "3"),
    ],
)
def test_options_before_the_name_of_a_texture(tmp_path, written, name):
    obj_scene(tmp_path, picture=written)
    texture = read_obj(tmp_path / "sheet.obj").labels[0].texture
    assert texture.name == name
    assert texture.source == tmp_path / name.replace("\\", "/")


def gltf_texture(image, factor=None, more=b""):
    """Document of one textured material, and its buffer with the bytes of an embedded picture at the end."""
    root, data = gltf_document([{"name": "sheet", "mesh": 0}])
    surface = root["materials"][0]["pbrMetallicRoughness"]
    if factor:
        surface["baseColorFactor"] = factor
    root |= {"textures": [{"source": 0}], "images": [image]}
    root["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": len(more)})
    return root, data + more


@pytest.mark.parametrize("place", ["glb", "data", "file"])
def test_pictures_of_gltf(tmp_path, place):
    picture = encoded(CHECKER)
    uri = {"data": "data:image/png;base64," + base64.b64encode(picture).decode(), "file": "my%20wood.png"}
    (tmp_path / "my wood.png").write_bytes(picture)
    image = {"bufferView": 2, "mimeType": "image/png"} if place == "glb" else {"uri": uri[place]}
    document = gltf_texture(image, [0.8, 0.4, 1.0, 1.0], picture)
    name = "sheet.glb" if place == "glb" else "sheet.gltf"
    content = as_glb(*document) if place == "glb" else as_gltf(*document).encode()
    (tmp_path / name).write_bytes(content)
    scene = load(tmp_path, scene_text(name))
    assert_mean(scene, MEAN * [0.8, 0.4, 1.0])
    assert ("'my wood.png'" if place == "file" else "'image 0'") in warnings(scene)[0]


def test_a_paint_that_is_named_goes_before_the_picture(tmp_path):
    """And then the picture may be missing."""
    scene = load(tmp_path, obj_scene(tmp_path) + 'materials = { wood = "paint" }\n')
    assert [material.name for material in scene.materials] == ["paint"]
    assert "one reflectance stands for it" in warnings(scene)[0]


def test_without_upsample_it_is_refused(tmp_path):
    text = obj_scene(tmp_path).replace(UPSAMPLE, 'material = "paint"\n')
    (found,) = faults(tmp_path, text)
    assert "'wood' in sheet.obj has a texture" in found and "or `upsample`" in found


@pytest.mark.parametrize("content", [None, encoded(CHECKER)[:-30]], ids=["missing", "cut"])
def test_pictures_that_cannot_be_read_name_file_and_entry(tmp_path, content):
    text = obj_scene(tmp_path)
    if content is not None:
        (tmp_path / "wood.png").write_bytes(content)
    (found,) = faults(tmp_path, text)
    for word in ("scene.toml", "mesh[0]", "wood.png", "'wood' in sheet.obj", "damaged" if content else "no file"):
        assert word in found


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"no picture at all",
        b"\x89PNG\r\n\x1a\n" + bytes(100),
        encoded(CHECKER)[:40],
        encoded(np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8), "JPEG")[:1500],
    ],
    ids=["empty", "text", "PNG of zeros", "cut PNG", "cut JPEG"],
)
def test_damaged_pictures(content):
    with pytest.raises(ValueError, match="damaged, or of a format"):
        mean_of(content)


@pytest.mark.parametrize(
    "image", [{"bufferView": 9}, {"uri": "data:image/png;base64,!"}, {}, {"bufferView": 2}], ids=str
)
def test_wrong_descriptions_of_a_picture(tmp_path, image):
    """They do no harm to the mesh, but give no colour."""
    (tmp_path / "sheet.gltf").write_text(as_gltf(*gltf_texture(image)))
    (label,) = read_gltf(tmp_path / "sheet.gltf").labels
    with pytest.raises(ValueError, match=r"no picture|damaged"):
        mean_colour(label.texture)


def test_a_factor_above_one(tmp_path):
    text = obj_scene(tmp_path, factor="Kd 2 1 1\n")
    (tmp_path / "wood.png").write_bytes(encoded(CHECKER))
    (found,) = faults(tmp_path, text)
    assert "1.500 0.250 0.503" in found


def test_two_meshes_keep_their_own_pictures(tmp_path):
    """Equal names of mesh and material, other colours."""
    text = obj_scene(tmp_path)
    (tmp_path / "wood.png").write_bytes(encoded(CHECKER))
    document = gltf_texture({"uri": "black.png"})
    document[0]["materials"][0]["name"], document[0]["nodes"][0]["name"] = "wood", "other"
    (tmp_path / "black.png").write_bytes(encoded(np.zeros((2, 2, 3), np.uint8)))
    (tmp_path / "b.gltf").write_text(as_gltf(*document))
    scene = load(tmp_path, text + MESH.format(file="b.gltf") + UPSAMPLE)
    assert [material.name for material in scene.materials] == ["paint", "sheet/wood", "sheet/wood'"]
    assert scene.materials[2].reflectance.max() < 1e-9

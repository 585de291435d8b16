"""Pictures keep numbers and texts; places that can't be written are told."""

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from hradiosity.errors import OutputError
from hradiosity.show.files import png_bytes, write_bytes, write_exr


def test_png_keeps_pixels_and_texts(tmp_path):
    pixels = np.random.default_rng(1).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    write_bytes(tmp_path / "a.png", png_bytes(pixels, {"units": "cd/m²"}))
    with Image.open(tmp_path / "a.png") as image:
        assert image.text["units"] == "cd/m²"
        np.testing.assert_array_equal(np.asarray(image), pixels)


def test_exr_keeps_floats_beyond_one(tmp_path):
    values = np.array([[0.0, 1e-6, 12345.678]], np.float32)
    write_exr(tmp_path / "a.exr", {"illuminance": values}, {"units": "lx"})
    file = OpenEXR.File(str(tmp_path / "a.exr"))
    np.testing.assert_array_equal(file.channels()["illuminance"].pixels, values)
    assert file.header()["units"] == "lx"


def test_places_that_can_not_be_written(tmp_path):
    with pytest.raises(OutputError, match="can't be written: No such file"):
        write_bytes(tmp_path / "nowhere" / "a.png", b"x")
    with pytest.raises(OutputError, match="can't be written"):
        write_exr(tmp_path / "nowhere" / "a.exr", {"Y": np.zeros((2, 2))}, {})

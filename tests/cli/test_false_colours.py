"""False colours as the command line asks for them: each colour stands for the number that the EXR file has there."""

import json

import numpy as np
import OpenEXR
import pytest
from cli_room import PICTURES, VIEW
from PIL import Image

from hradiosity.show.colormap import colours_of


@pytest.fixture
def drawn(room, call, tmp_path):
    def draw(*words):
        file = room / "scene.toml"
        file.write_text(file.read_text() + VIEW)
        outcome = call("render", room, "-o", tmp_path / "out", "--no-audit", *PICTURES, *words)
        assert outcome.code == 0, outcome.err
        folder = tmp_path / "out" / "pictures"
        record = json.loads((folder / "pictures.json").read_text())["false_color"]
        values = OpenEXR.File(str(folder / "door_false-color.exr")).channels()[record["quantity"]].pixels
        return record, values.astype(float), np.asarray(Image.open(folder / "door_false-color.png"))[:, :40].astype(int)

    return draw


def test_logarithmic_luminance_in_a_range(drawn):
    record, values, pixels = drawn(
        *("--false-color", "luminance", "--false-color-scale", "log", "--false-color-range", 2, 200)
    )
    assert record == {"quantity": "luminance", "unit": "cd/m²", "low": 2.0, "high": 200.0, "logarithmic": True}
    wanted = colours_of(np.log10(np.clip(values, 2, 200) / 2) / 2)  # two decades
    assert np.abs(pixels - 255 * wanted).max() <= 1.0
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 20


def test_logarithmic_ends_from_the_picture(drawn):
    record, values, _ = drawn("--false-color-scale", "log")
    assert (record["quantity"], record["unit"], record["logarithmic"]) == ("illuminance", "lx", True)
    assert ((values > record["low"]) & (values < record["high"])).mean() > 0.9
    assert 10.0 <= record["high"] / record["low"] <= 1000.0


def test_linear_unless_asked(drawn):
    record, values, pixels = drawn()
    assert (record["low"], record["logarithmic"]) == (0.0, False)
    assert np.abs(pixels - 255 * colours_of(np.clip(values / record["high"], 0, 1))).max() <= 1.0


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (("--false-color-range", 200, 2), "the lower number first"),
        (("--false-color-range", 0, 100, "--false-color-scale", "log"), "above 0"),
        (("--false-color-range", "nan", 100), "no range"),
        (("--false-color-scale", "cubic"), "log"),
        (("--false-color", "radiance"), "luminance"),
    ],
)
def test_ranges_that_are_none(room, call, tmp_path, words, part):
    outcome = call("render", room, "-o", tmp_path / "out", *words)
    assert outcome.code == 2
    assert part in " ".join((outcome.out + outcome.err).replace("│", " ").split())
    assert not (tmp_path / "out.partial").exists()

"""``hradiosity render --quality image`` from end to end."""

import json

import numpy as np
import OpenEXR
import pytest
from cli_room import PICTURES, QUICK, VIEW

from hradiosity.cli import INTERRUPTED
from hradiosity.device import Device
from hradiosity.io.calibration import store_image_pace
from hradiosity.show import image


@pytest.fixture
def render(room, call, tmp_path):
    def run(*words):
        file = room / "scene.toml"
        file.write_text(file.read_text() + VIEW)
        return call("render", room, "-o", tmp_path / "out", "--no-audit", "--quality", "image", *PICTURES, *words)

    return run


def test_images_take_the_place_of_pictures_of_the_model(render, tmp_path):
    outcome = render("--image-samples", 8, "--image-spectra", "--image-size", 32, 20, "--white", "lamps")
    assert outcome.code == 0, outcome.err
    folder = tmp_path / "out" / "pictures"
    names = {f"door_image{end}" for end in (".png", ".exr", ".hdr", "_false-color.png", "_spectral.exr")}
    assert {path.name for path in folder.iterdir()} == names | {"pictures.json"}
    luminance = OpenEXR.File(str(folder / "door_image.exr"), separate_channels=True).channels()["Y"].pixels
    assert luminance.shape == (20, 32) and (luminance > 0).all()
    entry = json.loads((folder / "pictures.json").read_text())["pictures"][0]
    assert (entry["kind"], entry["samples"]) == ("image", 8) and 0 < entry["noise_median"] < entry["noise_95"] < 0.5
    assert "Images" in outcome.out and "CPU s" in outcome.out
    assert json.loads((tmp_path / "out" / "run.json").read_text())["state"] == "complete"


def test_points_are_added_until_the_noise_is_as_asked(render, call, room, tmp_path):
    outcome = render("--image-noise", "0.5%", "--image-size", 32, 20)
    assert outcome.code == 0, outcome.err
    assert "until the noise is 0.5 %" in outcome.out and "not reached" not in outcome.out
    record = json.loads((tmp_path / "out" / "pictures" / "pictures.json").read_text())
    entry = record["pictures"][0]
    assert record["noise_asked_for"] == 0.005 and entry["noise_median"] <= 0.005
    assert 16 < entry["samples"] < 1024 and entry["complete"]
    words = ("--quality", "image", "--image-noise", "0.1%", "--image-samples", 24, "--image-size", 32, 20)
    outcome = call("render", room, "-o", tmp_path / "out", "--no-audit", *words, *PICTURES)
    entry = json.loads((tmp_path / "out" / "pictures" / "pictures.json").read_text())["pictures"][0]
    assert outcome.code == 0 and entry["samples"] == 24 and entry["noise_median"] > 0.001
    assert "noise of 0.1 % was not reached" in outcome.out


def test_a_plan_foresees_images_once_one_was_made(room, call, tmp_path, monkeypatch):
    file = room / "scene.toml"
    file.write_text(file.read_text() + VIEW)
    monkeypatch.setenv("HRADIOSITY_CACHE", str(tmp_path / "cache"))
    outcome = call("plan", room, "--quality", "image")
    assert "images: 1, 0.0012 million pixels with 16 points each: seconds unknown" in outcome.out
    store_image_pace(Device().description, 1e-3)
    outcome = call("plan", room, "--quality", "image")
    # 40 x 30 pixels, 16 points, nine bands in two groups of eight.
    assert "about 38 s" in outcome.out
    assert "images:" not in call("plan", room).out


def test_an_interrupted_image_loses_nothing(render, tmp_path, monkeypatch):
    passes = []

    def interrupting(*arguments, original=image.trace_pass):
        passes.append(1)
        if len(passes) == 4:
            raise KeyboardInterrupt
        return original(*arguments)

    monkeypatch.setattr(image, "trace_pass", interrupting)
    outcome = render("--image-samples", 4)
    assert outcome.code == INTERRUPTED
    entry = json.loads((tmp_path / "out" / "pictures" / "pictures.json").read_text())["pictures"][0]
    assert (entry["samples"], entry["complete"]) == (3, False)
    assert np.loadtxt(tmp_path / "out" / "spectra.csv", delimiter=",", skiprows=1, usecols=2).size


def test_what_only_images_have(room, call, tmp_path):
    outcome = call("render", room, "-o", tmp_path / "out", "--image-samples", 8, *QUICK)
    assert outcome.code == 2 and "--quality image" in outcome.err
    outcome = call(
        "render", room, "-o", tmp_path / "out", "--quality", "image", "--image-samples", 0, "--image-size", 0, 5
    )
    assert outcome.code == 2 and "at most 1024, is 0" in outcome.err and "0 5 is no size" in outcome.err
    outcome = call("render", room, "-o", tmp_path / "out", "--quality", "image", "--image-samples", 99999999)
    assert outcome.code == 2 and "at most 1024, is 99999999" in outcome.err

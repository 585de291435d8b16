"""The HTML page stands alone and holds the numbers of the result."""

import base64
import json
import re
import shutil
import subprocess
import zlib

import numpy as np
import pytest

from hradiosity.io.scene_drawing import draw_scene
from hradiosity.show.window.look import Look
from hradiosity.show.window.navigation import overview
from hradiosity.show.window.page import page_bytes, page_data
from hradiosity.show.window.subject import Choices, Subject
from hradiosity.show.window.vertices import swollen

POSE = overview(np.zeros(3), np.array([3.0, 2.0, 2.5]), 1.5)
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def unpacked(text, dtype):
    return np.frombuffer(zlib.decompress(base64.b64decode(text)), np.dtype(dtype).newbyteorder("<"))


@pytest.fixture
def page(subject):
    return page_bytes(subject, Look(mode="false-color"), POSE, "</script><b>room</b>").decode()


def test_nothing_comes_from_elsewhere(page):
    assert not re.search(r"https?:|//[a-z]+\.|\bsrc\s*=|\bhref\s*=|@import|\bimport\b|url\(|fetch\(", page)


def test_names_of_the_user_can_t_end_the_script(page):
    assert page.count("</script>") == 1
    data = json.loads(re.search(r"const DATA = (.*);\n", page)[1])
    assert data["title"] == "</script><b>room</b>"


def test_the_page_holds_the_result(subject):
    data = page_data(subject, Look(), POSE, "room")
    cells, values = subject.cells, subject.values
    assert data["count"] == len(cells) and not data["lines"]
    np.testing.assert_allclose(unpacked(data["position"], "f4"), swollen(cells).ravel(), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(
        unpacked(data["values"]["illuminance"], "f4"), values.smooth.illuminance.ravel(), rtol=1e-6
    )
    shares = unpacked(data["elements"]["spectra"], "u2").reshape(-1, len(subject.drawn.words.bands))
    spectra = shares / 65535.0 * unpacked(data["elements"]["top"], "f4")[:, None]
    expected = subject.drawn.light.irradiance / subject.drawn.words.bands.width
    np.testing.assert_allclose(spectra, expected, atol=1e-5 * expected.max())
    np.testing.assert_array_equal(
        unpacked(data["colours"]["flat"], "u1"), subject.paint(Look(mode="flat")).colours.ravel()
    )
    sensors = subject.drawn.sensors
    lux = unpacked(data["sensors"]["lux"], "f4")
    np.testing.assert_allclose(lux[~sensors.looks], sensors.numbers["illuminance_lx"][~sensors.looks], rtol=1e-6)


def test_a_scene_makes_a_page_too(room):
    page = page_bytes(Subject(draw_scene(room), Choices()), Look(lines=0), POSE, "room").decode()
    data = json.loads(re.search(r"const DATA = (.*);\n", page)[1])
    assert not data["solved"] and data["lines"]
    assert len(data["sensors"]["names"]) == 8


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_a_browser_draws_it_from_the_file(page, tmp_path):
    from PIL import Image

    file, picture = tmp_path / "room.html", tmp_path / "room.png"
    file.write_text(page, encoding="utf-8")
    subprocess.run(
        [
            *(CHROMIUM, "--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"),
            *("--enable-unsafe-swiftshader", "--window-size=800,600", "--virtual-time-budget=8000"),
            *(f"--user-data-dir={tmp_path / 'profile'}", f"--screenshot={picture}", file.as_uri()),
        ],
        check=True,
        timeout=120,
        capture_output=True,
    )
    pixels = np.asarray(Image.open(picture).convert("RGB")).reshape(-1, 3)
    ground = np.abs(pixels.astype(int) - [33, 36, 41]).max(axis=1) <= 2
    assert 0.1 < np.mean(~ground) < 0.95, "the room stands on the ground"
    assert len(np.unique(pixels, axis=0)) > 200

"""UGR of a whole room beside another program's: Radiance's ``rpict`` and ``evalglare``.

A room of 8 × 4 × 3.2 m (reflectances 0.7, 0.5, 0.2) with eight panels of 0.6 × 0.6 m and 3000 lm, rendered as fisheye
pictures of 900 × 900 pixels (``-ab 7 -ad 400 -as 100 -aa 0.15 -ar 64 -ds 0.15 -dt 0``) and rated with
``evalglare -b 1000 -r 0.01``. Its numbers stand below; its pixels are a fifth of a degree wide, which is one percent of
a panel's solid angle and position index. It takes no position index above 16, where the table of CIE 117 ends.
"""

import numpy as np
import pytest

from hradiosity.io.scene_toml import load_scene
from hradiosity.metrics.glare import glare_sum, unified_glare_rating
from hradiosity.options import Options
from hradiosity.radiosity import solve
from hradiosity.readings.glare import rate_glare

OBSERVERS = (
    ((0.01, 2, 1.2), (1, 0, 0)),
    ((4, 0.01, 1.2), (0, 1, 0)),
    ((2.5, 1, 1.2), (1, 0, 0)),
    ((0.01, 0.5, 1.2), (2, 1, 0)),
)
RATING = (19.197, 17.262, 17.376, 19.144)
BACKGROUND = (37.393, 37.634, 40.724, 37.279)
LUMINANCE = 2657.0
SOLID_ANGLE = (0.0018346, 0.0018346, 0.0043514, 0.0043514, 0.0138964, 0.0138964, 0.0492473, 0.0492473)
POSITION_INDEX = (1.7317, 1.7319, 2.2089, 2.2100, 3.7955, 3.8002, 16.0, 16.0)
LIMIT = 16.0

HEAD = """
[scene]
unit = "m"
[materials]
ceiling.reflectance = 0.7
wall.reflectance = 0.5
floor.reflectance = 0.2
lamp.reflectance = 0.0
[luminaires.panel]
spectrum = { constant = 1.0 }
luminous_flux_lm = 3000
[[box]]
name = "room"
corner = [0, 0, 0]
size = [8, 4, 3.2]
inside = true
material = "wall"
faces = { top = "ceiling", bottom = "floor" }
"""


@pytest.fixture(scope="module")
def rated(tmp_path_factory, device):
    text = HEAD
    for number, (x, y) in enumerate((x, y) for x in (1, 3, 5, 7) for y in (1, 3)):
        text += f"""
[[rectangle]]
name = "panel {number}"
corner = [{x - 0.3}, {y - 0.3}, 3.195]
edge_u = [0, 0.6, 0]
edge_v = [0.6, 0, 0]
material = "lamp"
luminaire = "panel"
"""
    for number, (place, gaze) in enumerate(OBSERVERS):
        text += f"""
[[sensor]]
name = "{number}"
kind = "eye"
positions = [{list(place)}]
gaze = {list(gaze)}
glare = true
"""
    file = tmp_path_factory.mktemp("glare") / "scene.toml"
    file.write_text(text)
    solution = solve(load_scene(file), Options(elements=1200, rays_per_element=128, replicates=4), device)
    return rate_glare(solution, device)


def test_background_and_rating_are_those_of_the_other_program(rated):
    for number, (rating, background) in enumerate(zip(RATING, BACKGROUND, strict=True)):
        glare = rated[str(number)]
        assert glare.reason == ("",)
        assert glare.background[0] == pytest.approx(background, rel=0.015)
        sources = glare.sources
        index = np.minimum(sources.position_index, LIMIT)
        total = glare_sum(sources.luminance, sources.solid_angle, index).sum()
        assert unified_glare_rating(np.array([total]), glare.background)[0] == pytest.approx(rating, abs=0.08)
        assert rating - 0.45 < glare.ugr[0] < rating + 0.03, "panels above the limit count less by Guth's formula"


def test_panels_are_those_of_the_other_program(rated):
    """Of the first observer."""
    sources = rated["0"].sources
    np.testing.assert_allclose(sources.luminance, LUMINANCE, rtol=3e-3)
    np.testing.assert_allclose(np.sort(sources.solid_angle), SOLID_ANGLE, rtol=0.016)
    np.testing.assert_allclose(np.sort(np.minimum(sources.position_index, LIMIT)), POSITION_INDEX, rtol=0.01)

"""Whatever stands in a scene file, the answer is a scene or a list of faults."""

import copy
import tomllib

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scene_writing import OPEN_ROOM, faults

SCENE = tomllib.loads(
    OPEN_ROOM
    + """
[materials.stripes]
reflectance = { steps = [[380, 500, 0.1], [500, 780, 0.8]] }
[materials.library]
reflectance = { library = "cornell/red" }
[luminaires.lines]
spectrum = { lines = [[546.1, 1.0]] }
luminous_flux_lm = 10
[sky]
kind = "uniform"
spectrum = { blackbody_K = 6500 }
illuminance_lx = 5000
[[polygon]]
vertices = [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
faces = [[0, 1, 2, 3]]
material = "stripes"
[[box]]
centre = [2, 1, 1]
size = [1, 1, 1]
rotation_deg = 30
faces = { sides = "library" }
material = "paint"
luminaires = { top = "lines" }
[[point_source]]
position = [1, 1, 1]
luminaire = "lines"
[[sensor]]
name = "points"
kind = "points"
positions = [[0, 0, 1]]
normals = [[0, 0, 1]]
[[sensor]]
name = "grid"
kind = "grid"
corner = [0, 0, 0]
edge_u = [1, 0, 0]
edge_v = [0, 1, 0]
counts = [2, 2]
[[sensor]]
name = "surface"
kind = "surface"
object = "floor"
spacing = 0.5
[[view]]
name = "view"
position = [0, 0, 1]
target = [1, 1, 1]
"""
)

FLOATS = st.floats(-10, 10, allow_nan=False).map(lambda x: round(x, 3))
NUMBERS = st.integers(-2, 3) | FLOATS | st.sampled_from([1e300, -0.0])
WORDS = st.sampled_from(["", "floor", "paint", "lines", "grid", "sun", "m", "mm", "e\u0301", "both", "lamp", "D65"])
VALUES = st.recursive(
    st.booleans() | NUMBERS | WORDS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(WORDS, inner, max_size=2),
    max_leaves=6,
)


def places(value, path=()):
    """Path of everything inside a table."""
    if isinstance(value, dict):
        inside = value.items()
    elif isinstance(value, list):
        inside = enumerate(value)
    else:
        return [path]
    return [path, *(place for key, item in inside for place in places(item, (*path, key)))][bool(not path) :]


def toml(value):
    """A value in one line of TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f'"{key}" = {toml(item)}' for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml(item) for item in value) + "]"
    return f'"{value}"' if isinstance(value, str) else str(value).lower()


def written(scene):
    return "\n".join(f"{key} = {toml(value)}" for key, value in scene.items())


def test_the_whole_scene_is_valid(tmp_path):
    assert faults(tmp_path, written(SCENE)) == []


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.sampled_from(places(SCENE)), value=VALUES)
def test_any_value_anywhere(tmp_path, place, value):
    scene = copy.deepcopy(SCENE)
    inner = scene
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    for fault in faults(tmp_path, written(scene)):
        assert "scene.toml" in fault


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.sampled_from(places(SCENE)))
def test_anything_may_be_missing(tmp_path, place):
    scene = copy.deepcopy(SCENE)
    inner = scene
    for key in place[:-1]:
        inner = inner[key]
    del inner[place[-1]]
    for fault in faults(tmp_path, written(scene)):
        assert "scene.toml" in fault

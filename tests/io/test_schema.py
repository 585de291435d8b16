"""The JSON Schema agrees with what the program itself accepts; an independent validator judges."""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from scene_writing import LAMP, OPEN_ROOM, faults

from hradiosity.io.scene.schema import scene_json_schema

SCENES = sorted((Path(__file__).parents[2] / "scenes").glob("*/scene.toml"))
CONSTANT = "reflectance = 0.5"
AMOUNT = "absolute = true"


@pytest.fixture(scope="module")
def validator():
    schema = scene_json_schema()
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def is_valid(validator, text):
    return validator.is_valid(tomllib.loads(text))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.parent.name)
def test_shipped_scenes_are_valid(validator, path):
    validator.validate(tomllib.loads(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (CONSTANT, "reflectance = 0"),
        (CONSTANT, "reflectance = 1.0"),
        (CONSTANT, "reflectance = { steps = [[0, 500, 0.1], [500, 800, 1.0]] }"),
        (CONSTANT, 'reflectance = { rgb = [0, 0.5, 1], upsample = "mallett2019" }'),
        (AMOUNT, "luminous_flux_lm = 0.1"),
    ],
)
def test_what_both_accept(validator, tmp_path, old, new):
    text = OPEN_ROOM.replace(old, new, 1)
    assert is_valid(validator, text) and not faults(tmp_path, text)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (CONSTANT, "reflectance = 1.2"),
        (CONSTANT, "reflectance = -0.1"),
        (CONSTANT, "reflectance = { steps = [[380, 500, 0.1], [500, 780, 1.4]] }"),
        (CONSTANT, "reflectance = { steps = [[380, 500, -0.1]] }"),
        (CONSTANT, 'reflectance = { rgb = [0, 0.5, 1.1], upsample = "mallett2019" }'),
        (CONSTANT, "reflectance = { rgb = [0, 0.5, 1.0] }"),
        (AMOUNT, "luminous_flux_lm = 0"),
        (AMOUNT, "radiant_flux_W = -1"),
        (AMOUNT, "luminous_exitance_lm_m2 = -1"),
        (AMOUNT, "absolute = true\nradiant_flux_W = 1"),
        (AMOUNT, ""),
        ("{ constant = 1.0 }", "{ lines = [[546.1, -1]] }"),
        ("{ constant = 1.0 }", "{ blackbody_K = 0 }"),
        ('unit = "m"', 'unit = "m"\nbands = { edges = [-1, 500] }'),
        ('unit = "m"', 'unit = "m"\nbands = { step = 0 }'),
        (LAMP, LAMP + '[sky]\nkind = "uniform"\nspectrum = { constant = 1 }\n'),
        (LAMP, LAMP + '[[view]]\nname = "v"\nposition = [0, 0, 1]\ntarget = [1, 0, 1]\ndirection = [1, 0, 0]\n'),
    ],
)
def test_what_both_refuse(validator, tmp_path, old, new):
    text = OPEN_ROOM.replace(old, new, 1)
    assert text != OPEN_ROOM
    assert not is_valid(validator, text) and faults(tmp_path, text)


def test_the_verb_prints_it():
    command = [sys.executable, "-m", "hradiosity", "schema"]
    printed = subprocess.run(command, capture_output=True, check=True, text=True).stdout
    assert json.loads(printed) == scene_json_schema()

"""Variants of a scene file: read, solved with it, written beside it."""

import csv
import json

import numpy as np
import pytest
from cli_room import QUICK, ROOM

VARIANTS = """
[[variant]]
name = "dark walls"
[variant.materials]
wall = { factor = 0.5 }

[[variant]]
name = "dimmed"
[variant.luminaires]
lamp = { factor = 0.5 }

[[variant]]
name = "cool"
[variant.luminaires]
lamp = { illuminant = "D65" }
"""


def table(path):
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def column(rows, name):
    return np.array([float(row[name]) for row in rows])


@pytest.fixture
def compared(room, call, tmp_path):
    (room / "scene.toml").write_text(ROOM + VARIANTS)
    out = tmp_path / "out"
    outcome = call("render", room, "-o", out, *QUICK)
    assert outcome.code == 0, outcome.err
    return out, outcome


def test_folders_tables_and_words(compared):
    out, outcome = compared
    assert sorted(path.name for path in (out / "variants").iterdir()) == ["cool", "dark walls", "dimmed"]
    own = column(table(out / "readings.csv"), "illuminance_lx")
    for path in (out / "variants").iterdir():
        assert sorted(file.name for file in path.iterdir()) == ["differences.csv", "readings.csv", "spectra.csv"]
        rows = table(path / "differences.csv")
        lux = column(table(path / "readings.csv"), "illuminance_lx")
        np.testing.assert_allclose(column(rows, "illuminance_difference_lx"), lux - own, rtol=1e-6, atol=1e-6 * own[0])
        np.testing.assert_allclose(
            column(rows, "relative_illuminance_difference"), lux / own - 1.0, rtol=1e-6, atol=1e-6
        )
        assert (column(rows, "illuminance_difference_half_width_lx") >= 0.0).all()
    dimmed = table(out / "variants" / "dimmed" / "differences.csv")
    np.testing.assert_allclose(column(dimmed, "relative_illuminance_difference"), -0.5)
    dark = column(table(out / "variants" / "dark walls" / "differences.csv"), "illuminance_difference_lx")
    assert (dark < 0.0).all()
    assert "Differences of the variants" in outcome.out
    assert "dark walls" in outcome.out


def test_another_spectrum_has_the_same_lumens(compared):
    """In a room of one grey the illuminance would not change; here the walls are warm, so that it changes little."""
    out, _ = compared
    rows = table(out / "variants" / "cool" / "differences.csv")
    assert (np.abs(column(rows, "relative_illuminance_difference")) < 0.1).all()
    assert (column(rows, "cct_difference_k") > 2000.0).all()


def test_run_record(compared):
    out, _ = compared
    run = json.loads((out / "run.json").read_text())
    found = run["variants"]["dimmed"]["desk, left"]
    mean = run["sensors"]["desk, left"]["mean_illuminance_lx"]
    assert found["mean_illuminance_lx"] == pytest.approx(0.5 * mean)
    assert found["difference"]["mean_illuminance_lx"] == pytest.approx(-0.5 * mean)
    assert found["difference"]["relative_mean_illuminance"] == pytest.approx(-0.5)


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        ('name = "v"\nmaterials = { wal = 0.5 }', ("no material 'wal'", "did you mean 'wall'?")),
        ('name = "v"\nluminaires = { lmap = { factor = 0 } }', ("no luminaire 'lmap'", "did you mean 'lamp'?")),
        ('name = "v"\nmaterials = { wall = { factor = 2 } }', ("materials.wall", "a factor of 1.667 at most")),
        ('name = "v"\nmaterials = { wall = 50 }', ("it looks like percent: write 0.5",)),
        ('name = "v"\nmaterials = { wall = "white" }', ("{ factor = … }",)),
        ('name = "v"\nluminaires = { lamp = 0.5 }', ("{ factor = … }", "{ illuminant = … }")),
        ('name = "v"\nluminaires = { lamp = { factor = -1 } }', ("greater than or equal to 0",)),
        ('name = "v"', ("changes nothing",)),
        ('name = "../v"\nmaterials = { wall = 0.5 }', ("letters, digits",)),
        ('name = "v"\npaint = "wall"\nmaterials = { wall = 0.5 }', ("unknown key 'paint'",)),
        ('name = "v"\nmaterials = { wall = 1, floor = 1 }', ("reflect everything",)),
    ],
)  # fmt: skip
def test_mistakes(room, call, lines, told):
    (room / "scene.toml").write_text(f"{ROOM}\n[[variant]]\n{lines}\n")
    outcome = call("check", room)
    assert outcome.code == 2
    for part in told:
        assert part in outcome.err, outcome.err


def test_names_are_used_once(room, call):
    (room / "scene.toml").write_text(ROOM + 2 * "\n[[variant]]\nname = 'v'\nmaterials = { wall = 0.5 }\n")
    outcome = call("check", room)
    assert outcome.code == 2
    assert "a second variant named 'v'" in outcome.err


def test_resumed_with_its_variants(room, call, tmp_path):
    (room / "scene.toml").write_text(ROOM + VARIANTS)
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert call("render", room, "-o", whole, *QUICK, "--replicates", "4", "--no-audit").code == 0
    assert call("render", room, "-o", parts, *QUICK, "--replicates", "4", "--no-audit").code == 0
    assert call("render", room, "-o", parts, *QUICK, "--replicates", "4", "--no-audit", "--resume").code == 0
    for name in ("dimmed", "cool"):
        file = f"variants/{name}/differences.csv"
        assert (parts / file).read_bytes() == (whole / file).read_bytes()


def test_a_mended_copy_keeps_the_variants(room, call, tmp_path):
    spectrum = "wavelength_nm,reflectance\n380,0.2\n780,0.4\n"
    (room / "paint.csv").write_text(spectrum)
    text = ROOM + "\n[[variant]]\nname = 'v'\nmaterials = { wall = { file = 'paint.csv' } }\n"
    (room / "scene.toml").write_text(text)
    outcome = call("check", room, "--repair", tmp_path / "copy")
    assert outcome.code == 0, outcome.err
    assert call("check", tmp_path / "copy").code == 0

"""One command measures, keeps what it found, and compares two runs."""

import json
import platform
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hradiosity.io.scene_toml import load_scene
from hradiosity.model.spectrum import Bands
from hradiosity.suites.bench import figure, peer_radiance, peers, ratios, report, sections
from hradiosity.suites.bench.command import main
from hradiosity.suites.bench.figure import Figure, exact_figure, figure_of
from hradiosity.suites.bench.scenes import error_figures, scene_file
from hradiosity.suites.bench.session import Session
from hradiosity.suites.compare import Comparison


def a_report(*figures, **changes):
    made = report.make_report(figures, ["something was skipped"], device="a device", quick=False)
    return replace(made, **changes)


figures = st.builds(
    Figure,
    st.text(min_size=1),
    st.floats(0.0, 1e12),
    st.sampled_from(sorted(figure.WORDS)),
    st.none() | st.floats(0.0, 1e12),
)


@settings(max_examples=30)
@given(st.lists(figures, max_size=4))
def test_json_gives_back_the_same_run(found):
    made = a_report(*found)
    assert report.from_json(report.to_json(made)) == made


def test_a_run_tells_what_it_ran_on_and_not_whose_it_is():
    kept = json.loads(report.to_json(a_report()))
    assert {"python", "numpy", "pyopencl"} <= kept["versions"].keys()
    assert kept["machine"].keys() == {"processor", "cores", "system"}
    assert int(kept["machine"]["cores"]) > 0
    assert kept["date"].endswith("+00:00")
    text = json.dumps(kept)
    node = platform.node()
    assert not node or node not in text


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": 1}', '{"format": 1, "figures": [{"name": "a"}]}'])
def test_other_files_are_refused(text):
    with pytest.raises(ValueError):
        report.from_json(text)


def test_median_and_half_range():
    found = figure_of("a", [3.0, 1.0, 2.0, 9.0, 2.5], figure.CPU)
    assert (found.value, found.spread) == (2.5, 4.0)
    assert figure_of("a", [3.0], figure.CPU).spread is None


@pytest.mark.parametrize(
    ("unit", "old", "new", "spread", "verdict"),
    [
        (figure.CPU, 2.0, 1.0, 0.4, "faster"),
        (figure.CPU, 1.0, 2.0, 0.4, "slower"),
        (figure.CPU, 2.0, 1.0, 0.5, ratios.WITHIN),
        (figure.SPEED, 2.0, 1.0, 0.4, "slower"),
        (figure.SPEED, 1.0, 2.0, 0.4, "faster"),
        (figure.ERROR, 0.02, 0.01, 1e-3, "more accurate"),
        (figure.ERROR, 0.01, 0.02, 1e-3, "less accurate"),
        (figure.PRODUCTS, 10.0, 11.0, 0.0, "slower"),
        (figure.PRODUCTS, 10.0, 10.0, 0.0, ratios.WITHIN),
        (figure.CPU, 1.0, 2.0, None, ratios.ONCE),
    ],
)
def test_verdict(unit, old, new, spread, verdict):
    found = ratios.compare_figures(Figure("a", old, unit, spread), Figure("a", new, unit, spread))
    assert found.verdict == verdict
    assert found.ratio == new / old


def test_nothing_over_nothing():
    zero = exact_figure("a", 0.0, figure.ERROR)
    assert ratios.compare_figures(zero, zero).ratio == 1.0
    assert ratios.compare_figures(zero, exact_figure("a", 1e-9, figure.ERROR)).ratio == np.inf


def test_only_the_same_figures_are_compared():
    cpu, wall = Figure("a", 1.0, figure.CPU, 0.1), Figure("a", 3.0, figure.WALL, 0.1)
    other = Figure("b", 1.0, figure.CPU, 0.1)
    old, new = a_report(cpu, other), a_report(wall, replace(cpu, value=2.0), device="another")
    assert [(r.name, r.unit, r.ratio) for r in ratios.compare_reports(old, new)] == [("a", figure.CPU, 2.0)]
    told = ratios.differences(old, new)
    assert "device: a device → another" in told
    assert "only in the old run: b [CPU s]" in told
    with pytest.raises(ValueError, match="not the same"):
        ratios.compare_figures(cpu, wall)


@pytest.mark.parametrize("values", [{"unit": "h"}, {"value": np.nan}, {"value": np.inf}, {"spread": -1.0}])
def test_figures_are_checked(values):
    with pytest.raises(ValueError):
        replace(Figure("a", 1.0, figure.CPU, 0.0), **values)


def test_unknown_sections_are_all_named(capsys):
    assert main(["--only", "ray,solvers,sceens"]) == 2
    told = capsys.readouterr().err
    assert "'ray' is no section: did you mean 'rays'?" in told
    assert "'sceens' is no section: did you mean 'scenes'?" in told
    assert "Traceback" not in told


def test_sections_keep_their_order():
    assert sections.choose("solvers, rays") == ["rays", "solvers"]
    assert sections.choose(None) == list(sections.SECTIONS)


def test_a_cheap_section_and_its_comparison(tmp_path, capsys):
    kept = tmp_path / "run.json"
    assert main(["--only", "bvh", "--quick", "--out", str(kept)]) == 0
    found = report.from_json(kept.read_text(encoding="utf-8"))
    assert [f.unit for f in found.figures] == [figure.CPU, figure.WALL]
    assert all(0.0 < f.value < 60.0 and f.spread is not None for f in found.figures)
    assert found.quick
    capsys.readouterr()
    assert main(["--compare", str(kept), str(kept)]) == 0
    shown = capsys.readouterr().out
    assert shown.count("   1.000  within the spread") == 2


@pytest.mark.parametrize("text", [None, "{}", "no JSON"])
def test_files_that_cannot_be_compared(tmp_path, capsys, text):
    file = tmp_path / "run.json"
    if text is not None:
        file.write_text(text, encoding="utf-8")
    assert main(["--compare", str(file), str(file)]) == 2
    assert "run.json" in capsys.readouterr().err


def test_no_time_is_lost_for_a_file_that_cannot_be_written(tmp_path, capsys):
    assert main(["--only", "bvh", "--out", str(tmp_path / "none" / "run.json")]) == 2
    assert "is no folder" in capsys.readouterr().err


def test_a_missing_peer_is_told_once(device):
    session = Session(device)
    assert not session.has_peer("no_such_program")
    assert not session.has_peer("no_such_program")
    assert len(session.notes) == 1
    assert "hradiosity[bench]" in session.notes[0]


def test_help_as_a_module():
    done = subprocess.run(
        [sys.executable, "-m", "hradiosity.bench", "--help"], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0
    assert "--compare" in done.stdout


def test_joined_bands_hold_the_same_light():
    bands = Bands.uniform()
    joined = peers.join_bands(bands)
    assert (len(joined), joined.lower[0], joined.upper[-1]) == (20, bands.lower[1], bands.upper[-1])
    light = np.random.default_rng(1).random((3, len(bands)))
    np.testing.assert_allclose(peers.join_light(light).sum(axis=1), light[:, 1:].sum(axis=1), rtol=1e-12)


def test_errors_of_peers():
    bands = peers.join_bands(Bands.uniform())
    known = np.ones((2, len(bands)))
    lux, spectral = peers.errors(known * [[1.1], [0.9]], known, bands)
    assert (lux, spectral) == pytest.approx((0.1, 0.1))


def test_radiance_is_given_all_patches(device):
    scene = load_scene(scene_file(Session(device), "cornell_box"))
    text = peer_radiance.scene_text(scene)
    assert text.count(" polygon ") == len(scene.patches)
    assert text.count("lamp0 polygon ") == len(scene.emitters)
    with pytest.raises(ValueError, match="only area emitters"):
        peer_radiance.scene_text(replace(scene, emitters=replace(scene.emitters, patch=scene.emitters.patch * 0 - 1)))


def test_errors_within_the_noise_of_the_reference_are_not_told(device):
    """Half of what is measured at most may be the reference's own."""
    usual = Comparison(9, 0.10, 0.08, 0.2, 0.3, 0.0, 0.04, 0.041, 1.0, 1.0)
    session = Session(device)
    assert [f.value for f in error_figures(session, "room", [usual])] == [0.10]
    assert session.notes == ["room, illuminance rms is not told: 8 % against a reference with 4.1 % of noise"]


def test_what_mitsuba_lacks_is_told():
    newer = peers._why("\nLLVM ERROR: Cannot select\nIn function: drjit_dc\n")
    assert newer.startswith("In function: drjit_dc; a newer LLVM") and "DRJIT_LIBLLVM_PATH" in newer
    assert peers._why("ValueError: a sky\n") == "ValueError: a sky" and peers._why("") == "it wrote no message"

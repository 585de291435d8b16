"""From a scene file to results."""

import csv
import json
import subprocess
import sys

import numpy as np
import pytest
from cli_room import QUICK

FILES = {"readings.csv", "spectra.csv", "spectra_half_width.csv", "solution.vtkhdf", "run.json"}


def rows(path):
    with path.open(newline="") as stream:
        return list(csv.reader(stream))


@pytest.fixture
def rendered(room, call, tmp_path):
    out = tmp_path / "out"
    outcome = call("render", room, "-o", out, *QUICK)
    assert outcome.code == 0, outcome.err
    return out, outcome


def test_the_program_itself(room, tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "hradiosity", "render", str(room), *QUICK],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert {path.name for path in (tmp_path / "results" / "room").iterdir()} >= FILES
    assert "results are in results/room" in done.stdout
    for part in ("occlusion", "replicate 8 of 8", "desk, left", "Where the time went", "solve CPU"):
        assert part in done.stdout


def test_form_factors_of_choice(room, call, tmp_path):
    """What made them, how many, how good, and what intervals do not hold is in run.json; the plan tells beforehand."""
    arguments = (*QUICK, "--form-factors", "contour")
    assert "form factors: contour" in call("plan", room, "--form-factors", "contour", "--element-size", "0.7").out
    outcome = call("render", room, "-o", tmp_path / "out", *arguments)
    assert outcome.code == 0, outcome.err
    run = json.loads((tmp_path / "out" / "run.json").read_text())
    assert (
        run["plan"]["form_factors"] == run["form_factors"]["method"] == run["repeat_with"]["form_factors"] == "contour"
    )
    assert run["plan"]["pairs"] >= run["form_factors"]["cell_pairs"] > 1000
    assert run["form_factors"]["mean_error"] < 1e-5
    (note,) = (note for note in run["notes"] if note["place"] == "--form-factors contour")
    assert "intervals" in note["message"]


def test_tables(rendered):
    out, _ = rendered
    readings, spectra, width = (rows(out / name) for name in ("readings.csv", "spectra.csv", "spectra_half_width.csv"))
    head = "sensor,index,x,y,z,nx,ny,nz,illuminance_lx,illuminance_half_width_lx"
    assert ",".join(readings[0]).startswith(head)
    assert spectra[0] == width[0] == ["sensor", "index", *(str(nm) for nm in range(400, 721, 40))]
    names = [["desk, left", str(i)] for i in range(6)] + [["wall", "0"]]
    assert [row[:2] for row in readings[1:]] == [row[:2] for row in spectra[1:]] == names
    table = np.array([row[2:] for row in readings[1:]], float)
    assert np.all(table[:, 6] > 10.0)
    assert np.all(table[:, 7] > 0.0)
    assert np.all(table[:, 7] < table[:, 6])
    narrower = [readings[0].index(f"illuminance_half_width_{percent}_percent_lx") - 2 for percent in (50, 80)]
    assert np.all(table[:, narrower[0]] < table[:, narrower[1]]) and np.all(table[:, narrower[1]] < table[:, 7])
    density = np.array([row[2:] for row in spectra[1:]], float)
    weights = luminous(out)
    assert np.allclose(np.einsum("xb,b->x", density * 40.0, weights), table[:, 6], rtol=1e-6)


def luminous(out):
    from hradiosity.metrics.photometric import luminous_weights
    from hradiosity.model.spectrum import Bands

    return luminous_weights(Bands.uniform(400, 720, 40))


def test_run_record(rendered):
    out, _ = rendered
    run = json.loads((out / "run.json").read_text())
    assert run["state"] == "complete"
    assert run["complete"] is True
    assert run["replicates"] == 8
    assert run["interval_parts"][:2] == ["sampling", "mesh"]
    for key in (
        "plan",
        "options",
        "seed",
        "versions",
        "device",
        "stage_seconds",
        "solve_cpu_s",
        "kernel_build_s",
        "rays",
        "iterations",
    ):
        assert run[key] is not None
    assert len(run["defects_before_closure"]) == len(run["iterations"]) == 8
    assert run["versions"]["numpy"] == np.__version__
    assert not list(out.glob("*.draft"))
    assert not (out / "checkpoint.h5").exists()


def test_mesh_opens_and_has_the_area_and_the_light(rendered):
    import pyvista

    out, _ = rendered
    mesh = pyvista.read(out / "solution.vtkhdf")
    room, lamp = 2 * (3 * 2 + 3 * 2.5 + 2 * 2.5), 2 * 1.0
    area = mesh.compute_cell_sizes(length=False, volume=False)["Area"]
    assert area.sum() == pytest.approx(room + lamp, rel=1e-6)
    spectra = {name: mesh.cell_data[name] for name in ("exitance", "irradiance", "radiance")}
    assert all(array.shape == (mesh.n_cells, 9) and array.dtype == np.float32 for array in spectra.values())
    assert np.allclose(spectra["radiance"] * np.pi, spectra["exitance"], rtol=1e-5)
    assert np.allclose(mesh.field_data["wavelength_nm"], np.arange(400, 721, 40))
    luminous_exitance = mesh.cell_data["luminance"] * np.pi
    emitting = luminous_exitance > 500.0
    assert area[emitting].sum() == pytest.approx(1.0, rel=1e-6)
    assert np.allclose(mesh.face_normals[emitting], [0.0, 0.0, -1.0], atol=1e-6)
    leaves, arrives = (np.einsum("cb,c->b", spectra[name], area) for name in ("exitance", "irradiance"))
    assert np.allclose(leaves, arrives, rtol=0.02)  # a closed room


def test_same_seed_same_bits_and_another_seed_others(room, call, tmp_path):
    texts = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        assert call("render", room, "-o", tmp_path / name, "--seed", seed, "--quiet", *QUICK).code == 0
        texts.append((tmp_path / name / "spectra.csv").read_bytes())
    assert texts[0] == texts[1] != texts[2]


def test_quiet_says_nothing(room, call, tmp_path):
    outcome = call("render", room, "-o", tmp_path / "out", "--quiet", *QUICK)
    assert (outcome.code, outcome.out, outcome.err) == (0, "", "")


def test_json_lines(room, call, tmp_path):
    outcome = call("render", room, "-o", tmp_path / "out", "--json", *QUICK)
    events = [json.loads(line) for line in outcome.out.splitlines()]
    kinds = [event["event"] for event in events]
    assert kinds[0] in ("plan", "building kernels")
    assert kinds[-1] == "result"
    states = [event for event in events if event["event"] == "state"]
    assert [state["replicate"] for state in states] == list(range(9))
    assert states[-1]["rays"] > states[1]["rays"] > 0
    assert events[-1]["sensors"]["desk, left"]["readings"] == 6


def test_accuracy_not_reached_in_the_time(room, call, tmp_path):
    outcome = call("render", room, "-o", tmp_path / "out", "--accuracy", "0.001%", "--time", "0.2s", *QUICK)
    assert outcome.code == 3
    assert "not reached" in outcome.out
    assert json.loads((tmp_path / "out" / "run.json").read_text())["state"] == "accuracy not reached"


def half_of_the_first_error(out):
    run = json.loads((out / "run.json").read_text())
    return f"{50 * max(sensor['accuracy'] for sensor in run['sensors'].values())}%"


def test_accuracy_is_reached_with_more_samples_and_they_can_be_repeated(room, call, tmp_path):
    call("render", room, "-o", tmp_path / "first", "--quiet", *QUICK)
    wanted = half_of_the_first_error(tmp_path / "first")
    assert call("render", room, "-o", tmp_path / "a", "--accuracy", wanted, "--quiet", *QUICK).code == 0
    run = json.loads((tmp_path / "a" / "run.json").read_text())
    assert run["further_samples"] or run["rounds_given_up"]
    assert max(sensor["accuracy"] for sensor in run["sensors"].values()) <= float(wanted[:-1]) / 100
    words = [word for name, value in run["repeat_with"].items() for word in (f"--{name.replace('_', '-')}", value)]
    assert call("render", room, "-o", tmp_path / "b", "--quiet", "--no-pictures", *words).code == 0
    assert (tmp_path / "a" / "spectra.csv").read_bytes() == (tmp_path / "b" / "spectra.csv").read_bytes()


def test_scene_without_sensors_writes_surfaces_only(room, call, tmp_path):
    text = (room / "scene.toml").read_text()
    (room / "scene.toml").write_text(text[: text.index("[[sensor]]")])
    assert call("render", room, "-o", tmp_path / "out", *QUICK).code == 0
    assert len(rows(tmp_path / "out" / "readings.csv")) == 1
    assert (tmp_path / "out" / "solution.vtkhdf").stat().st_size > 10_000


def test_one_triangle(call, tmp_path):
    (tmp_path / "scene.toml").write_text(
        '[scene]\nunit = "m"\n[materials.paint]\nreflectance = 0.5\n'
        "[luminaires.lamp]\nspectrum = { constant = 1.0 }\nabsolute = true\n"
        '[[polygon]]\nname = "only"\nvertices = [[0,0,0], [1,0,0], [0,1,0]]\nmaterial = "paint"\nluminaire = "lamp"\n'
        '[[sensor]]\nname = "above"\nkind = "points"\npositions = [[0.3, 0.3, 1.0]]\nnormal = [0, 0, -1]\n'
    )
    assert call("render", tmp_path, "-o", tmp_path / "out", *QUICK).code == 0
    assert float(rows(tmp_path / "out" / "readings.csv")[1][8]) > 0.0


def test_referee_agrees(room, call, tmp_path):
    outcome = call("render", room, "-o", tmp_path / "out", "--referee", 2000, "--element-size", 0.25, "--no-pictures")
    found = json.loads((tmp_path / "out" / "run.json").read_text())["referee"]["comparison"]
    assert outcome.code == 0
    assert "Against the referee" in outcome.out
    assert found["illuminance_rms"] < 0.05
    assert len(rows(tmp_path / "out" / "referee_spectra.csv")) == 8


VIEW = '[[view]]\nname = "door"\nposition = [0.2, 0.2, 1.6]\ntarget = [2.0, 1.2, 0.8]\nsize = [40, 30]\n'


@pytest.fixture
def room_with_view(room):
    with (room / "scene.toml").open("a") as file:
        file.write(VIEW)
    return room


def test_pictures(room_with_view, call, tmp_path):
    with_pictures = [word for word in QUICK if word != "--no-pictures"]
    outcome = call("render", room_with_view, "-o", tmp_path / "out", *with_pictures)
    assert outcome.code == 0
    names = {path.name for path in (tmp_path / "out" / "pictures").iterdir()}
    assert {"door_smooth.png", "door_smooth.exr", "door_false-color.png", "pictures.json"} <= names
    assert "preview.png" not in names
    run = json.loads((tmp_path / "out" / "run.json").read_text())
    assert run["stage_seconds"]["pictures"] > 0.0
    assert len(run["pictures"]["pictures"]) == 5


def test_pictures_that_are_interrupted_are_drawn_by_resuming(room_with_view, call, tmp_path, monkeypatch):
    from hradiosity.show import pictures

    def broken(*arguments, **keywords):
        raise KeyboardInterrupt

    with_pictures = [word for word in QUICK if word != "--no-pictures"]
    with monkeypatch.context() as patched:
        patched.setattr(pictures, "write_pictures", broken)
        assert call("render", room_with_view, "-o", tmp_path / "out", *with_pictures).code == 130
    assert json.loads((tmp_path / "out" / "run.json").read_text())["replicates"] == 8
    assert (tmp_path / "out" / "pictures" / "preview.png").stat().st_size > 100
    assert call("render", room_with_view, "-o", tmp_path / "out", "--resume", *with_pictures).code == 0
    assert (tmp_path / "out" / "pictures" / "door_flat.png").exists()


def test_camera_inside_a_wall(room, call, tmp_path):
    block = '[[box]]\nname = "block"\ncorner = [0.1, 0.1, 0]\nsize = [0.3, 0.3, 2]\nmaterial = "wall"\n'
    with (room / "scene.toml").open("a") as file:
        file.write(block + VIEW)
    outcome = call("render", room, "-o", tmp_path / "out", *QUICK)
    assert outcome.code == 2
    for part in ("scene.toml", "door", "block"):
        assert part in outcome.err
    assert not (tmp_path / "out.partial").exists()


def test_a_run_over_links_tells_them_in_its_record(room, call, tmp_path):
    outcome = call("render", room, "-o", tmp_path / "out", "--no-audit", "--links", "hierarchical", *QUICK)
    assert outcome.code == 0, outcome.err
    run = json.loads((tmp_path / "out" / "run.json").read_text())
    assert isinstance(run["plan"]["links"], dict) and run["links"]["total"] > 0

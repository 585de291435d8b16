"""Light of a run that is watched: written when somebody asks, and nothing depends on it."""

from dataclasses import replace

import numpy as np
import pytest
from window_room import QUICK

from hradiosity.cli.watching import LiveLight, light_of
from hradiosity.errors import SceneError
from hradiosity.io.live_light import LiveReader, LiveWriter, ask_for_light, is_watched, remove_live, stop_watching
from hradiosity.radiosity import make_solver


def test_light_comes_back_as_it_was_written(solved, tmp_path):
    solution = solved[0]
    assert not is_watched(tmp_path)
    ask_for_light(tmp_path)
    assert is_watched(tmp_path)
    writer, reader = LiveWriter(tmp_path), LiveReader(tmp_path)
    assert reader.read() is None
    light = light_of(solution.surfaces, 2)
    writer.write(solution.scene, solution.elements, light, "half way", settled=False)
    seen = reader.read()
    np.testing.assert_allclose(seen.drawn.light.irradiance, light.irradiance, rtol=1e-6)
    assert (seen.words, seen.settled) == ("half way", False)
    assert reader.read() is None, "nothing new"
    brighter = replace(light, irradiance=2.0 * light.irradiance)
    writer.write(solution.scene, solution.elements, brighter, "later", settled=True)
    again = reader.read()
    assert again.drawn.cells is seen.drawn.cells, "the mesh is the same"
    np.testing.assert_allclose(again.drawn.light.irradiance, brighter.irradiance, rtol=1e-6)
    other = replace(solution.elements)
    writer.write(solution.scene, other, light, "another mesh", settled=True)
    assert reader.read().drawn.cells is not seen.drawn.cells
    stop_watching(tmp_path)
    assert not is_watched(tmp_path)
    remove_live(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_damaged_mesh_is_told(solved, tmp_path):
    solution = solved[0]
    writer = LiveWriter(tmp_path)
    (tmp_path / "live").mkdir()
    writer.write(solution.scene, solution.elements, light_of(solution.surfaces, 1), "", settled=True)
    file = tmp_path / "live" / "light.h5"
    file.write_bytes(file.read_bytes()[:200])
    assert LiveReader(tmp_path).read() is None


@pytest.mark.parametrize(
    "options",
    [
        QUICK,
        replace(QUICK, solver="southwell"),
        replace(QUICK, solver="gauss-seidel", reduced_basis=False),
        replace(QUICK, mode="classic", hemicube_resolution=32),
    ],
    ids=["cg", "southwell", "gauss-seidel", "classic"],
)
def test_watching_changes_no_bit_and_shows_the_light_grow(room, device, options):
    seen, plain, watched = [], make_solver(room, options, device), make_solver(room, options, device)
    watched.watch = lambda glimpse: seen.append((glimpse, glimpse.surfaces().irradiance))
    for solver in (plain, watched):
        for _ in solver.states():
            pass
    expected = plain.solution().surfaces.irradiance
    np.testing.assert_array_equal(watched.solution().surfaces.irradiance, expected)
    first = [light for glimpse, light in seen if glimpse.replicates == 0]
    assert len(first) > 2
    assert all(light.shape == expected.shape for light in first)
    assert first[-1].sum() > first[0].sum() > 0.0
    last = seen[-1][1]
    np.testing.assert_allclose(last.sum(axis=0), expected.sum(axis=0), rtol=0.02)


def test_a_run_that_nobody_watches_writes_nothing(room, device, tmp_path):
    solver = make_solver(room, QUICK, device)
    live = LiveLight(tmp_path, solver)
    for _ in solver.states():
        live.update()
    assert list(tmp_path.iterdir()) == []
    solver = make_solver(room, QUICK, device)
    live = LiveLight(tmp_path, solver)
    ask_for_light(tmp_path)
    for _ in solver.states():
        live.update()
    seen = LiveReader(tmp_path).read()
    assert seen is not None
    assert seen.drawn.light.replicates >= 1


def test_a_result_of_nothing_is_told(tmp_path):
    from hradiosity.io.results_reading import read_drawn

    with pytest.raises(SceneError, match="no such file"):
        read_drawn(tmp_path / "mesh.h5")

"""A run that does not fit into memory is refused before it starts, with the numbers and the option that helps."""

from dataclasses import replace

import numpy as np
import pytest
from rooms import cube

from hradiosity import planning_memory
from hradiosity.device.host_memory import available_host_bytes
from hradiosity.errors import SceneError
from hradiosity.options import Options
from hradiosity.planning_memory import check_memory, element_bytes, kept_bytes, path_bytes
from hradiosity.radiosity import make_solver, solve

GIB = 2**30
SMALL = Options(elements=400, gather_samples=64, light_samples=16, replicates=2)


def room(points=1):
    b = cube(0.5)
    b.lamp(5, 1.0)
    b.sensor(np.random.default_rng(0).uniform(0.1, 0.9, (points, 3)), (0, 0, 1))
    return b.scene()


@pytest.fixture
def small(device, monkeypatch):
    """Say that the device and the machine have only so many bytes."""

    def set_sizes(of_device, of_host):
        monkeypatch.setattr(device, "info", replace(device.info, global_memory_bytes=of_device))
        monkeypatch.setattr(planning_memory, "available_host_bytes", lambda: of_host)

    return set_sizes


def plan_of(scene, options, device):
    return make_solver(scene, options, device).plan


def refused(scene, options, device):
    """The fault, and that nothing was computed."""
    with pytest.raises(SceneError) as caught:
        solve(scene, options, device)
    (fault,) = caught.value.faults
    return fault


@pytest.mark.parametrize(("of_device", "of_host", "place"), [(1, 8, "the device has"), (8, 1, "this machine has free")])
def test_too_many_elements(device, small, of_device, of_host, place):
    """Half of what is needed: half of the elements, less a tenth to spare, fit, and the advice says so.

    Before the elements are cut their number is known to a few per cent.
    """
    options = replace(SMALL, elements=4000, replicates=4)
    needed = plan_of(room(), options, device).memory_bytes
    small(of_device * needed // 2, of_host * needed // 2)
    fault = refused(room(), options, device)
    assert (fault.file, fault.entry) == ("command line", "--elements")
    assert f", {place} {needed // 2 / GIB:.3g} GiB" in fault.found
    told = float(fault.found.removeprefix("the run needs about ").split()[0])
    assert told == pytest.approx(needed / GIB, rel=0.05)
    most = int(fault.expected.removeprefix("--elements ").removesuffix(" or less"))
    assert 0.3 * 4000 < most < 0.5 * 4000
    assert solve(room(), replace(options, elements=most), device).replicates == 4


def test_too_many_paths(device, small):
    options = replace(SMALL, gather_samples=1 << 16)
    plan = plan_of(room(64), options, device)
    assert path_bytes(plan) > 4 * element_bytes(plan)
    small(plan.memory_bytes // 2, None)
    fault = refused(room(64), options, device)
    assert fault.entry == "--gather-samples"
    most = int(fault.expected.removeprefix("--gather-samples ").removesuffix(" or less"))
    assert solve(room(64), replace(options, gather_samples=most), device).replicates == 2


def test_too_many_pairs(device, small):
    """They grow with the square of the elements, and are only counted once these are cut."""
    options = replace(SMALL, form_factors="contour", rays_per_element=128)
    plan = plan_of(room(), options, device)
    assert plan.memory_bytes > 4 * element_bytes(plan)
    small(plan.memory_bytes // 2, None)
    fault = refused(room(), options, device)
    assert fault.entry == "--elements"
    most = int(fault.expected.removeprefix("--elements ").removesuffix(" or less"))
    assert 0.55 * plan.n_elements < most < 0.75 * plan.n_elements


def test_what_fits_exactly_runs_and_the_unknown_is_not_feared(device):
    plan = plan_of(room(), SMALL, device)
    check_memory(plan, plan.memory_bytes, plan.memory_bytes)
    check_memory(plan, None, None)
    with pytest.raises(SceneError, match="this machine has free"):
        check_memory(plan, None, plan.memory_bytes - 1)


def solved(options, device, n_points=32):
    solver = make_solver(room(n_points), options, device)
    for _ in solver.states():
        pass
    return solver


@pytest.mark.parametrize("room_for", [8, 3, 0])
def test_light_that_is_kept_is_counted(device, monkeypatch, room_for):
    """Against the arrays that a run holds at its end; that of two replicates is always kept. Every fourth replicate has
    no companion, and keeps less than it may."""
    options = replace(SMALL, replicates=8, elements=200)
    plan = replace(plan_of(room(32), options, device), n_readings=0)
    each = kept_bytes(replace(plan, replicates=1))
    for name in ("hradiosity.planning_memory", "hradiosity.radiosity.round"):
        monkeypatch.setattr(f"{name}.KEPT_LIGHT_BYTES", int(room_for * 1.02 * each))
    kept = solved(options, device)._rounds.now.kept
    held = sum(on.light.nbytes for on in kept)
    assert len(kept) == max(room_for, 2)
    assert 0.75 * kept_bytes(plan) <= held <= kept_bytes(plan)


@pytest.mark.parametrize("mode", ["rays", "classic"])
def test_kept_light_and_samples_are_part_of_the_plan(device, mode):
    """Twice the replicates of the same rays and paths leave twice as much, and nothing else of the plan grows."""
    few, many = (
        Options(
            mode=mode,
            elements=200,
            rays_per_element=16 * count,
            light_points=count,
            gather_samples=8 * count,
            light_samples=8 * count,
            hemicube_resolution=32,
            replicates=count,
        )
        for count in (4, 8)
    )
    more = plan_of(room(32), many, device).memory_bytes - plan_of(room(32), few, device).memory_bytes
    solver = solved(many, device)
    if mode == "rays":
        held = sum(on.light.nbytes for on in solver._rounds.now.kept)
        held += sum(some.nbytes for some in solver._reader._gathered)
    else:
        held = sum(light.nbytes for light in solver._lights)
    assert 0.75 * more <= held / 2 <= more


def test_the_machine_and_its_container_are_asked(tmp_path):
    assert available_host_bytes(tmp_path) is None
    (tmp_path / "proc").mkdir()
    (tmp_path / "proc/meminfo").write_text("MemTotal:  8000 kB\nMemFree:  10 kB\nMemAvailable:    4000 kB\n")
    assert available_host_bytes(tmp_path) == 4000 * 1024
    group = tmp_path / "sys/fs/cgroup"
    group.mkdir(parents=True)
    (group / "memory.max").write_text("max\n")
    (group / "memory.current").write_text("1000\n")
    assert available_host_bytes(tmp_path) == 4000 * 1024
    (group / "memory.max").write_text("3000\n")
    assert available_host_bytes(tmp_path) == 2000
    (group / "memory.stat").write_text("anon 700\ninactive_file 250\n")
    assert available_host_bytes(tmp_path) == 2250
    (group / "memory.current").write_text("5000\n")
    assert available_host_bytes(tmp_path) == 0

"""Whatever ends a run, and whenever: the folder holds the old result or the new one as a whole, and a run can go on.

Each test lets something happen at the n-th of the events of a run, for one n after the other: calls that change the
disk, and launches of kernels. After a kill nothing at all reaches the disk, not even what is written on the way out.
"""

import errno
import os
import shutil
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from hradiosity.cli import computing, live_files, main, session
from hradiosity.device import Device
from hradiosity.device.kernel import Kernel
from hradiosity.errors import DeviceError
from hradiosity.io.cache import CACHE_VARIABLE
from hradiosity.io.output_folder import check_free, old_of, partial_of, recover

SCENE = """
[scene]
unit = "m"
bands = { edges = [450, 550, 650] }
[materials.wall]
reflectance = 0.5
[luminaires.lamp]
spectrum = { constant = 1.0 }
absolute = true
[[box]]
name = "room"
corner = [0, 0, 0]
size = [3, 2, 2.5]
inside = true
material = "wall"
[[rectangle]]
name = "lamp"
corner = [1.0, 0.5, 2.4]
edge_u = [0.0, 1.0, 0.0]
edge_v = [1.0, 0.0, 0.0]
material = "wall"
luminaire = "lamp"
[[sensor]]
name = "desk"
kind = "points"
positions = [[1, 1, 0.8], [2, 0.5, 0.8]]
normal = [0, 0, 1]
"""
QUICK = (
    *("--element-size", "1.0", "--rays-per-element", "64", "--light-points", "16", "--replicates", "3"),
    *("--gather-samples", "64", "--light-samples", "16", "--quiet"),
)
TABLES = ("readings.csv", "spectra.csv", "spectra_half_width.csv")
WHOLE = {*TABLES, "run.json", "solution.vtkhdf"}


class Killed(BaseException):
    """The process is gone."""


@dataclass
class Events:
    """Counts events of one kind, and lets something happen at one of them.

    at : number of the event, from 0
    action : what happens then, before the event
    lasting : it happens at all later events, too
    """

    at: int
    action: object
    lasting: bool = False
    count: int = 0

    def __call__(self):
        number, self.count = self.count, self.count + 1
        if number == self.at or (self.lasting and number > self.at):
            self.action()

    @property
    def happened(self):
        return self.count > self.at


def raising(error):
    def action():
        raise error

    return action


def watch_disk(patched, folder, events, *, growing=False):
    """Let calls that change the disk below a folder be events; with ``growing`` those only that need room."""

    def watched(original, place=0):
        def call(*arguments, **keywords):
            path = arguments[place] if place is not None else None
            if path is None or str(path).startswith(str(folder)):
                events()
            return original(*arguments, **keywords)

        return call

    def opened(path, mode="r", *more, **keywords):
        if mode[0] in "wxa" and str(path).startswith(str(folder)):
            events()
        return original_open(path, mode, *more, **keywords)

    original_open = Path.open
    patched.setattr(Path, "open", opened)
    patched.setattr(os, "fsync", watched(os.fsync, None))
    for name in (
        ("mkdir", "write_bytes") if growing else ("mkdir", "write_bytes", "rename", "replace", "unlink", "rmdir")
    ):
        patched.setattr(Path, name, watched(getattr(Path, name)))
    if not growing:
        patched.setattr(shutil, "rmtree", watched(shutil.rmtree))


def watch_kernels(patched, events):
    """Let launches of kernels be events."""
    original = Kernel.__call__

    def call(self, *arguments, **keywords):
        events()
        return original(self, *arguments, **keywords)

    patched.setattr(Kernel, "__call__", call)


@dataclass
class Bench:
    """A scene, an earlier result of it with another seed, and the result of an undisturbed run.

    folder : where runs write; ``out`` is their result
    """

    folder: Path
    render: object
    earlier: dict
    wanted: dict

    @property
    def out(self):
        return self.folder / "out"

    def restore(self):
        """The folder with the earlier result and nothing else."""
        shutil.rmtree(self.folder)
        shutil.copytree(self.folder.with_name("kept"), self.folder)

    def assert_old_or_new(self):
        """After what the next start would put right; returns whether it is the new one."""
        check_free(self.out)
        recover(self.out)
        assert not old_of(self.out).exists()
        found = tables(self.out)
        assert found in (self.earlier, self.wanted)
        assert {path.name for path in self.out.iterdir()} - {"pictures"} == WHOLE
        return found == self.wanted

    def assert_can_go_on(self):
        """Resumed from what is left, or begun again where nothing was; the bits are those of the undisturbed run."""
        code = self.render("--resume")
        if code == 2:
            assert tables(self.out) == self.earlier
            code = self.render()
        assert code == 0
        assert tables(self.out) == self.wanted
        assert [path.name for path in self.folder.iterdir()] == ["out"]
        assert {path.name for path in self.out.iterdir()} - {"pictures"} == WHOLE


def tables(out):
    return {name: (out / name).read_bytes() for name in TABLES}


@pytest.fixture(scope="module")
def kept_bench(tmp_path_factory, device):
    place = tmp_path_factory.mktemp("broken off")
    (place / "scene.toml").write_text(SCENE)

    def render(*more, seed=1, out="runs/out"):
        words = ["render", place, "-o", place / out, "--seed", seed, *QUICK, *more]
        return main([str(word) for word in words] + ([] if "--pictures" in more else ["--no-pictures"]))

    with pytest.MonkeyPatch.context() as patched:
        patched.setenv(CACHE_VARIABLE, str(place / "cache"))
        patched.setattr(session, "Device", lambda spec: device if spec is None else Device(spec))
        patched.setattr(live_files, "LEAST_PAUSE", 0.0)
        patched.setattr(live_files, "TIME_SHARE", 1.0)
        assert render(seed=7, out="kept/out") == 0
        assert render(out="undisturbed") == 0
        (place / "runs").mkdir()
        yield Bench(place / "runs", render, tables(place / "kept" / "out"), tables(place / "undisturbed"))


@pytest.fixture
def bench(kept_bench):
    kept_bench.restore()
    return kept_bench


def events_of(bench, watch, **keywords):
    """How many events an undisturbed run has."""
    events = Events(10**9, None)
    with pytest.MonkeyPatch.context() as patched:
        watch(patched, events, **keywords)
        assert bench.render() == 0
    bench.restore()
    return events.count


def some(count, most):
    """At most so many numbers below ``count``, evenly spread, the first and the last among them."""
    return sorted({round(k * (count - 1) / (most - 1)) for k in range(most)}) if count > most else range(count)


def test_the_results_differ(bench):
    assert bench.earlier != bench.wanted
    assert not bench.assert_old_or_new()


def killed_everywhere(bench, most):
    def watch(patched, events):
        watch_disk(patched, bench.folder, events)

    count = events_of(bench, watch)
    assert count > 25
    seen = set()
    for at in some(count, most):
        bench.restore()
        events = Events(at, raising(Killed()), lasting=True)
        with pytest.MonkeyPatch.context() as patched:
            watch(patched, events)
            with pytest.raises(Killed):
                bench.render()
        seen.add(bench.assert_old_or_new())
        bench.assert_can_go_on()
    assert seen == {False, True}


def test_killed_at_some_changes_of_the_disk(bench):
    killed_everywhere(bench, 6)


@pytest.mark.slow
def test_killed_at_every_change_of_the_disk(bench):
    killed_everywhere(bench, 10**6)


def full_everywhere(bench, most, capsys):
    def watch(patched, events):
        watch_disk(patched, bench.folder, events, growing=True)

    count = events_of(bench, watch)
    for at in some(count, most):
        bench.restore()
        capsys.readouterr()
        events = Events(at, raising(OSError(errno.ENOSPC, "No space left on device")), lasting=True)
        with pytest.MonkeyPatch.context() as patched:
            watch(patched, events)
            code = bench.render()
        said = capsys.readouterr().err
        assert code == 0 or (code == 2 and "no space left" in said), said
        assert "Traceback" not in said
        assert bench.assert_old_or_new() == (code == 0 or "can't take the place" in said)
        bench.assert_can_go_on()


def test_disk_full_from_some_writes_on(bench, capsys):
    full_everywhere(bench, 5, capsys)


@pytest.mark.slow
def test_disk_full_from_every_write_on(bench, capsys):
    full_everywhere(bench, 10**6, capsys)


def interrupted_everywhere(bench, watch, most, capsys):
    count = events_of(bench, watch)
    assert count > 20
    for at in some(count, most):
        bench.restore()
        capsys.readouterr()
        events = Events(at, lambda: signal.raise_signal(signal.SIGINT))
        with pytest.MonkeyPatch.context() as patched:
            watch(patched, events)
            code = bench.render()
        said = capsys.readouterr().err
        assert code == 130 or (code == 0 and tables(bench.out) == bench.wanted), (at, said)
        assert "Traceback" not in said
        check_free(bench.out)
        assert not old_of(bench.out).exists()
        assert {path.name for path in bench.out.iterdir()} == WHOLE
        if tables(bench.out) == bench.earlier:
            assert not partial_of(bench.out).exists()
        bench.assert_can_go_on()


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("what", ["disk", "kernels"])
def test_ctrl_c_at_some_events(bench, what, capsys):
    interrupted_everywhere(bench, watcher(bench, what), 4, capsys)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("what", ["disk", "kernels"])
def test_ctrl_c_at_many_events(bench, what, capsys):
    interrupted_everywhere(bench, watcher(bench, what), 60, capsys)


def watcher(bench, what):
    def disk(patched, events):
        watch_disk(patched, bench.folder, events)

    return disk if what == "disk" else watch_kernels


@pytest.mark.parametrize("most", [5, pytest.param(60, marks=pytest.mark.slow)])
def test_device_out_of_memory(bench, most, capsys):
    """At any kernel: the earlier result stays, what was known is kept, and the run can go on."""
    error = DeviceError("kernel x with 64 work-items: clEnqueueNDRangeKernel failed: MEM_OBJECT_ALLOCATION_FAILURE")
    kept = 0
    for at in some(events_of(bench, watch_kernels), most):
        bench.restore()
        capsys.readouterr()
        with pytest.MonkeyPatch.context() as patched:
            watch_kernels(patched, Events(at, raising(error)))
            assert bench.render() == 2
        said = capsys.readouterr().err
        assert "MEM_OBJECT_ALLOCATION_FAILURE" in said and "Traceback" not in said
        assert not bench.assert_old_or_new()
        assert partial_of(bench.out).exists() == ("--resume" in said)
        kept += partial_of(bench.out).exists()
        bench.assert_can_go_on()
    assert kept > 0


@pytest.mark.parametrize("call", ["empty", "to_device"])
def test_what_the_driver_says_about_memory_reaches_the_user(bench, call, capsys, monkeypatch):
    import pyopencl as cl
    import pyopencl.array

    monkeypatch.setattr(pyopencl.array, call, raising_driver_error(cl))
    assert bench.render() == 2
    said = capsys.readouterr().err
    assert "no room for" in said and "Traceback" not in said
    monkeypatch.undo()


def raising_driver_error(cl):
    def call(*arguments, **keywords):
        raise cl.MemoryError("create_buffer failed: MEM_OBJECT_ALLOCATION_FAILURE")

    return call


def test_too_little_memory_of_the_computer(bench, capsys, monkeypatch):
    monkeypatch.setattr(computing, "make_solver", raising_memory_error)
    assert bench.render() == 2
    assert "not enough memory: Unable to allocate 9 TiB" in capsys.readouterr().err
    assert not partial_of(bench.out).exists()


def raising_memory_error(*arguments):
    raise MemoryError("Unable to allocate 9 TiB")


def test_a_checkpoint_outlives_a_resumed_run_that_fails_early(bench, capsys, monkeypatch):
    """Ctrl-C while a resumed run starts, or settings that don't fit, must not delete what an earlier run knew."""
    kernels = events_of(bench, watch_kernels)
    with pytest.MonkeyPatch.context() as patched:
        watch_kernels(patched, Events(kernels - 5, raising(DeviceError("it broke"))))
        assert bench.render() == 2
    checkpoint = (partial_of(bench.out) / "checkpoint.h5").read_bytes()
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(computing, "make_solver", interrupting)
        assert bench.render("--resume") == 130
    assert (partial_of(bench.out) / "checkpoint.h5").read_bytes() == checkpoint
    assert bench.render("--resume", seed=9) == 2
    assert "can't be resumed" in capsys.readouterr().err
    assert (partial_of(bench.out) / "checkpoint.h5").read_bytes() == checkpoint
    bench.assert_can_go_on()


def interrupting(*arguments):
    raise KeyboardInterrupt


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.7, 0.9, 0.95, 0.99])
def test_really_killed_with_pictures(bench, share, tmp_path):
    """The operating system ends a process of its own, at some time of a run that takes seconds."""
    import time

    words = [sys.executable, "-m", "hradiosity", "render", str(bench.folder.parent), "-o", str(bench.out)]
    words += ["--seed", "1", *QUICK]
    environment = {**os.environ, CACHE_VARIABLE: str(tmp_path)}

    def start():
        return subprocess.Popen(words, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    begin = time.perf_counter()
    assert start().wait(120) == 0
    seconds = time.perf_counter() - begin
    bench.restore()
    process = start()
    time.sleep(share * seconds)
    process.kill()
    process.wait()
    bench.assert_old_or_new()
    (bench.folder / "out.lock").unlink(missing_ok=True)
    bench.assert_can_go_on()

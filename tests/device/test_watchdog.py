"""Which kernel hangs is told, from a thread, while the program waits for it."""

import gc
import threading
import time
import warnings
from types import SimpleNamespace

import numpy as np
import pytest

from hradiosity.device import Device
from hradiosity.device import watchdog as module
from hradiosity.device.watchdog import Watchdog

SLOW = """
__kernel void spin(__global float *out, const uint turns, const uint n_items)
{
    const uint i = get_global_id(0);
    if (i >= n_items)
        return;
    float x = out[i];
    for (uint k = 0u; k < turns; ++k)
        x = x * 0.999f + 1.0f / (1.0f + x);
    out[i] = x;
}
"""


def launch(status):
    return SimpleNamespace(command_execution_status=status)


@pytest.fixture
def clock(monkeypatch):
    """Seconds that a test sets; no thread looks on its own."""
    now = SimpleNamespace(seconds=0.0)
    monkeypatch.setattr(module.time, "monotonic", lambda: now.seconds)
    monkeypatch.setattr(module.threading, "Thread", lambda **_: SimpleNamespace(start=lambda: None))
    return now


def said(watchdog):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        watchdog.look()
    return [str(warning.message) for warning in caught]


def test_names_the_launch_that_runs_and_no_other(clock):
    """The queue is in order: of three, the first is over, the second hangs, the third waits."""
    watchdog = Watchdog("a device", long=100.0)
    over, hangs, waits = launch(1), launch(1), launch(3)
    for name, event in (("over", over), ("hangs", hangs), ("waits", waits)):
        watchdog.note(name, 640, event)
    clock.seconds = 90.0
    over.command_execution_status = 0
    assert said(watchdog) == []
    clock.seconds = 180.0
    assert said(watchdog) == []
    clock.seconds = 191.0
    (message,) = said(watchdog)
    assert message.startswith("kernel hangs with 640 work-items has been running for 101 s on a device")


def test_says_so_again_each_time_the_seconds_have_doubled(clock):
    watchdog = Watchdog("a device", long=100.0)
    watchdog.note("hangs", 1, launch(1))
    times = []
    for clock.seconds in np.arange(0.0, 1000.0, 10.0):
        times += [clock.seconds] * len(said(watchdog))
    assert times == [100.0, 200.0, 400.0, 800.0]


def test_failed_and_finished_launches_are_forgotten(clock):
    watchdog = Watchdog("a device", long=1.0)
    for status in (0, -5, 0):
        watchdog.note("done", 1, launch(status))
    clock.seconds = 1e6
    assert said(watchdog) == []


def test_a_slow_kernel_is_named_while_it_runs():
    device = Device()
    device.watchdog.long = 0.2
    spin = device.kernel_from_text(SLOW, "spin")
    out = device.zeros((64,), np.float32)
    turns = 1 << 20
    with pytest.warns(RuntimeWarning, match=r"kernel spin with 64 work-items has been running for 0\.\d+ s on "):
        for _ in range(8):
            start = time.perf_counter()
            spin(64, out=out, turns=turns)
            device.finish()
            if time.perf_counter() - start > 0.5:
                break
            turns *= 4


def test_quick_kernels_are_not_spoken_of(device):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        device.prove()
        device.watchdog.look()


def test_the_thread_ends_with_the_device():
    watchdog = Watchdog("a device", long=0.08)
    watchdog.note("done", 1, launch(0))
    thread = watchdog._thread
    assert isinstance(thread, threading.Thread) and thread.daemon and thread.is_alive()
    del watchdog
    gc.collect()
    thread.join(timeout=5.0)
    assert not thread.is_alive()

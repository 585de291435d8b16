"""Compiling kernels is told from their work, also where a driver compiles at the first launch."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

from hradiosity.device.kernel import WIDE_GRID

ROOT = Path(__file__).parents[2]
PROBE = """
import json, time
import numpy as np
from hradiosity.device import Device
device = Device()
values = device.upload(np.ones(100, np.float32))
device.fetch(values)
start, whole = device.work_cpu_seconds(), time.process_time()
device.kernel("rays", "trace_any")  # a large program, not launched
device.kernel("probe", "scale_values")(100, x=values, y=device.upload(np.zeros(100, np.float32)), factor=2.0)
device.finish()
work, whole = device.work_cpu_seconds() - start, time.process_time() - whole
print(json.dumps([work, whole, device.build_time.cpu, device.build_time.wall]))
"""


def seconds(cache):
    """Of a new process: work, all, and building (CPU and wall)."""
    places = dict.fromkeys(("POCL_CACHE_DIR", "XDG_CACHE_HOME"), str(cache))
    done = subprocess.run(
        [sys.executable, "-c", PROBE],
        env={**os.environ, **places},
        cwd=ROOT,
        capture_output=True,
        check=True,
        text=True,
    )
    return [float(number) for number in re.findall(r"[\d.e+-]+", done.stdout)]


def test_building_with_an_empty_cache_is_no_work(tmp_path):
    work, whole, build_cpu, build_wall = seconds(tmp_path)
    assert build_wall > 0.0
    assert abs(work + build_cpu - whole) < 0.02
    assert work < 0.1 * whole


def test_only_first_launches_count_as_building(device):
    """A launch that is wide and one that is not may be compiled apart; further ones compile nothing."""
    kernel = device.kernel("probe", "scale_values")

    def launch(n):
        x, y = device.upload(np.arange(n, dtype=np.float32)), device.empty((n,), np.float32)
        kernel(n, x=x, y=y, factor=3.0)
        np.testing.assert_array_equal(device.fetch(y), 3.0 * np.arange(n, dtype=np.float32))

    for n in (100, WIDE_GRID + 1):
        launch(n)
    before = device.build_time.cpu
    for n in (100, 64, WIDE_GRID + 1000):
        launch(n)
    assert device.build_time.cpu == before

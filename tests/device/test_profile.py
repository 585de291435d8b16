"""A device opened for it tells how often each kernel ran, and for how long."""

import time

import numpy as np

from hradiosity.device import Device


def test_profile_counts_launches_and_their_seconds():
    device = Device(profile=True)
    values = device.upload(np.arange(200_000, dtype=np.float32))
    scaled = device.empty((200_000,), np.float32)
    scale = device.kernel("probe", "scale_values")
    device.finish()
    before = device.profile_table().get("scale_values", (0, 0.0))
    start = time.perf_counter()
    for _ in range(3):
        scale(200_000, x=values, y=scaled, factor=2.0)
    count, seconds = device.profile_table()["scale_values"]
    wall = time.perf_counter() - start
    assert count - before[0] == 3
    assert 0.0 < seconds - before[1] <= wall


def test_other_devices_keep_no_profile(device):
    device.prove()
    assert device.profile_table() == {}

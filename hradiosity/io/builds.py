"""Which kernels earlier runs on this machine had built; light, since a run asks before anything else is loaded."""

from __future__ import annotations

from hradiosity.io.cache import load_devices

DEVICES_FILE = "devices.json"
"""Of the cache folder: what is kept of each device."""


def load_builds(device: str) -> frozenset[str]:
    """Kernels that an earlier run had built for the device; their driver holds them."""
    return frozenset(load_devices(DEVICES_FILE).get(device, {}).get("builds", ()))

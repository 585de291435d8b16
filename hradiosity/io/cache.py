"""What is kept in the user's cache folder, by device; no result depends on it."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

from hradiosity.errors import OutputError
from hradiosity.io.output_folder import write_file

CACHE_VARIABLE = "HRADIOSITY_CACHE"


def cache_folder() -> Path:
    """Where measured speeds are kept: ``HRADIOSITY_CACHE``, else the user's cache folder."""
    named = os.environ.get(CACHE_VARIABLE)
    if named:
        return Path(named)
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "hradiosity"
    base = os.environ.get("LOCALAPPDATA") if sys.platform == "win32" else os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "hradiosity"


def load_devices(name: str) -> dict[str, dict[str, Any]]:
    """What the file `name` keeps of each device; nothing when there is no file or it is damaged."""
    try:
        found = json.loads((cache_folder() / name).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    devices = found.get("devices") if isinstance(found, dict) else None
    if not isinstance(devices, dict):
        return {}
    return {device: entry for device, entry in devices.items() if isinstance(entry, dict)}


def store_devices(name: str, kept: dict[str, dict[str, Any]]) -> bool:
    """Keep that in the file `name`; False when the cache can't be written, which harms nothing."""
    try:
        cache_folder().mkdir(parents=True, exist_ok=True)
        write_file(cache_folder() / name, json.dumps({"devices": kept}, indent=1).encode())
    except (OSError, OutputError):
        return False
    return True

"""How much memory a run adds to the process at its peak."""

from __future__ import annotations

import ctypes
import gc
from pathlib import Path
from typing import Final

_STATUS: Final = Path("/proc/self/status")
_RESET: Final = Path("/proc/self/clear_refs")
_RESET_PEAK: Final = "5"
"""Written there, it sets the recorded peak of the resident memory to its present size (``proc(5)``)."""


class PeakMemory:
    """Resident memory of this process above its size when this was made, where the system can tell."""

    def __init__(self) -> None:
        gc.collect()
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if _STATUS.exists() else None
        if trim is not None:
            trim(0)
        self._before: int | None = None
        try:
            _RESET.write_text(_RESET_PEAK, encoding="ascii")
            self._before = _resident("VmRSS")
        except OSError:
            return

    def added(self) -> int | None:
        """Bytes at the peak so far; None where the system keeps no peak that can be reset."""
        if self._before is None:
            return None
        return max(0, _resident("VmHWM") - self._before)


def _resident(entry: str) -> int:
    """Bytes of an entry of the process's status."""
    for line in _STATUS.read_text(encoding="ascii", errors="replace").splitlines():
        if line.startswith(f"{entry}:"):
            return 1024 * int(line.split()[1])
    raise OSError(f"{_STATUS} has no {entry}")

"""How much memory this machine can still give."""

from __future__ import annotations

from pathlib import Path
from typing import Final

_SYSTEM: Final = Path("/")
_MEMINFO: Final = "proc/meminfo"
_CONTAINERS: Final = (
    ("sys/fs/cgroup/memory.max", "sys/fs/cgroup/memory.current"),
    ("sys/fs/cgroup/memory/memory.limit_in_bytes", "sys/fs/cgroup/memory/memory.usage_in_bytes"),
)
"""Limit and use of memory of a container, by the second and the first version of control groups (``cgroups(7)``)."""


def available_host_bytes(root: Path = _SYSTEM) -> int | None:
    """Memory that this process can still take without swapping; None where the system does not tell.

    Parameters
    ----------
    root : Path
        Where ``proc`` and ``sys`` are.
    """
    known = [_of_machine(root / _MEMINFO), *(_of_container(root / most, root / used) for most, used in _CONTAINERS)]
    return min((amount for amount in known if amount is not None), default=None)


def _of_machine(path: Path) -> int | None:
    """``MemAvailable`` of the kernel (``proc(5)``)."""
    for line in _text(path).splitlines():
        if line.startswith("MemAvailable:"):
            return 1024 * int(line.split()[1])
    return None


def _of_container(most: Path, used: Path) -> int | None:
    limit, use = _text(most), _text(used)
    return max(0, int(limit) - int(use)) if limit.isdigit() and use.isdigit() else None


def _text(path: Path) -> str:
    """Content of a small file; empty where it can't be read."""
    try:
        return path.read_text(encoding="ascii", errors="replace").strip()
    except OSError:
        return ""

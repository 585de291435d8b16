"""How much memory this machine can still give."""

from __future__ import annotations

from pathlib import Path
from typing import Final

_SYSTEM: Final = Path("/")
_MEMINFO: Final = "proc/meminfo"
_CONTAINERS: Final = (
    ("sys/fs/cgroup/memory.max", "sys/fs/cgroup/memory.current", "sys/fs/cgroup/memory.stat", "inactive_file"),
    (
        "sys/fs/cgroup/memory/memory.limit_in_bytes",
        "sys/fs/cgroup/memory/memory.usage_in_bytes",
        "sys/fs/cgroup/memory/memory.stat",
        "total_inactive_file",
    ),
)
"""Limit and use of memory of a container, by the second and the first version of control groups (``cgroups(7)``), and
what of the use are files that can be read again."""


def available_host_bytes(root: Path = _SYSTEM) -> int | None:
    """Memory that this process can still take without swapping; None where the system does not tell.

    Parameters
    ----------
    root : Path
        Where ``proc`` and ``sys`` are.
    """
    known = [_entry(root / _MEMINFO, "MemAvailable:", 1024), *(_of_container(root, *names) for names in _CONTAINERS)]
    return min((amount for amount in known if amount is not None), default=None)


def _of_container(root: Path, most: str, used: str, stat: str, cached: str) -> int | None:
    limit, use = _text(root / most), _text(root / used)
    if not (limit.isdigit() and use.isdigit()):
        return None
    return max(0, int(limit) - int(use) + (_entry(root / stat, cached, 1) or 0))


def _entry(path: Path, name: str, unit: int) -> int | None:
    """Bytes that a file of names and numbers tells (``MemAvailable`` of ``proc(5)``); None if it does not."""
    for line in _text(path).splitlines():
        words = line.split()
        if len(words) > 1 and words[0] == name and words[1].isdigit():
            return unit * int(words[1])
    return None


def _text(path: Path) -> str:
    """Content of a small file; empty where it can't be read."""
    try:
        return path.read_text(encoding="ascii", errors="replace").strip()
    except OSError:
        return ""

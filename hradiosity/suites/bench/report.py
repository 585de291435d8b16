"""A run as a value, and as JSON."""

from __future__ import annotations

import json
import math
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Final

from hradiosity.suites.bench.figure import Figure

FORMAT: Final = 1
_PACKAGES: Final = ("hradiosity", "numpy", "pyopencl", "pocl-binary-distribution")
PEERS: Final = ("embreex", "pyviewfactor", "mitsuba", "pyradiance")


@dataclass(frozen=True)
class Report:
    """Figures with all that one has to know to compare them.

    versions : of Python, of this package and of what it is measured with and against, by name
    device : the OpenCL device
    machine : processor, cores that may be used, system; nothing that tells whose it is
    date : ISO 8601, UTC
    quick : with few repeats and small cases
    notes : what was left out
    """

    versions: dict[str, str]
    device: str
    machine: dict[str, str]
    date: str
    quick: bool
    figures: tuple[Figure, ...]
    notes: tuple[str, ...]


def make_report(figures: Sequence[Figure], notes: Sequence[str], *, device: str, quick: bool) -> Report:
    """The figures of a run that ends now, on this machine."""
    versions = {"python": platform.python_version()}
    for name in (*_PACKAGES, *PEERS):
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            continue
    date = datetime.now(UTC).isoformat(timespec="seconds")
    return Report(versions, device, describe_machine(), date, quick, tuple(figures), tuple(notes))


def describe_machine() -> dict[str, str]:
    """Processor, cores and system, without names of hosts, users or folders."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    system = f"{platform.system()} on {platform.machine()}"
    return {"processor": _processor(), "cores": str(usable), "system": system}


def _processor() -> str:
    listing = Path("/proc/cpuinfo")
    if listing.is_file():
        for line in listing.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or "unknown"


def to_json(report: Report) -> str:
    """Text that `from_json` reads back to an equal value."""
    return json.dumps({"format": FORMAT} | asdict(report), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def from_json(text: str) -> Report:
    """A kept run.

    Raises
    ------
    ValueError
        When the text is no such report, and says where.
    """
    kept = json.loads(text)
    if not isinstance(kept, dict) or kept.pop("format", None) != FORMAT:
        raise ValueError(f"no benchmark report of format {FORMAT}")
    try:
        figures = tuple(_figure(entry) for entry in kept.pop("figures"))
        return Report(figures=figures, notes=tuple(kept.pop("notes")), **kept)
    except (TypeError, KeyError) as error:
        raise ValueError(f"a benchmark report with other entries than expected: {error}") from error


def _figure(entry: dict[str, Any]) -> Figure:
    spread = entry["spread"]
    return Figure(
        str(entry["name"]), float(entry["value"]), str(entry["unit"]), None if spread is None else float(spread)
    )


def table(report: Report) -> str:
    """The figures as text, a section after the other."""
    width = max((len(f.name) for f in report.figures), default=0)
    lines = [f"{f.name:{width}}  {number(f.value):>9} {_spread(f.spread):>11}  {f.unit}" for f in report.figures]
    return "\n".join([*lines, *report.notes])


def number(value: float) -> str:
    """Three digits."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    return f"{value:.2e}" if abs(value) < 1e-3 else f"{value:#.3g}" if abs(value) < 999.5 else f"{value:.0f}"


def _spread(spread: float | None) -> str:
    return "once" if spread is None else "" if spread == 0.0 else f"± {number(spread)}"

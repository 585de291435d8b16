"""What can be measured, by name."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from hradiosity.suites.bench.figure import Figure

if TYPE_CHECKING:
    from hradiosity.suites.bench.session import Session

SECTIONS: Final = ("rays", "bvh", "form-factors", "solvers", "scenes", "start", "peers")
"""In the order in which they run."""


def choose(text: str | None) -> list[str]:
    """Names of sections, in the order of `SECTIONS`, from a list with commas; all without one.

    Raises
    ------
    ValueError
        When a name is unknown; all such names are told, with what may have been meant.
    """
    if text is None:
        return list(SECTIONS)
    wanted = [name.strip() for name in text.split(",")]
    faults = [_unknown(name) for name in wanted if name not in SECTIONS]
    if faults:
        raise ValueError("; ".join(faults))
    return [name for name in SECTIONS if name in wanted]


def _unknown(name: str) -> str:
    near = difflib.get_close_matches(name, SECTIONS, 1, 0.4)
    meant = f"did you mean {near[0]!r}? " if near else ""
    return f"{name!r} is no section: {meant}there are {', '.join(SECTIONS)}"


def measure(name: str, session: Session) -> list[Figure]:
    """Figures of one section, whose modules are imported only now: help and comparisons need none of them."""
    from hradiosity.suites import bench_form_factors, bench_rays, bench_solvers
    from hradiosity.suites.bench import peers, scenes, start, structure

    measures: dict[str, Callable[[Session], list[Figure]]] = {
        "rays": bench_rays.measure,
        "bvh": structure.measure,
        "form-factors": bench_form_factors.measure,
        "solvers": bench_solvers.measure,
        "scenes": scenes.measure,
        "start": start.measure,
        "peers": peers.measure,
    }
    return measures[name](session)

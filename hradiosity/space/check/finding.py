"""What a check finds, as a value, and how faults stop a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.model.scene import Note, Scene

Severity = Literal["fault", "warning", "info"]
SEVERITIES: tuple[Severity, ...] = ("fault", "warning", "info")
"""From the gravest to the mildest."""
MOST_OF_A_KIND = 12
"""Findings of one kind that are listed one by one; the rest is counted in the last of them."""


@dataclass(frozen=True, eq=False)
class Finding:
    """One thing about a loaded scene that is wrong, doubtful or worth knowing.

    kind : stable name, for example ``coincident-surfaces``
    severity : "fault" stops a run; "warning" when a number may be wrong; "info" otherwise
    object : name of the object, sensor, view, luminaire or material that it is about
    place : (3,) float64 [m], where to look; nan where it has no place
    size : how large the thing is [m]; 0 where it has no size
    message : what was found, naming everything that takes part
    effect : what it does to the result
    fix : what to do about it; empty when there is nothing to do
    patches : numbers of the patches that it is about, where there are any; of two in one place the smaller one
    """

    kind: str
    severity: Severity
    object: str
    place: NDArray[np.float64]
    size: float
    message: str
    effect: str
    fix: str
    patches: tuple[int, ...] = ()

    def __str__(self) -> str:
        sentences = (self.message, self.effect, self.fix)
        return "; ".join(sentence for sentence in sentences if sentence)

    def as_json(self) -> dict[str, Any]:
        """Plain values for ``run.json`` and ``--json``; a finding without a place has null there."""
        place = [float(x) for x in self.place] if np.isfinite(self.place).all() else None
        return {
            "kind": self.kind,
            "severity": self.severity,
            "object": self.object,
            "place": place,
            "size": float(self.size),
            "message": self.message,
            "effect": self.effect,
            "fix": self.fix,
        }

    def as_note(self) -> Note:
        """The same as a note beside those of the loader; for warnings and infos."""
        return Note("warning" if self.severity == "warning" else "info", self.object, str(self))


def numbers(patches: NDArray[np.integer]) -> tuple[int, ...]:
    """Patch numbers as a finding holds them: ascending, each once."""
    return tuple(np.unique(patches).tolist())


def nowhere() -> NDArray[np.float64]:
    """Place of a finding that has none."""
    return np.full(3, np.nan)


def at(place: NDArray[np.float64]) -> str:
    """A place as words: ``(1.20, 0.40, 0.72) m``."""
    return f"({', '.join(f'{x:.4g}' for x in place)}) m"


def raise_faults(findings: Sequence[Finding], scene: Scene) -> None:
    """Raise ``SceneError`` with every finding that is a fault, if there is one."""
    file = scene.name if scene.path is None else str(scene.path)
    faults = [
        Fault(file, f.object, f.message, "; ".join(part for part in (f.effect, f.fix) if part))
        for f in findings
        if f.severity == "fault"
    ]
    if faults:
        raise SceneError(faults)


def ordered(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Gravest first, then by kind, then by size; of each kind at most `MOST_OF_A_KIND`, the last counting the rest."""
    ranked = sorted(findings, key=lambda f: (SEVERITIES.index(f.severity), f.kind, -f.size, f.object))
    kept: list[Finding] = []
    count: dict[tuple[str, str], int] = {}
    last: dict[tuple[str, str], int] = {}
    key: tuple[str, str]
    for finding in ranked:
        key = (finding.severity, finding.kind)
        count[key] = count.get(key, 0) + 1
        if count[key] <= MOST_OF_A_KIND:
            last[key] = len(kept)
            kept.append(finding)
    for key, number in count.items():
        if number > MOST_OF_A_KIND:
            end = kept[last[key]]
            kept[last[key]] = replace(end, message=f"{end.message}; and {number - MOST_OF_A_KIND} more of this kind")
    return tuple(kept)

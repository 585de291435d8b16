"""What a validation case is, and what came of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from hradiosity.device import Device
from hradiosity.options import Options, Quality
from hradiosity.solution import Solution

SENSOR = "points"
"""Name of the sensor that stands in the scene of every case."""


@dataclass(frozen=True)
class Job:
    """A scene as a user would write it, and how it is solved.

    text : content of scene.toml
    files : further files of its folder, name and content
    effort : options in which the case departs from the defaults so as to reach its bar; a quality that is asked for
        takes their place
    fixed : options that belong to the case, whatever the quality
    """

    text: str
    files: tuple[tuple[str, str], ...] = ()
    effort: tuple[tuple[str, Any], ...] = ()
    fixed: tuple[tuple[str, Any], ...] = ()

    def options(self, quality: Quality | None) -> Options:
        """Settings of a run, by the case's own effort if no quality is given."""
        if quality is None:
            return Options(**dict(self.effort + self.fixed))
        return Options.of_quality(quality, **dict(self.fixed))

    def settings(self, quality: Quality | None) -> str:
        """What differs from the defaults, in words."""
        changed = [f"{name} = {value}" for name, value in (self.effort if quality is None else ()) + self.fixed]
        return ", ".join(([f"quality {quality}"] if quality else []) + changed) or "defaults"


class Bench(Protocol):
    """Where cases are measured."""

    @property
    def device(self) -> Device:
        """On which kernels run."""

    def solve(self, job: Job) -> Solution:
        """Load the scene, solve it; the same job is solved once."""


@dataclass(frozen=True)
class Measured:
    """A number of ours; half_width: of its 95 % interval, None if it has none."""

    value: float
    half_width: float | None = None


@dataclass(frozen=True)
class Point:
    """One number that is known.

    tolerance : largest deviation that passes, relative
    curve : points that follow one another on one curve have the same; drawings join them
    """

    name: str
    reference: float
    tolerance: float
    curve: str = ""


@dataclass(frozen=True)
class Case:
    """Some known numbers, and how ours are found.

    group : heading under which reports show it
    quantity, unit : what the numbers are
    measure : gives a number for each point, in their order
    jobs : scenes that `measure` solves
    note : how the scene stands for the case, above all where it departs from its wording
    """

    name: str
    title: str
    group: str
    quantity: str
    unit: str
    points: tuple[Point, ...]
    measure: Callable[[Bench], Sequence[Measured]]
    jobs: tuple[Job, ...] = ()
    note: str = ""


@dataclass(frozen=True)
class NotRun:
    """A case that this program cannot express, and why."""

    name: str
    reason: str


@dataclass(frozen=True)
class Row:
    """One point's verdict.

    base : what deviations are relative to: the reference, or the mean of the case's references where it is 0
    """

    point: str
    value: float
    reference: float
    base: float
    half_width: float | None
    tolerance: float

    @property
    def deviation(self) -> float:
        """Value less reference, relative."""
        return (self.value - self.reference) / self.base

    @property
    def relative_half_width(self) -> float | None:
        """Half width, relative."""
        return None if self.half_width is None else self.half_width / self.base

    @property
    def passed(self) -> bool:
        """Whether the deviation stays within the tolerance; a number that is none does not."""
        return abs(self.deviation) <= self.tolerance


@dataclass(frozen=True)
class CaseResult:
    """What came of a case; seconds: wall time."""

    case: Case
    rows: tuple[Row, ...]
    seconds: float
    settings: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether all points do."""
        return all(row.passed for row in self.rows)

    @property
    def worst(self) -> Row:
        """The row that uses most of its tolerance."""
        return max(self.rows, key=lambda row: _share(row))


def _share(row: Row) -> float:
    used = abs(row.deviation) / row.tolerance
    return used if used == used else float("inf")


@dataclass(frozen=True)
class Outcome:
    """What came of all cases.

    about : device, versions, time, quality, by name
    """

    results: tuple[CaseResult, ...]
    not_run: tuple[NotRun, ...]
    seconds: float
    about: Mapping[str, str] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """Whether all cases do."""
        return all(result.passed for result in self.results)

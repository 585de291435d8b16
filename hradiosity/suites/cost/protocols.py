"""What a measurement needs of the machine that it runs on, and what it tells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from hradiosity.model.scene import Scene
from hradiosity.plan import Plan
from hradiosity.solution import Readings
from hradiosity.suites.cost.settings import Setting
from hradiosity.suites.cost.values import Run


class Reference(Protocol):
    """See `hradiosity.suites.cost.reference.GrowingReference`."""

    @property
    def paths(self) -> int:
        """So far."""
        ...

    def advance(self, seconds: float) -> bool:
        """One round."""
        ...

    def noise(self) -> float:
        """Of the illuminances."""
        ...

    def readings(self) -> dict[str, Readings]:
        """So far."""
        ...


class Bench(Protocol):
    """See `hradiosity.suites.cost.bench.SceneBench`."""

    @property
    def reference(self) -> Reference:
        """The referee."""
        ...

    def clock(self) -> float:
        """Wall seconds."""
        ...

    def guess(self, setting: Setting) -> float | None:
        """Predicted wall seconds."""
        ...

    def start(self, setting: Setting, seed: int = 0, scene: Scene | None = None) -> Any:
        """Geometry and plan."""
        ...

    def finish(self, started: Any) -> Run:
        """The rest."""
        ...

    def learn(self, run: Run, plan: Plan) -> None:
        """Predict from this run."""
        ...


@dataclass(frozen=True)
class Event:
    """Something happened.

    kind : "run", "skipped", "reference", "solver", "effect" or "bands"
    """

    kind: str
    values: dict[str, Any]

"""What somebody sees who watches a run solve: the light of the elements step by step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from hradiosity.model.scene import Scene
from hradiosity.solution import Surfaces
from hradiosity.solvers.result import Progress
from hradiosity.space.hierarchy import Elements


@dataclass(frozen=True)
class Glimpse:
    """Where a solver stands; looking never changes a bit of what it finds.

    scene, elements : that the light belongs to
    progress : Progress
    replicates : done before this one
    surfaces : () → the light so far, mean with that of the replicates before; computed when asked for
    """

    scene: Scene
    elements: Elements
    progress: Progress
    replicates: int
    surfaces: Callable[[], Surfaces]


LightWatch: TypeAlias = Callable[[Glimpse], None]

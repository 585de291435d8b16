"""Where a run stands: what a display draws, a test reads and an interruption keeps."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class State:
    """Where a run stands.

    stage : what was just finished
    replicate, replicates : done, and wanted so far
    seconds : wall seconds since the start
    error, median_error : largest and median half width over value of all readings (see `Readings.accuracy`);
        infinite before two replicates
    elements, rays : row elements, and rays traced so far
    unshot : relative residual of the last solution
    remaining : expected wall seconds to the end; None while nothing is known
    """

    stage: str
    replicate: int
    replicates: int
    seconds: float
    error: float
    median_error: float
    elements: int
    rays: int
    unshot: float
    remaining: float | None = None

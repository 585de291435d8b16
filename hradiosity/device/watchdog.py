"""Says which kernel seems to hang."""

from __future__ import annotations

import threading
import time
import warnings
import weakref
from collections import deque
from dataclasses import dataclass
from typing import Any, Final, Protocol

LONG: Final = 120.0
"""Seconds after which a kernel is spoken of, and again whenever they have doubled: no launch should take so long."""
LOOKS: Final = 8
"""Looks within that time."""
_COMPLETE: Final = 0
"""``CL_COMPLETE``; states below it are errors, states above it are still to come."""


class Event(Protocol):
    """What is asked of an OpenCL event."""

    @property
    def command_execution_status(self) -> Any:
        """A number, see `_COMPLETE`."""


@dataclass
class _Launch:
    """name, n_items : of the kernel; since : when it was enqueued or the launch before it was over; told : warnings."""

    name: str
    n_items: int
    event: Event
    since: float
    told: int = 0


class Watchdog:
    """Warns when the launch that a device works on takes longer than any should; does not stop it.

    A thread looks from time to time, from the first launch on, and ends when the object is gone. The queue works in
    order, so the first launch that isn't over is the one that runs.

    Parameters
    ----------
    device : str
        Name of the device, for the warning.
    long : float
        Seconds.
    """

    def __init__(self, device: str, long: float = LONG) -> None:
        self.long = long
        self._device = device
        self._launches: deque[_Launch] = deque()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    def note(self, name: str, n_items: int, event: Event) -> None:
        """Remember a launch that was just enqueued."""
        with self._lock:
            self._forget_complete()
            self._launches.append(_Launch(name, n_items, event, time.monotonic()))
        if self._thread is None:
            self._thread = threading.Thread(target=_keep_looking, args=(weakref.ref(self),), daemon=True)
            self._thread.start()

    def look(self) -> None:
        """Warn if the running launch has been at it for long (`RuntimeWarning`)."""
        with self._lock:
            self._forget_complete()
            if not self._launches:
                return
            running = self._launches[0]
            seconds = time.monotonic() - running.since
            if seconds < self.long * 2.0**running.told:
                return
            running.told += 1
        warnings.warn(
            f"kernel {running.name} with {running.n_items} work-items has been running for {seconds:.3g} s on "
            f"{self._device}: it may hang; go on waiting, or kill this process",
            RuntimeWarning,
            stacklevel=2,
        )

    def _forget_complete(self) -> None:
        """Drop launches that are over; the next one runs from now on."""
        over = False
        while self._launches and self._launches[0].event.command_execution_status <= _COMPLETE:
            self._launches.popleft()
            over = True
        if over and self._launches:
            self._launches[0].since = time.monotonic()


def _keep_looking(watchdog: weakref.ref[Watchdog]) -> None:
    """Look as long as somebody else holds the watchdog."""
    while (held := watchdog()) is not None:
        pause = held.long / LOOKS
        held.look()
        del held
        time.sleep(pause)

"""What a run shows while it goes on: a live picture in a terminal, lines in a file, JSON for programs, or nothing."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from hradiosity.cli.text import count, error_curve, percent

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

    from hradiosity.radiosity.state import State

BUILDING = "building kernels for this device (once; later runs skip it)"


class Display:
    """Shows nothing; others show a run. Used as a context for the time that it goes on."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Stop drawing."""

    def follow(self, doing: Callable[[], str]) -> None:
        """From now on the solver is at work; `doing` names the stage that it is in."""

    def lines(self, lines: Sequence[str], *, title: str = "") -> None:
        """Lasting lines: plan, tables, remarks."""

    def building(self) -> None:
        """Kernels are being built, which takes a while."""

    def stage(self, name: str) -> None:
        """Something other than the solver goes on."""

    def state(self, state: State) -> None:
        """The solver got this far."""

    def data(self, event: str, values: dict[str, Any]) -> None:
        """Something for programs."""


class JsonDisplay(Display):
    """One JSON object a line on standard output; ``event`` says what it is."""

    def building(self) -> None:
        """As an event."""
        self.data("building kernels", {})

    def stage(self, name: str) -> None:
        """As an event."""
        self.data("stage", {"stage": name})

    def state(self, state: State) -> None:
        """As an event."""
        self.data("state", asdict(state))

    def data(self, event: str, values: dict[str, Any]) -> None:
        """One line."""
        from hradiosity.io.run_record import to_json

        print(to_json({"event": event, **values}), flush=True)


class PlainDisplay(Display):
    """Lines on standard output, for files and pipes."""

    def lines(self, lines: Sequence[str], *, title: str = "") -> None:
        """Under their title."""
        if title:
            print(f"\n{title}")
        for line in lines:
            print(f"  {line}" if title else line, flush=True)

    def building(self) -> None:
        """Once."""
        print(BUILDING, flush=True)

    def stage(self, name: str) -> None:
        """A line."""
        print(name, flush=True)

    def state(self, state: State) -> None:
        """A line."""
        print(f"{where(state)}: {', '.join(facts(state))}; {clock(state.seconds, state.remaining)}", flush=True)


class LiveDisplay(Display):
    """A few lines in the terminal that are drawn anew while the run goes on.

    Parameters
    ----------
    console : Console
    """

    def __init__(self, console: Console) -> None:
        from rich.live import Live
        from rich.spinner import Spinner

        self._console = console
        self._doing: Callable[[], str] = str
        self._name = ""
        self._building = False
        self._last: tuple[State, float] | None = None
        self._errors: list[tuple[float, float]] = []
        self._start = time.perf_counter()
        self._spinner = Spinner("dots")
        self._live = Live(
            console=console, get_renderable=self._render, refresh_per_second=8, transient=True, auto_refresh=True
        )

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def close(self) -> None:
        """Take the live part away."""
        self._live.stop()

    def follow(self, doing: Callable[[], str]) -> None:
        """Show what the solver does where nothing else goes on."""
        self._doing = doing

    def lines(self, lines: Sequence[str], *, title: str = "") -> None:
        """Above the live part."""
        from rich.text import Text

        text = Text(f"\n{title}\n" if title else "", style="bold")
        for line in lines:
            style = "not bold yellow" if line.startswith("warning:") else "not bold"
            text.append(f"  {line}\n" if title else f"{line}\n", style)
        if lines:
            self._console.print(text, soft_wrap=True, end="")

    def building(self) -> None:
        """In place of the stage, until the next state."""
        self._building = True

    def stage(self, name: str) -> None:
        """In place of the solver's stage."""
        self._name = name

    def state(self, state: State) -> None:
        """Draw from now on."""
        self._building = False
        self._name = ""
        self._last = (state, time.perf_counter())
        if math.isfinite(state.median_error):
            self._errors.append((state.seconds, state.median_error))

    def _render(self) -> RenderableType:
        from rich.console import Group
        from rich.progress_bar import ProgressBar
        from rich.table import Table
        from rich.text import Text

        name = BUILDING if self._building else self._name or self._doing() or "starting"
        self._spinner.update(text=Text(f" {name}", style="bold"))
        rows: list[RenderableType] = [self._spinner]
        now = time.perf_counter()
        if self._last is None:
            return Group(*rows, Text(f"  {clock(now - self._start)}", style="dim"))
        state, at = self._last
        left = None if state.remaining is None else max(0.0, state.remaining - (now - at))
        done = state.seconds + (now - at)
        if left is not None:
            bar = Table.grid(padding=(0, 2))
            bar.add_row("", ProgressBar(total=max(done + left, 1e-9), completed=done, width=40), where(state))
            rows.append(bar)
        else:
            rows.append(Text(f"  {where(state)}"))
        if self._errors:
            rows.append(Text(f"  {error_curve(self._errors)} median error, falling over {done:.0f} s"))
        rows += [Text(f"  {fact}", style="dim") for fact in facts(state)]
        return Group(*rows, Text(f"  {clock(done, left)}", style="dim"))


def where(state: State) -> str:
    """How far a run is."""
    if state.replicate:
        what = "further samples, " if state.stage == "further samples" else ""
        return f"{what}replicate {state.replicate} of {state.replicates}"
    return "larger replicates from here" if state.stage == "larger replicates" else "geometry ready"


def facts(state: State) -> list[str]:
    """Size, convergence and error."""
    found = [f"{count(state.elements)} elements"]
    if state.replicate:
        found.append(f"{count(state.rays)} rays")
        found.append(f"unshot {state.unshot:.1e}")
    if math.isfinite(state.error):
        found.append(f"error so far {percent(state.median_error)} median, {percent(state.error)} largest")
    return found


def clock(seconds: float, remaining: float | None = None) -> str:
    """Elapsed and expected time."""
    left = "" if not remaining else f", about {remaining:.{0 if remaining > 9.5 else 1}f} s to go"
    return f"{seconds:.1f} s{left}"


def open_display(*, quiet: bool, json: bool) -> Display:
    """The display that fits the options and the terminal."""
    if quiet:
        return Display()
    if json:
        return JsonDisplay()
    from rich.console import Console

    console = Console(highlight=False)
    return LiveDisplay(console) if console.is_terminal else PlainDisplay()

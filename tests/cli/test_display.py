"""What is shown while a run goes on."""

import io

from rich.console import Console

from hradiosity.cli.display import Expectation, LiveDisplay, PlainDisplay, clock
from hradiosity.radiosity.state import State


def state(replicate, seconds, *, replicates=4, error=0.1):
    return State("replicate", replicate, replicates, seconds, error, error / 2, 1000, 2_000_000, 1e-4)


def test_expectation_from_the_pace_of_the_replicates():
    expected = Expectation(accuracy=None, limit=None)
    assert expected.remaining(state(0, 1.0)) is None
    assert expected.remaining(state(1, 3.0)) == 6.0
    assert expected.remaining(state(4, 9.0)) == 0.0


def test_expectation_from_the_accuracy():
    """Half the error takes four times the replicates."""
    expected = Expectation(accuracy=0.05, limit=None)
    expected.remaining(state(0, 0.0))
    assert expected.remaining(state(4, 4.0, error=0.1)) == 12.0


def test_expectation_is_bounded_by_the_time():
    expected = Expectation(accuracy=0.001, limit=10.0)
    expected.remaining(state(0, 0.0))
    assert expected.remaining(state(4, 4.0)) == 7.0  # up to the limit, and the replicate that is then running


def test_plain_lines(capsys):
    shown = PlainDisplay()
    shown.state(state(2, 3.0), 4.0)
    assert capsys.readouterr().out == (
        "replicate 2 of 4: 1 000 elements, 2 million rays, unshot 1.0e-04, "
        "error so far 5 % median, 10 % largest; 3.0 s, about 4.0 s to go\n"
    )


def test_clock():
    assert clock(1.0) == "1.0 s"
    assert clock(1.0, 12.3) == "1.0 s, about 12 s to go"


def test_live_display_shows_stage_and_progress_and_leaves_lasting_lines_only():
    text = io.StringIO()
    console = Console(file=text, force_terminal=True, width=100, highlight=False)
    with LiveDisplay(console, lambda: "exchange rays") as shown:
        shown.lines(["occlusion computed"], title="Plan")
        shown.building()
        shown._live.refresh()
        shown.state(state(2, 3.0), 4.0)
        shown._live.refresh()
    written = text.getvalue()
    for part in ("Plan", "occlusion computed", "building kernels", "exchange rays", "replicate 2 of 4", "2 million"):
        assert part in written
    assert written.rstrip().endswith("\x1b[2K")  # the live part is taken away

"""What is shown while a run goes on."""

import io

from rich.console import Console

from hradiosity.cli.display import LiveDisplay, PlainDisplay, clock
from hradiosity.cli.text import error_curve
from hradiosity.radiosity.state import State


def state(replicate, seconds, *, replicates=4, error=0.1, remaining=None):
    return State("replicate", replicate, replicates, seconds, error, error / 2, 1000, 2_000_000, 1e-4, remaining)


def test_error_curve_falls_from_left_to_right_on_a_logarithmic_scale():
    curve = error_curve([(1.0, 0.1), (2.0, 0.01), (4.0, 0.001)], width=8)
    assert len(curve) == 8 and curve[-1] == "▁" and curve[2] == "█" and curve[:2] == "  "
    assert "█" > curve[4] > "▁"
    assert error_curve([(0.0, 0.1)], width=3) == "▁▁▁"


def test_plain_lines(capsys):
    shown = PlainDisplay()
    shown.state(state(2, 3.0, remaining=4.0))
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
    with LiveDisplay(console) as shown:
        shown.follow(lambda: "exchange rays")
        shown.lines(["occlusion computed"], title="Plan")
        shown.building()
        shown._live.refresh()
        shown.state(state(2, 3.0, remaining=4.0))
        shown._live.refresh()
    written = text.getvalue()
    parts = ("Plan", "occlusion computed", "building kernels", "exchange rays", "replicate 2 of 4", "2 million")
    for part in (*parts, "falling"):
        assert part in written
    assert written.rstrip().endswith("\x1b[2K")  # the live part is taken away

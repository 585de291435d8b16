"""What bands that end early leave out of each number is told before and after a run, and kept with it."""

import json

import pytest
from cli_room import QUICK

FIRST_TO_LAST = "first = 400, last = 720, step = 40"


def with_bands(room, bands):
    file = room / "scene.toml"
    file.write_text(file.read_text().replace(FIRST_TO_LAST, bands))


def test_red_bands_tell_what_they_leave_out(room, call, tmp_path):
    with_bands(room, "edges = [580, 680, 780]")
    planned = call("plan", room)
    assert planned.code == 0
    told = {line.split(":")[0] for line in planned.out.splitlines() if "outside the bands (580 to 780 nm)" in line}
    assert {"illuminance", "melanopic EDI and DER", "Rf, Rg"} <= told
    shares = json.loads(call("plan", room, "--json").out)["outside_bands"]
    assert shares["melanopic EDI and DER"] > 0.99
    assert 0.4 < shares["illuminance"] < 0.7
    rendered = call("render", room, "-o", tmp_path / "out", "--no-audit", *QUICK)
    assert rendered.code == 0
    closing = next(line for line in rendered.out.splitlines() if "580 to 780 nm leave out" in line)
    assert "melanopic EDI and DER 100 %" in closing
    assert f"illuminance {100 * shares['illuminance']:.2g} %" in closing
    assert json.loads((tmp_path / "out" / "run.json").read_text())["plan"]["outside_bands"] == shares


@pytest.mark.parametrize(
    ("bands", "told"),
    [
        ("first = 380, last = 780, step = 20", []),
        ("first = 410, last = 690, step = 20", ["Rf, Rg", "x, y"]),
    ],
)
def test_only_what_is_worth_a_line(room, call, bands, told):
    with_bands(room, bands)
    lines = [line for line in call("plan", room).out.splitlines() if "outside the bands" in line]
    assert not [line for line in lines if line.startswith(("illuminance", "melanopic"))]
    for name in told:
        assert any(line.startswith(name) for line in lines), name
    assert bool(lines) == bool(told)

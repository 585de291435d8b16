"""Long scene files are read as ``tomllib`` reads them, or left to it."""

import tomllib
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hradiosity.io.scene import quick_toml
from hradiosity.io.scene.quick_toml import parse

ROOT = Path(__file__).resolve().parents[2]
ONE = """[[box]]
name = "box {k}"
corner = [{k}, -0.5, 1e-3]
size = [1, 2.5, 0.{k}]
material = "wall"
inside = true
faces = {{ top = "wall", front = "wall = 1, x" }}
omit = ["left", "right"]

"""
BOXES = "".join(ONE.format(k=k) for k in range(300))
HEAD = '[scene]\nunit = "m"  # of all lengths\nup = "z"\n[materials.wall]\nreflectance = 0.5\n\n'
LINES = (
    *("[[box]]", "[box]", "[[box.faces]]", 'name = "a"', 'name = "a\\u0041"', "x.y = 1", "name = 07", "size = [1, 2,]"),
    *("a = [", "[[1]]", "]", "[1]]", "x = 1_000", "x = +1", "x = nan", "x = 'b'", "# note", 'x = "#"', "x = 1 # note"),
    *("box = 1", "x = [\"a\", 'b']", "x = { y = 1 }", 'x = { y = "1", y = "2" }', 'x = { y = "a" }', "x = 1979-05-27"),
    *("x = 0.5", " x = 2", "[[ box ]]", 'x = """', "\tx = 1", 'x = ["a", 1]', "x = [", "1]", "[[lamp]]", "x = [ # ]"),
)


def outcome(text):
    try:
        return tomllib.loads(text)
    except ValueError:
        return ValueError


@pytest.fixture(scope="module", autouse=True)
def every_length():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(quick_toml, "SHORT", 0)
        yield


@pytest.mark.parametrize("file", sorted(ROOT.glob("scenes/*/*.toml")), ids=lambda file: file.parent.name)
def test_scenes_are_read_alike(file):
    text = file.read_text(encoding="utf-8")
    assert parse(text) == tomllib.loads(text)


def test_plain_entries_need_no_other_parser(monkeypatch):
    expected, seen = tomllib.loads(HEAD + BOXES), []
    loads = tomllib.loads
    monkeypatch.setattr(quick_toml.tomllib, "loads", lambda text: seen.append(len(text)) or loads(text))
    assert parse(HEAD + BOXES) == expected
    assert seen == [len(seen) and seen[0]] and seen[0] < 2 * len(HEAD)


@given(st.lists(st.sampled_from(LINES), max_size=8), st.integers(0, 12))
def test_what_is_not_plain_is_read_or_refused_alike(lines, place):
    written = (HEAD + BOXES[: BOXES.index("[[box]]", 400)]).split("\n")
    text = "\n".join([*written[:place], *lines, *written[place:], *lines])
    found = outcome(text)
    if found is ValueError:
        with pytest.raises(ValueError):
            parse(text)
    else:
        assert repr(sorted(parse(text).items(), key=str)) == repr(sorted(found.items(), key=str))


@settings(max_examples=400)
@example(["a = [", "[[box]]", "[[box]]", "]"])
@example(["a = [", "[[box]]", "[1]]"])
@example(["[[box]]", "[box.faces]", 'x = "a"'])
@example(["[[box]]", 'x = { y = "1", y = "2" }'])
@given(st.lists(st.sampled_from(LINES), max_size=7))
def test_any_lines_are_read_or_refused_alike(lines):
    text = "\n".join(lines)
    found = outcome(text)
    if found is ValueError:
        with pytest.raises(ValueError):
            parse(text)
    else:
        assert repr(sorted(parse(text).items(), key=str)) == repr(sorted(found.items(), key=str))

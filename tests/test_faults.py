"""Faults as sentences."""

import pytest

from hradiosity.errors import LONGEST_EXPECTED, LONGEST_FOUND, Fault, SceneError


def test_a_fault_is_one_sentence_with_its_place():
    assert str(Fault("a.toml", "walls.colour", "'red'", "a number")) == "a.toml: walls.colour: 'red'; a number"
    assert str(Fault("a.toml", "", "nothing", "")) == "a.toml: nothing"


@pytest.mark.parametrize("field", ["file", "entry", "found", "expected"])
def test_what_is_too_long_to_be_read_keeps_both_ends(field):
    values = {"file": "a.toml", "entry": "walls", "found": "'red'", "expected": "a number"}
    fault = Fault(**{**values, field: "begin" + 5000 * "x" + "end"})
    text = str(SceneError([fault]))
    assert len(text) < LONGEST_FOUND + LONGEST_EXPECTED
    assert all(value in text for name, value in values.items() if name != field)
    assert "beginxxx" in text and "xxxend" in text and "[… 5008 characters …]" in text
    assert getattr(fault, field) == "begin" + 5000 * "x" + "end"


def test_lists_of_names_stay_whole():
    names = ", ".join(f"material {k}" for k in range(90))
    assert str(Fault("a.toml", "", "'x'", names)) == f"a.toml: 'x'; {names}"

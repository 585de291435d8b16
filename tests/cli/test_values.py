"""Percentages and durations as people write them."""

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hradiosity.cli.text import percent, plus_minus
from hradiosity.cli.values import Switch, seconds, share


def tokens(text):
    return [SimpleNamespace(value=text)]


@pytest.mark.parametrize(
    ("text", "value"), [("1%", 0.01), ("0.01", 0.01), ("2.5 %", 0.025), ("1e-3", 0.001), (".5%", 0.005)]
)
def test_share(text, value):
    assert share(float, tokens(text)) == pytest.approx(value)


@pytest.mark.parametrize(
    ("text", "value"), [("30s", 30), ("30", 30), ("2min", 120), ("2 m", 120), ("1.5h", 5400), ("5 sec", 5)]
)
def test_seconds(text, value):
    assert seconds(float, tokens(text)) == pytest.approx(value)


@given(st.text(max_size=8))
def test_whatever_is_written_gives_a_value_in_range_or_a_sentence(text):
    for convert, high in ((share, 1.0), (seconds, float("inf"))):
        try:
            assert 0.0 < convert(float, tokens(text)) < high
        except ValueError as error:
            assert repr(text)[1:-1] in str(error) or text in str(error)


def test_switch():
    assert [Switch(word).forced for word in ("auto", "on", "off")] == [None, True, False]


@pytest.mark.parametrize(
    ("value", "half_width", "words"),
    [
        (514.67, 3.14, "514.7 ± 3.1"),
        (1234.5, 123.0, "1234 ± 123"),
        (0.2312, 0.0161, "0.231 ± 0.016"),
        (5.0, 0.0, "5 ± 0"),
        (12.3456, float("inf"), "12.35 ± ?"),
    ],
)
def test_plus_minus(value, half_width, words):
    assert plus_minus(value, half_width) == words


@pytest.mark.parametrize(("value", "words"), [(0.012, "1.2 %"), (1.987, "199 %"), (float("inf"), "?")])
def test_percent(value, words):
    assert percent(value) == words


def test_percent_is_suggested_only_where_it_helps():
    with pytest.raises(ValueError, match="did you mean 5%"):
        share(float, tokens("5"))
    with pytest.raises(ValueError) as refused:
        share(float, tokens("0"))
    assert "did you mean" not in str(refused.value)

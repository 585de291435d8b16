"""Entries of a TOML file are found in its text."""

import tomllib

from hradiosity.io.scene.lines import find_lines, line_of

TEXT = """# a remark
[scene]
unit = "m"   # [not.a.header]

[materials."oak table"]
reflectance = { file = "oak.csv" }
materials.x = 1

[[box]]
size = [
    1, 2,
    3,
]
[[box]]   # the second
"quoted key" = 1
[[box]]
faces.top = "a"
"""


def test_lines():
    tomllib.loads(TEXT)
    lines = find_lines(TEXT)
    assert lines["scene",] == 2
    assert lines["scene", "unit"] == 3
    assert lines["materials", "oak table"] == 5
    assert lines["box", 0, "size"] == 10
    assert lines["box", 1] == 14
    assert lines["box", 1, "quoted key"] == 15
    assert lines["box", 2, "faces", "top"] == 17


def test_the_closest_entry_around_one_that_has_no_line():
    lines = find_lines(TEXT)
    assert line_of(lines, ("materials", "oak table", "reflectance", "column")) == 6
    assert line_of(lines, ("box", 1, "size")) == 14
    assert line_of(lines, ("sky", "kind")) is None

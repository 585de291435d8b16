"""A small room for the tests of the program."""

from small_room import SHELL

ROOM = f"""
[scene]
title = "Small room"
{SHELL}
[[sensor]]
name = "desk, left"
kind = "grid"
corner = [0.3, 0.3, 0.8]
edge_u = [2.4, 0.0, 0.0]
edge_v = [0.0, 1.4, 0.0]
counts = [3, 2]

[[sensor]]
name = "wall"
kind = "points"
positions = [[1.5, 0.001, 1.2]]
normal = [0.0, 1.0, 0.0]
"""
QUICK = (
    *("--element-size", "0.7", "--rays-per-element", "64", "--light-points", "16"),
    *("--gather-samples", "64", "--light-samples", "16", "--no-pictures"),
)
"""Settings with which it takes a moment."""
VIEW = """
[[view]]
name = "door"
position = [0.2, 0.2, 1.6]
target = [2.0, 1.5, 1.0]
size = [40, 30]
"""
PICTURES = tuple(word for word in QUICK if word != "--no-pictures")
"""The same with pictures."""

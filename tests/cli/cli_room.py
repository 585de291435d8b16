"""A small room for the tests of the program."""

ROOM = """
[scene]
title = "Small room"
unit = "m"
bands = { first = 400, last = 720, step = 40 }

[materials.wall]
reflectance = { steps = [[380, 560, 0.3], [560, 740, 0.6]] }

[materials.floor]
reflectance = 0.2

[luminaires.lamp]
spectrum = { illuminant = "A" }
luminous_flux_lm = 1000

[[box]]
name = "room"
corner = [0.0, 0.0, 0.0]
size = [3.0, 2.0, 2.5]
inside = true
faces = { sides = "wall", top = "wall", bottom = "floor" }

[[rectangle]]
name = "lamp"
corner = [1.0, 0.5, 2.4]
edge_u = [0.0, 1.0, 0.0]
edge_v = [1.0, 0.0, 0.0]
material = "wall"
luminaire = "lamp"

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

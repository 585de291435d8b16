"""A closed room of two paints with a lamp, as the text of a scene: what several rooms of tests begin with."""

SHELL = """\
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
"""
"""To follow a title in ``[scene]``."""

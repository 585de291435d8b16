"""Polygons and the published catalogue that tests of form factors share."""

import numpy as np

from hradiosity.suites.validation.data import form_factors

CATALOGUE = form_factors()
PAIRS = [entry for entry in CATALOGUE if entry["kind"] == "polygon-polygon"]
POINTS = [entry for entry in CATALOGUE if entry["kind"] == "point-polygon"]
DISKS = [entry for entry in CATALOGUE if entry["kind"] == "disk-disk"]
BLOCKED = {entry["id"]: float(entry["F12"]) for entry in CATALOGUE if entry["category"] == "occluded"}

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)


def corners(entry, key):
    return np.array(entry[key], float)


def catalogue_polygons():
    """Polygons a and b of all pairs of the catalogue, and F from a to b."""
    a, b = ([corners(entry, key) for entry in PAIRS] for key in ("poly1", "poly2"))
    return a, b, np.array([float(entry["F12"]) for entry in PAIRS])


def perimeter(polygon):
    """Length of all edges of a polygon (k, 3)."""
    return np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1).sum()


def facing_square(gap, shift=(0.0, 0.0), side=1.0):
    """A square that looks down on the unit square."""
    return (SQUARE[::-1] * side) + [*shift, gap]


def hinged_square(degrees):
    """Shares the edge x = 0 with the unit square, at a dihedral angle."""
    t = np.radians(degrees)
    far = np.array([np.cos(t), 0.0, np.sin(t)])
    return np.array([[0, 0, 0], [0, 1, 0], [0, 1, 0] + far, far])


def box_quads(cells, size=(1.0, 1.0, 1.0)):
    """Inside of a box, each face cut into cells × cells: (6 cells², 4, 3)."""
    x, y, z = np.diag(np.array(size, float))
    faces = [(0 * x, x, y), (z, y, x), (0 * x, y, z), (x, z, y), (0 * x, z, x), (y, x, z)]
    i, j = (grid.reshape(-1, 1, 1) for grid in np.meshgrid(*[np.arange(cells)] * 2, indexing="ij"))
    u, v = (np.array(c).reshape(1, 4, 1) for c in ([0, 1, 1, 0], [0, 0, 1, 1]))
    return np.concatenate([o + (i + u) / cells * eu + (j + v) / cells * ev for o, eu, ev in faces])


def ngon(n, radius, height=0.0, *, down=False):
    """Regular polygon about the z axis whose area is that of the disk of that radius."""
    angle = 2 * np.pi * np.arange(n) / n
    r = radius * np.sqrt(2 * np.pi / n / np.sin(2 * np.pi / n))
    ring = np.stack([r * np.cos(angle), r * np.sin(angle), np.full(n, height)], axis=1)
    return ring[::-1] if down else ring

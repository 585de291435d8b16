"""Direct light in scenes of a few black plates: readings there are form factors, which closed forms know."""

import numpy as np
from rooms import SceneBuilder

from hradiosity import Options, solve
from hradiosity.reference.point_factors import gauss

FEW = Options(elements=200, gather_samples=64, light_samples=64, rays_per_element=32, light_points=8, replicates=2)


def points_on(quad, order=24, *, crowded=True):
    """(order², 3) places on a parallelogram (4, 3) and their weights, for means over it.

    crowded : towards the edges, where the light of a plate that touches has a kink
    """
    x, weight = gauss(order)
    if crowded:
        weight = weight * 30.0 * x**2 * (1.0 - x) ** 2
        x = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    s, t = (grid.reshape(-1, 1) for grid in np.meshgrid(x, x, indexing="ij"))
    return quad[0] + s * (quad[1] - quad[0]) + t * (quad[3] - quad[0]), np.outer(weight, weight).ravel()


def normal_of(polygon):
    across = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
    return across / np.linalg.norm(across)


def black_plates(plates, points, normals):
    """Scene of black plates, parallelograms (4, 3) or triangles (3, 3), of which the first sends out 1 W/m²."""
    b = SceneBuilder()
    black = b.material(0.0)
    for plate in np.asarray(plates, float) if not isinstance(plates, list) else plates:
        b.patch(plate[0], plate[1] - plate[0], plate[-1] - plate[0], black, triangle=len(plate) == 3)
    b.lamp(0, 1.0)
    b.sensor(points, normals)
    return b.scene()


def factors_read(device, plates, points, normals):
    """Readings of `black_plates`: what each point sees of the first plate."""
    (readings,) = solve(black_plates(plates, points, normals), FEW, device).readings.values()
    return readings.irradiance[:, 0]


def mean_read(device, receiver, plate, **how):
    """F from a receiver (4, 3) to a plate, as the mean of readings on it, and the readings themselves."""
    points, weight = points_on(receiver, **how)
    found = factors_read(device, [plate, receiver], points, normal_of(receiver))
    return float(weight @ found), found

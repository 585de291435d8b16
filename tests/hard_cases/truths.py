"""What a hard case is compared with: unbiased paths and closed forms, and what each run and reading is asked for."""

import numpy as np

from hradiosity.options import Options
from hradiosity.radiosity import solve
from hradiosity.readings.paths import trace_referee
from hradiosity.reference.point_factors import points_to_polygon
from hradiosity.space.bvh_build import build_bvh
from hradiosity.transport.device_scene import upload_scene

QUICK = Options(elements=1500, gather_samples=2048, light_samples=256, rays_per_element=64)
"""Settings that take about a second in a small room."""


def only(solution):
    """The readings of the only sensor."""
    (readings,) = solution.readings.values()
    return readings


def read(scene, device, options=QUICK):
    """Readings of the only sensor of a scene."""
    return only(solve(scene, options, device))


def uploaded(scene, device):
    """The scene's ray structure on the device, with shadow rays."""
    return upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)


def unbiased(scene, device, paths, seed=11):
    """Irradiance at the only sensor by unbiased paths, with its standard error."""
    (sensor,) = scene.sensors
    return trace_referee(uploaded(scene, device), scene, sensor.position, sensor.normal, paths=paths, seed=seed)


def assert_agrees(readings, truth, *, bias):
    """Within the interval, three standard errors of the truth, and the share `bias` that elements of this size cost.

    Returns the largest relative error and half width, for the table of cases.
    """
    value, width = readings.irradiance, readings.half_width
    error = np.abs(value - truth.irradiance)
    assert (error <= width + 3.0 * truth.standard_error + bias * truth.irradiance).all(), (
        value.ravel(), width.ravel(), truth.irradiance.ravel(), truth.standard_error.ravel(),
    )  # fmt: skip
    return float((error / truth.irradiance).max()), float((width / truth.irradiance).max())


def rectangle_factor(point, normal, corner, edge_u, edge_v):
    """Form factor of a surface element at a point to a parallelogram in full view."""
    corner, edge_u, edge_v = (np.asarray(a, float) for a in (corner, edge_u, edge_v))
    polygon = np.array([corner, corner + edge_u, corner + edge_u + edge_v, corner + edge_v])
    normal = np.asarray(normal, float) / np.linalg.norm(normal)
    return float(points_to_polygon(np.atleast_2d(np.asarray(point, float)), normal[None], polygon)[0])

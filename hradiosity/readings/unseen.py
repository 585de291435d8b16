"""Light that a reading may have though none of its rays found any."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.sensors import ReadingSamples
from hradiosity.readings.surface_light import SurfaceLight
from hradiosity.transport.device_scene import DeviceScene
from hradiosity.transport.direct import direct_at_points


def brightest_unseen(
    scene: DeviceScene,
    light: SurfaceLight,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    samples: ReadingSamples,
    *,
    light_samples: NDArray[np.float64],
    gather_samples: NDArray[np.int64],
) -> NDArray[np.float64] | None:
    """Most that one ray of a dark reading could have brought, over the number of its rays.

    A reading counts as dark where it has no light in any column of the scene or of a variant, but looks into a space
    where there is some. All others have a spread of their own, or are surely 0: they see nothing, or only sides that no
    light reaches. Where no paths are traced, shadow rays alone can't tell that, unless they go to a point.

    Parameters
    ----------
    position, normal : (n, 3) float64
        World frame [m], unit normals.
    samples : ReadingSamples
    light_samples : (n, n_emitters) float64
        Shadow rays; below 1 the probability of one.
    gather_samples : (n,) int64
        Paths.

    Returns
    -------
    (n, n_columns) float64, or None where no reading is dark
    """
    own = light.columns.members
    lightless = np.any([(samples.irradiance[:, columns] == 0.0).all(axis=1) for columns in own], axis=0)
    if not (lightless & ((samples.some_row >= 0) | (gather_samples == 0))).any():
        return None
    used = light.columns.n_columns
    brightest = _brightest_seen(scene, light, samples.some_row)[:, :used]
    dark = np.flatnonzero(lightless & (brightest.any(axis=1) | (gather_samples == 0)))
    clear = direct_at_points(scene.without_occlusion(), position[dark], normal[dark], 1, 0).astype(np.float64)
    has_area = scene.device.fetch(scene.emitters["emitter_extent"])[: scene.n_emitters, 0] > 0.0
    straight = np.einsum("xe,ec->xc", clear * has_area / light_samples[dark], light.emission[:, :used])
    unseen = np.zeros_like(samples.irradiance)
    unseen[dark] = straight + brightest[dark] / np.maximum(gather_samples[dark, None], 1)
    return unseen


def _brightest_seen(scene: DeviceScene, light: SurfaceLight, some_row: NDArray[np.int64]) -> NDArray[np.float64]:
    """(n, n_columns) brightest exitance in each column among the elements of the space that a reading looks into."""
    reflected = scene.device.fetch(light.reflected)
    if reflected.ndim != 2 or not len(light.row_space):
        return np.zeros((len(some_row), light.columns.n_columns))
    brightest = np.zeros((int(light.row_space.max()) + 2, reflected.shape[1]))
    np.maximum.at(brightest, light.row_space, reflected)
    return brightest[np.where(some_row >= 0, light.row_space[some_row], -1)]

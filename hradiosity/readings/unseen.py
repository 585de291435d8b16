"""Light that a reading may have though none of its rays found any."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.readings.sensors import ReadingSamples, SurfaceLight
from hradiosity.transport.device_scene import DeviceScene
from hradiosity.transport.direct import direct_at_points


def brightest_unseen(
    scene: DeviceScene,
    light: SurfaceLight,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    samples: ReadingSamples,
    *,
    light_samples: NDArray[np.int64],
    gather_samples: NDArray[np.int64],
) -> NDArray[np.float64] | None:
    """Most that one ray of a dark reading could have brought, over the number of its rays.

    A reading counts as dark where it has no light in any column, but some of its paths end where light may come. All
    others have a spread of their own, or are surely 0: they see nothing, or only sides that no light reaches. Where no
    paths are traced, shadow rays alone can't tell that, unless they go to a point.

    Parameters
    ----------
    position, normal : (n, 3) float64
        World frame [m], unit normals.
    samples : ReadingSamples
    light_samples, gather_samples : (n,) int64
        Shadow rays to each emitter, and paths.

    Returns
    -------
    (n, n_columns) float64, or None where no reading is dark
    """
    dark = np.flatnonzero(
        (samples.irradiance == 0.0).all(axis=1) & ((samples.ended_on_rows > 0.0) | (gather_samples == 0))
    )
    if not len(dark):
        return None
    used = light.columns.n_columns
    reflected = scene.device.fetch(light.reflected)
    has_rows = reflected.ndim == 2
    brightest = reflected[:, :used].max(axis=0).astype(np.float64) if has_rows else np.zeros(used)
    clear = direct_at_points(scene.without_occlusion(), position[dark], normal[dark], 1, 0).astype(np.float64)
    has_area = scene.device.fetch(scene.emitters["emitter_extent"])[: scene.n_emitters, 0] > 0.0
    straight = np.einsum("xe,ec->xc", clear * has_area, light.emission[:, :used])
    unseen = np.zeros_like(samples.irradiance)
    unseen[dark] = straight / light_samples[dark, None] + brightest / np.maximum(gather_samples[dark, None], 1)
    return unseen

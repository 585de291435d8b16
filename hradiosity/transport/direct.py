"""Direct light from the emitters, without wavelengths: G[place, emitter]."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import Device, DeviceArray
from hradiosity.space.shafts import MOST_VISITS
from hradiosity.transport.device_scene import DeviceElements, DeviceScene

if TYPE_CHECKING:
    from hradiosity.transport.exchange import RowHits


def direct_on_rows(
    scene: DeviceScene,
    elements: DeviceElements,
    hits: RowHits,
    n_points: int,
    seed: int,
    chance: DeviceArray | None = None,
    points: DeviceArray | None = None,
) -> NDArray[np.float32]:
    """Mean irradiance of each row element's exposed part for unit emission of each emitter.

    Parameters
    ----------
    hits : RowHits
        Of the same seed: its rays tell which points are covered by solids.
    n_points : int
        Points on each element; at each, one ray goes to each emitter that the element is not proved to see.
    chance : (n_rows, n_emitters) float32 on the device, optional
        Probability of trying an emitter, see `hradiosity.transport.lamp_choice`.
    points : (n_rows, n_emitters) uint32 on the device, optional
        In place of `n_points`, see `hradiosity.transport.lamp_doubt`.

    Returns
    -------
    (n_rows, n_emitters) float32
        Per unit exitance [1]; per unit intensity of a point source [m⁻²].
    """
    n_rows = len(elements.elements)
    if scene.n_emitters == 0 or n_rows == 0:
        return np.zeros((n_rows, scene.n_emitters), np.float32)
    direct = scene.device.empty((n_rows, scene.n_emitters), np.float32)
    scene.device.kernel("direct", "direct_rows", HR_CHANCE=int(chance is not None), HR_EACH=int(points is not None))(
        n_rows * scene.n_emitters,
        **scene.geometry,
        **elements.cells,
        **scene.emitters,
        hit_row=hits.on_device,
        row_sight=elements.sight(scene),
        chance=direct if chance is None else chance,
        row_points=hits.on_device if points is None else points,
        direct=direct,
        n_samples=hits.row.shape[1],
        n_points=n_points,
        n_emitters=scene.n_emitters,
        occlusion=int(scene.occlusion),
        seed=seed,
        scale=scene.scale,
    )
    fetched: NDArray[np.float32] = scene.device.fetch(direct)
    return fetched


def light_of_emitters(
    device: Device, direct: DeviceArray, emission: DeviceArray, shape: tuple[int, int]
) -> NDArray[np.float32]:
    """(n_rows, 8 n_groups) irradiance by all emitters together.

    Parameters
    ----------
    direct : `shape` = (n_rows, n_emitters) float32 on the device
        For unit emission.
    emission : (n_emitters, 8 n_groups) float32 on the device
    """
    n_rows, n_emitters = shape
    width = emission.shape[1]
    if n_emitters == 0 or n_rows == 0:
        return np.zeros((n_rows, width), np.float32)
    light = device.empty((n_rows, width), np.float32)
    device.kernel("columns", "combine_columns", HR_GROUPS=width // 8)(
        n_rows, factors=direct, combination=emission, combined=light, n_factors=n_emitters
    )
    fetched: NDArray[np.float32] = device.fetch(light)
    return fetched


def direct_at_points(
    scene: DeviceScene,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    n_samples: int | NDArray[np.float64],
    seed: int,
    n_pilot: int | None = None,
    response: NDArray[np.float32] | None = None,
    seen: NDArray[np.bool_] | None = None,
) -> NDArray[np.float32]:
    """Irradiance at single points for unit emission of each emitter.

    Parameters
    ----------
    position : (n, 3) float64
        World frame [m].
    normal : (n, 3) float64
        Unit normals.
    n_samples : int, or (n, n_emitters) float64
        Shadow rays to each area emitter, 1 or more; their weighted open share multiplies the closed-form factor. None
        are traced where a shaft proves that the way is free. In arrays, a number below 1 is the probability of one ray.
    n_pilot : int, optional
        For pictures: stop after this many rays to an emitter when they all agree, which is cheaper, but no longer
        unbiased where an emitter is nearly open or nearly hidden; and all points send their rays to the same places,
        so that errors change smoothly from point to point.
    response : (n, 12) float32, optional
        How directions weigh, see `hradiosity.model.sensor_kinds`; `n_pilot`, proofs, and probabilities in place of a
        ray have no part in that.
    seen : (n, n_emitters) bool, optional
        With an array of rays: emitters with less than two that count by their closed form, less what is found hidden;
        the others by what is found open. The mean is the same.

    Returns
    -------
    (n, n_emitters) float32
    """
    device = scene.device
    if scene.n_emitters == 0 or not len(position):
        return np.zeros((len(position), scene.n_emitters), np.float32)
    if response is not None:
        return _direct_by_response(scene, position, normal, response, n_samples, seed)
    direct = device.empty((len(position), scene.n_emitters), np.float32)
    each, most = _each(scene, n_samples, np.float32)
    if isinstance(n_samples, np.ndarray) and seen is None:
        seen = np.zeros(n_samples.shape, np.bool_)
    device.kernel("direct", "direct_points", HR_EACH=int(isinstance(n_samples, np.ndarray)))(
        len(position) * scene.n_emitters,
        **scene.geometry,
        **scene.emitters,
        position=device.upload(position - scene.bvh.local_origin, np.float32),
        normal=device.upload(normal, np.float32),
        samples=each,
        seen=device.upload(np.zeros(1) if seen is None else seen, np.uint8),
        direct=direct,
        first_point=0,
        n_samples=most,
        n_pilot=most if n_pilot is None else n_pilot,
        n_emitters=scene.n_emitters,
        occlusion=int(scene.occlusion),
        most_visits=MOST_VISITS if scene.shafts else 0,
        seed=seed,
        scale=scene.scale,
    )
    fetched: NDArray[np.float32] = device.fetch(direct)
    return fetched


def _each(scene: DeviceScene, n_samples: int | NDArray[np.float64], dtype: type) -> tuple[DeviceArray, int]:
    """Numbers of rays on the device, none if there is one for all; and the largest."""
    if isinstance(n_samples, np.ndarray):
        return scene.device.upload(n_samples, dtype), int(n_samples.max(initial=1))
    return scene.device.empty((1,), dtype), int(n_samples)


def _direct_by_response(
    scene: DeviceScene,
    position: NDArray[np.float64],
    normal: NDArray[np.float64],
    response: NDArray[np.float32],
    n_samples: int | NDArray[np.float64],
    seed: int,
) -> NDArray[np.float32]:
    """(n, n_emitters) as `direct_at_points`, each direction weighted by the response."""
    device = scene.device
    direct = device.empty((len(position), scene.n_emitters), np.float32)
    each, most = _each(scene, np.maximum(n_samples, 1.0) if isinstance(n_samples, np.ndarray) else n_samples, np.uint32)
    device.kernel("responses", "direct_responses", HR_EACH=int(isinstance(n_samples, np.ndarray)))(
        len(position) * scene.n_emitters,
        **scene.geometry,
        **scene.emitters,
        position=device.upload(position - scene.bvh.local_origin, np.float32),
        normal=device.upload(normal, np.float32),
        response=device.upload(response),
        samples=each,
        direct=direct,
        n_samples=most,
        n_emitters=scene.n_emitters,
        occlusion=int(scene.occlusion),
        seed=seed,
        scale=scene.scale,
    )
    fetched: NDArray[np.float32] = device.fetch(direct)
    return fetched

"""A path-traced image: unbiased light at points of every pixel, which shares no elements and no solution with ours."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.metrics.colorimetric import xyz_weights
from hradiosity.model.geometry import BACK
from hradiosity.model.scene import Scene, View
from hradiosity.readings.path_scene import RefereeScene, prepare_referee
from hradiosity.readings.paths import trace_round
from hradiosity.show.camera import view_axes
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import side_materials
from hradiosity.space.parted import part_back_to_back
from hradiosity.space.visibility import Hits, trace_closest
from hradiosity.transport.device_scene import upload_scene

BATCH_POINTS: Final = 1 << 15
"""Points whose light is traced at a time."""


class PathTracer:
    """Traces images of one scene.

    Parameters
    ----------
    scene : Scene
    device : Device
    """

    def __init__(self, scene: Scene, device: Device) -> None:
        self.scene = part_back_to_back(scene)
        self._bvh = build_bvh(device, self.scene.patches)
        self._referee: RefereeScene = prepare_referee(
            upload_scene(device, self.scene, self._bvh, occlusion=True), self.scene
        )
        two_sided = np.array([material.two_sided for material in self.scene.materials], bool)
        self._side_material = side_materials(self.scene.patches, two_sided).ravel().astype(np.int64)
        self._emitted = _emitted(self.scene)

    def image(self, view: View, *, points: int, paths: int, seed: int) -> NDArray[np.float64]:
        """(height, width, 3) X, Y, Z of the pixels, Y in cd m⁻².

        Parameters
        ----------
        view : View
        points : int
            Across and down in each pixel, one anywhere in each of so many by so many parts.
        paths : int
            From each point.
        seed : int
        """
        random = np.random.default_rng(seed)
        total = np.zeros((view.width * view.height, 3))
        for part in range(points * points):
            for first in range(0, len(total), BATCH_POINTS):
                pixel = np.arange(first, min(first + BATCH_POINTS, len(total)))
                inside = (np.array([part % points, part // points]) + random.random((len(pixel), 2))) / points
                ray_seed = int(random.integers(1 << 32))
                total[pixel] += self._light(view, np.column_stack([pixel % view.width, pixel // view.width]) + inside,
                                            paths, ray_seed)  # fmt: skip
        return (total / points**2).reshape(view.height, view.width, 3)

    def _light(self, view: View, place: NDArray[np.float64], paths: int, seed: int) -> NDArray[np.float64]:
        """(n, 3) X, Y, Z seen at places (n, 2) of the picture, in pixels."""
        forward, right, down = view_axes(view)
        across, below = (2.0 * place / (view.width, view.height) - 1.0).T
        direction = forward + across[:, None] * right + below[:, None] * down
        hits = trace_closest(self._bvh, np.broadcast_to(view.position, direction.shape), direction)
        radiance = np.zeros((len(place), len(self.scene.bands)))
        if self.scene.sky is not None:
            radiance[(hits.patch < 0) & (direction[:, 2] > 0.0)] = self.scene.sky.radiance
        met = np.flatnonzero(hits.patch >= 0)
        radiance[met] = self._leaving(hits, met, paths, seed) / np.pi
        seen: NDArray[np.float64] = np.einsum("xb,bc->xc", radiance, xyz_weights(self.scene.bands))
        return seen

    def _leaving(self, hits: Hits, met: NDArray[np.int64], paths: int, seed: int) -> NDArray[np.float64]:
        """(m, n_bands) exitance of the points met, emitted and reflected."""
        patches, patch = self.scene.patches, hits.patch[met].astype(np.int64)
        side = 2 * patch + hits.side[met]
        position = (
            patches.origin[patch]
            + hits.u[met, None].astype(np.float64) * patches.edge_u[patch]
            + hits.v[met, None].astype(np.float64) * patches.edge_v[patch]
        )
        normal = patches.normal[patch] * np.where(hits.side[met] == BACK, -1.0, 1.0)[:, None]
        sums = trace_round(self._referee, position, normal, first_path=0, n_paths=paths, seed=seed, scrambles=1)
        reflectance = np.concatenate([self.scene.reflectance, np.zeros((1, len(self.scene.bands)))])
        reflected: NDArray[np.float64] = reflectance[self._side_material[side]] * sums.irradiance[0] / paths
        leaving: NDArray[np.float64] = self._emitted[side] + reflected
        return leaving


def _emitted(scene: Scene) -> NDArray[np.float64]:
    """(n_sides, n_bands) exitance of the lamps' own [W m⁻² per band]."""
    out = np.zeros((2 * len(scene.patches), len(scene.bands)))
    for patch, number in zip(scene.emitters.patch, scene.emitters.luminaire, strict=True):
        if patch >= 0:
            lamp = scene.luminaires[number]
            out[2 * patch : 2 * patch + (2 if lamp.two_sided else 1)] += lamp.exitance
    return out

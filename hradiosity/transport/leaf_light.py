"""Direct light at the vertices that leaves share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Scene
from hradiosity.space.leaves import CENTRE, Leaves
from hradiosity.transport.device_scene import DeviceScene
from hradiosity.transport.direct import direct_at_points
from hradiosity.transport.leaf_points import LeafVertices
from hradiosity.transport.refinement_goal import RefinementGoal, RefinementOptions, ShadowLight

RAY_BUDGET = 512
"""Shadow rays from a vertex to all emitters together, if the options leave it open."""
LEAST_RAYS, MOST_RAYS = 16, 256
"""To each emitter."""
RAY_ERROR_SHARE, MOST_RAYS_BY_ERROR = 0.5, 4096
"""Of the error that is asked for, what shadow rays may make of it in a penumbra; and the most of them."""
LEAST_PILOT, PILOT_SHARE = 4, 4
"""Rays to an emitter that decide alone when they agree: one in four, but not fewer than four."""


class VertexLight(LeafVertices):
    """Direct light at points that leaves share."""

    def __init__(self, on_device: DeviceScene, scene: Scene, goal: RefinementGoal, options: RefinementOptions) -> None:
        lamps = scene.luminaires
        super().__init__(on_device, scene.patches, goal, len(lamps) + 1)
        self._scene, self._options = scene, options
        weights = luminous_weights(scene.bands)
        self._lumens = np.array([np.einsum("b,b->", lamp.emission, weights) for lamp in lamps]).reshape(len(lamps))
        self._n_samples = options.light_samples or _shadow_rays(len(scene.emitters), options.error)
        self._n_pilot = max(LEAST_PILOT, self._n_samples // PILOT_SHARE)

    def _sample(self, position: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.floating]:
        """(n, n_luminaires + 1) light per luminaire, and illuminance without obstacles [lx], of points.

        Where leaves are split by their error that without obstacles is not looked at, and left at 0.
        """
        on_device, seed = self._on_device, self._options.seed
        per_emitter = direct_at_points(on_device, position, normal, self._n_samples, seed, self._n_pilot)
        luminaire = self._scene.emitters.luminaire
        by_lamp = np.zeros((len(luminaire), len(self._lumens)), np.float32)
        by_lamp[np.arange(len(luminaire)), luminaire] = 1.0
        light = np.einsum("xe,el->xl", per_emitter, by_lamp)
        if self._options.error is not None:
            return np.column_stack([light, np.zeros(len(light))])
        if not on_device.occlusion:
            return np.column_stack([light, np.einsum("xl,l->x", light, self._lumens)])
        open_scene = replace(on_device, occlusion=False)
        factor = direct_at_points(open_scene, position, normal, 1, seed)
        return np.column_stack([light, np.einsum("xe,e->x", factor.astype(np.float64), self._lumens[luminaire])])

    @property
    def lux(self) -> NDArray[np.float64]:
        """(n_vertices,) illuminance [lx]."""
        lux: NDArray[np.float64] = np.einsum("vl,l->v", self.values[:, :-1].astype(np.float64), self._lumens)
        return lux

    def light(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n, 5) illuminance [lx] at corners and centre."""
        found: NDArray[np.float64] = self.lux[self.index(leaves, nodes)]
        return found

    def uneven(self, leaves: Leaves, nodes: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether the light on each node is not what its corners say."""
        reference = self._goal.reference[leaves.cell[nodes]]
        index = self.index(leaves, nodes)
        lux, clear = self.lux, self.values[:, -1]
        visible = np.divide(lux, clear, out=np.zeros_like(lux), where=clear > 0.0)
        counted = self.known(leaves, nodes)
        corners = counted[:, :CENTRE].sum(axis=1)
        mean = (lux[index] * counted)[:, :CENTRE].sum(axis=1) / np.maximum(corners, 1)
        departs = (corners > 0) & counted[:, CENTRE]
        departs &= np.abs(lux[index][:, CENTRE] - mean) > self._options.tolerance * reference
        highest = np.where(counted, visible[index], -np.inf).max(axis=1)
        lowest = np.where(counted, visible[index], np.inf).min(axis=1)
        brightest = np.where(counted, clear[index], 0.0).max(axis=1)
        hidden = np.maximum(highest - lowest, 0.0) * brightest > self._options.contrast * reference
        mixed = counted.any(axis=1) & self.covered[index].any(axis=1)
        wanted: NDArray[np.bool_] = departs | hidden | mixed
        return wanted

    def finish(self, leaves: Leaves) -> ShadowLight:
        """Number the vertices of all leaves."""
        light = self.values[:, :-1]
        return ShadowLight(leaves, self.numbered(leaves), self.side, self.position, light, self.covered)


def _shadow_rays(n_emitters: int, error: float | None) -> int:
    """To each emitter. Their error in a penumbra falls with the power of three quarters of their number, and that of
    several emitters partly cancels.
    """
    if error is None:
        return int(np.clip(RAY_BUDGET // max(n_emitters, 1), LEAST_RAYS, MOST_RAYS))
    wanted = (RAY_ERROR_SHARE * error) ** (-4.0 / 3.0) / max(n_emitters, 1) ** 0.5
    return int(np.clip(wanted, LEAST_RAYS, MOST_RAYS_BY_ERROR))

"""Glow: emitters so weak, or so evenly spread, that the rays that meet them find them well enough.

They get no shadow rays. What they send out is added where a ray ends on them, beside what they reflect.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.lamps import shining_sides
from hradiosity.model.scene import Scene
from hradiosity.model.variants import stacked_emission, stacked_reflectance
from hradiosity.space.hierarchy import side_materials

if TYPE_CHECKING:
    from hradiosity.plan import SpectralColumns
    from hradiosity.space.lit_sides import LitSides

MORE_VARIANCE: Final = 0.1
"""By how much glow may add to the variance of the exitance over a space, in squares of its mean irradiance."""
HIGHEST_MEAN_REFLECTANCE: Final = 0.99


@dataclass(frozen=True)
class Glow:
    """How sides shine by themselves, as rays that meet them see it.

    paint : (n_patches, 2) uint32, paint of each side: its material, or beyond those one of the shining paints
    material : (n_paints,) uint32, material of each paint; ``n_materials`` stands for the black back
    exitance : (n_paints, n_columns) float32 [units of the columns]; 0 for plain materials
    """

    paint: NDArray[np.uint32]
    material: NDArray[np.uint32]
    exitance: NDArray[np.float32]

    @property
    def shines(self) -> bool:
        """Whether any side does."""
        return bool(self.exitance.any())


def glow_of(scene: Scene, columns: SpectralColumns, weak: NDArray[np.bool_]) -> Glow:
    """The glow of the emitters (n_emitters,) that are `weak`."""
    n_materials = len(scene.materials)
    two_sided = np.array([m.two_sided for m in scene.materials], bool)
    paint = side_materials(scene.patches, two_sided)
    emitter, side = shining_sides(scene, weak)
    luminaire = scene.emitters.luminaire[emitter]
    kinds, kind = np.unique(np.stack([paint.ravel()[side], luminaire]), axis=1, return_inverse=True)
    paint.ravel()[side] = n_materials + 1 + kind.ravel()
    material = np.concatenate([np.arange(n_materials + 1), kinds[0]]).astype(np.uint32)
    exitance = np.zeros((len(material), columns.n_columns), np.float32)
    exitance[n_materials + 1 :] = columns.emission[kinds[1].astype(np.int64)]
    return Glow(paint, material, exitance)


def sampled_scene(scene: Scene, weak: NDArray[np.bool_]) -> Scene:
    """The scene with the emitters alone that shadow rays go to."""
    lamps, kept = scene.emitters, ~weak
    if kept.all():
        return scene
    kept_lamps = replace(lamps, patch=lamps.patch[kept], position=lamps.position[kept], luminaire=lamps.luminaire[kept])
    return replace(scene, emitters=kept_lamps)


def weak_emitters(scene: Scene, lit: LitSides) -> NDArray[np.bool_]:
    """(n_emitters,) which emitters are left to the rays that meet them.

    In each closed space the mean irradiance is estimated by the energy balance of an integrating sphere. Emitters
    join, the one that adds least to the variance of the exitance first, as long as all that have joined together raise
    it by `MORE_VARIANCE` at most in every band, of the scene and of its variants: they add about that share to the
    variance of a reading's rays.
    """
    lamps, patches = scene.emitters, scene.patches
    area_lamp = lamps.patch >= 0
    weak = area_lamp.copy()
    emitter, side = shining_sides(scene, area_lamp)
    space, area = lit.space.ravel()[side], patches.area[side // 2]
    sent = stacked_emission(scene)
    exitance = sent[lamps.luminaire[emitter]]
    of_points = 4.0 * np.pi * sent[lamps.luminaire[~area_lamp]].sum(axis=0)
    two_sided = np.array([m.two_sided for m in scene.materials], bool)
    black = np.zeros((1, sent.shape[1]))
    reflectance = np.concatenate([stacked_reflectance(scene), black])[side_materials(patches, two_sided)]
    for s in np.unique(space):
        if s < 0 or lit.open[s]:
            weak[emitter[space == s]] = False
            continue
        inside = lit.space == s
        share = np.where(inside, patches.area[:, None], 0.0)
        total = share.sum()
        share /= total
        mean_reflectance = np.einsum("ps,psc->c", share, reflectance)
        here = space == s
        flux = np.einsum("e,ec->c", area[here], exitance[here]) + of_points
        level = flux / (total * (1.0 - np.minimum(mean_reflectance, HIGHEST_MEAN_REFLECTANCE)))
        joined = _joined(
            area[here] / total, exitance[here], reflectance.reshape(-1, len(level))[side[here]], level, mean_reflectance
        )
        weak[emitter[here][~joined]] = False
    return weak


def _joined(
    share: NDArray[np.float64],
    exitance: NDArray[np.float64],
    reflectance: NDArray[np.float64],
    level: NDArray[np.float64],
    mean_reflectance: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Which shining sides of a space join; shares of its area (n,), the rest (n, n_bands) or (n_bands,)."""
    own = np.divide(exitance, level, out=np.zeros_like(exitance), where=level > 0.0)
    square = share[:, None] * (own**2 + 2.0 * own * reflectance)
    order = np.argsort((share[:, None] * own**2).max(axis=1), kind="stable")
    squares = np.cumsum(square[order], axis=0)
    means = mean_reflectance + np.cumsum((share[:, None] * own)[order], axis=0)
    more = (squares - (means**2 - mean_reflectance**2)).max(axis=1)
    fitting = np.flatnonzero(more <= MORE_VARIANCE)
    joined = np.zeros(len(share), bool)
    joined[order[: fitting[-1] + 1 if len(fitting) else 0]] = True
    return joined

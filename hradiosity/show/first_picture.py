"""The picture that a run shows first, before anything is solved: direct light, and a guess of the rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.metrics.colorimetric import encode_srgb, xyz_to_linear_srgb, xyz_weights
from hradiosity.model.geometry import BACK, NONE
from hradiosity.model.lamps import lamp_emissions
from hradiosity.model.scene import Scene, View
from hradiosity.show.camera import ABOVE, ViewHits, trace_view
from hradiosity.show.channels import emitted_xyz, paint_colours, reflected_channels
from hradiosity.show.exposure import to_bytes, white_luminance
from hradiosity.show.files import png_bytes, write_bytes
from hradiosity.show.white import White, WhiteName, white_of
from hradiosity.space.bvh import Bvh
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import side_materials
from hradiosity.space.viewpoints import automatic_view
from hradiosity.transport.device_scene import upload_scene
from hradiosity.transport.direct import direct_at_points
from hradiosity.transport.glow import sampled_scene

BLOCK: Final = 8
"""Pixels across and down a block: light is computed once for each side in it, and interpolated."""
SHADOW_RAYS: Final = 16
"""To each lamp; `PILOT_RAYS` where those agree."""
PILOT_RAYS: Final = 4
MOST_LAMPS: Final = 64
"""The strongest are traced; others take part in the guess."""
_MOST_REFLECTED: Final = 0.95
"""The mean reflectance is taken to be no higher, so that the guess stays finite."""
_EVERY: Final = 4
"""Of so many pixels one takes part in the choice of the exposure."""


@dataclass(frozen=True)
class _Samples:
    """One place for each side in each block of pixels.

    number : (n_pixels,) int64, sample of each pixel; −1 where the view leaves the scene
    side : (n,) int64, 2 · patch + side
    position, normal : (n, 3) float64
    pixels : (n,) int64, how many show it
    beside : (n, 3, 3) int64, samples of the same side in the blocks around, above and to the left first; −1 for none
    """

    number: NDArray[np.int64]
    side: NDArray[np.int64]
    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    pixels: NDArray[np.int64]
    beside: NDArray[np.int64]


def write_first_picture(scene: Scene, device: Device, path: Path, white: WhiteName = "as-measured") -> None:
    """Write `first_picture` as a PNG.

    Raises
    ------
    OutputError
        When the file can't be written.
    """
    view, pixels = first_picture(scene, device, white)
    write_bytes(path, png_bytes(pixels, preview_texts(scene, view)))


def preview_texts(scene: Scene, view: View) -> dict[str, str]:
    """What the file of a preview says of itself."""
    return {"Title": f"{scene.name}: {view.name}, preview"}


def first_view(scene: Scene, bvh: Bvh) -> View:
    """The first view of a scene, or an automatic one."""
    if scene.views:
        return scene.views[0]
    return automatic_view(scene, bvh, np.ones((len(scene.patches), 2), np.bool_))


def first_picture(scene: Scene, device: Device, white: WhiteName = "as-measured") -> tuple[View, NDArray[np.uint8]]:
    """The scene's first view, (height, width, 3) sRGB.

    Direct light comes from the strongest lamps by a few shadow rays. All that reflections add is one irradiance for
    all places, the ambient light of Cohen, Chen, Wallace & Greenberg (1988), as if the view were the whole room:
    E = c m / (1 − c ρ), with m the mean of what the view reflects of the direct light, ρ its mean reflectance, and c
    the share of it that does not leave the scene. Without direct light in view the paints are shown in daylight.

    Parameters
    ----------
    scene : Scene
        With at least one patch.
    device : Device
    white : WhiteName
        What is shown as white, see `hradiosity.show.white`.
    """
    bvh = build_bvh(device, scene.patches)
    view = first_view(scene, bvh)
    hits = trace_view(bvh, view, 1)
    samples = _samples(scene, view, hits)
    material = _materials(scene, samples.side)
    irradiance = _irradiance(scene, bvh, samples, material)
    if irradiance.any():
        of_sample = reflected_channels(scene, material, irradiance)[:, :3] / np.float32(np.pi)
        linear = _with_lamps(scene, hits, _interpolated(samples, view, of_sample), white_of(scene, white))
    else:
        colours = np.append(paint_colours(scene)[material], np.zeros((1, 3)), axis=0)
        linear = xyz_to_linear_srgb(colours[samples.number], 1.0)
    return view, to_bytes(encode_srgb(linear)).reshape(view.height, view.width, 3)


def _samples(scene: Scene, view: View, hits: ViewHits) -> _Samples:
    """The mean of the points that the pixels of a block show on each side."""
    patches, n_sides = scene.patches, 2 * len(scene.patches)
    across = -(-view.width // BLOCK) + 2
    x, y = np.arange(view.width) // BLOCK + 1, np.arange(view.height) // BLOCK + 1
    block = (y[:, None] * across + x).ravel()
    seen = np.flatnonzero(hits.side >= 0)
    key, index = np.unique(block[seen] * n_sides + hits.side[seen], return_inverse=True)
    number = np.full(len(hits.side), -1)
    number[seen] = index
    pixels = np.bincount(index, minlength=len(key))
    u, v = (np.bincount(index, a[seen], len(key)) / np.maximum(pixels, 1) for a in (hits.u, hits.v))
    side, patch = key % n_sides, key % n_sides // 2
    position = patches.origin[patch] + u[:, None] * patches.edge_u[patch] + v[:, None] * patches.edge_v[patch]
    step = np.array([-1, 0, 1])
    wanted = key[:, None, None] + (step[:, None] * across + step) * n_sides
    place = np.minimum(np.searchsorted(key, wanted), max(len(key) - 1, 0))
    beside = np.where(key[place] == wanted, place, -1) if len(key) else place
    normal = patches.normal[patch] * np.where(side % 2 == BACK, -1.0, 1.0)[:, None]
    return _Samples(number, side, position, normal, pixels, beside)


def _materials(scene: Scene, side: NDArray[np.int64]) -> NDArray[np.int64]:
    """Material of sides (n,); ``n_materials`` for black backs."""
    two_sided = np.array([m.two_sided for m in scene.materials], np.bool_)
    material: NDArray[np.int64] = side_materials(scene.patches, two_sided).ravel()[side].astype(np.int64)
    return material


def _irradiance(scene: Scene, bvh: Bvh, samples: _Samples, material: NDArray[np.int64]) -> NDArray[np.float64]:
    """(n, n_bands) direct light and the guess of the rest [W m⁻² per band]."""
    sent = lamp_emissions(scene)
    power = _power(scene, sent)
    weak = np.ones(len(power), np.bool_)
    weak[np.argsort(-power.sum(axis=1), kind="stable")[:MOST_LAMPS]] = False
    # Rays to lamps start at surfaces and need not know what solids cover.
    bare = replace(scene, patches=replace(scene.patches, solid=np.full(len(scene.patches), NONE, np.int32)))
    traced = sampled_scene(bare, weak)
    on_device = upload_scene(bvh.device, traced, bvh, occlusion=True, shafts=False)
    factor = direct_at_points(on_device, samples.position, samples.normal, SHADOW_RAYS, seed=0, n_pilot=PILOT_RAYS)
    direct = np.einsum("sl,lb->sb", factor.astype(np.float64), sent[traced.emitters.luminaire])
    closed = float((samples.number >= 0).mean())
    share = samples.pixels / max(int(samples.pixels.sum()), 1)
    reflectance = np.concatenate([scene.reflectance, np.zeros((1, len(scene.bands)))])[material]
    sources = np.einsum("s,sb->b", share, reflectance * direct) + power[weak].sum(axis=0) / scene.patches.area.sum()
    mean_reflectance = np.minimum(np.einsum("s,sb->b", share, reflectance), _MOST_REFLECTED)
    irradiance: NDArray[np.float64] = direct + closed * sources / (1.0 - closed * mean_reflectance)
    return irradiance


def _power(scene: Scene, sent: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n_emitters, n_bands) flux of each emitter [W per band]."""
    lamps = scene.emitters
    both = np.array([lamp.two_sided for lamp in scene.luminaires], np.bool_)[lamps.luminaire]
    area = np.where(both, 2.0, 1.0) * scene.patches.area[np.maximum(lamps.patch, 0)]
    power: NDArray[np.float64] = np.where(lamps.patch >= 0, area, 4.0 * np.pi)[:, None] * sent[lamps.luminaire]
    return power


def _interpolated(samples: _Samples, view: View, of_sample: NDArray[np.float32]) -> NDArray[np.float32]:
    """(n_pixels, c) values of the samples (n, c) between the middles of the blocks; 0 where nothing is seen."""
    offset = [(np.arange(size, dtype=np.float32) + 0.5) / BLOCK % 1.0 - 0.5 for size in (view.height, view.width)]
    down, across = (a.ravel() for a in np.meshgrid(*offset, indexing="ij"))
    seen = np.flatnonzero(samples.number >= 0)
    number, down, across = samples.number[seen], down[seen], across[seen]
    below, beyond = 1 + np.sign(down).astype(np.int64), 1 + np.sign(across).astype(np.int64)
    down, across = np.abs(down), np.abs(across)
    total = np.zeros((len(seen), 1), np.float32)
    sums = np.zeros((len(seen), of_sample.shape[1]), np.float32)
    corners = (
        (1, 1, (1.0 - down) * (1.0 - across)),
        (1, beyond, (1.0 - down) * across),
        (below, 1, down * (1.0 - across)),
        (below, beyond, down * across),
    )
    for row, column, weight in corners:
        place = samples.beside[number, row, column]
        known = np.where(place >= 0, weight, 0.0)[:, None].astype(np.float32)
        sums += known * of_sample[place]
        total += known
    out = np.zeros((len(samples.number), of_sample.shape[1]), np.float32)
    out[seen] = sums / total
    return out


def _with_lamps(scene: Scene, hits: ViewHits, radiance: NDArray[np.float32], white: White) -> NDArray[np.float64]:
    """(n_pixels, 3) linear sRGB of reflected radiance (n_pixels, 3), with what shines by itself."""
    emitted = emitted_xyz(scene)[np.maximum(hits.side, 0)] / np.pi
    emitted[hits.side < 0] = 0.0
    dull = (hits.side >= 0) & ~emitted.any(axis=1)
    luminance = white_luminance([white.shown(radiance[dull][::_EVERY]).astype(np.float32)])
    if scene.sky is not None:
        emitted[hits.side == ABOVE] = np.einsum("b,bc->c", scene.sky.radiance, xyz_weights(scene.bands))
    return xyz_to_linear_srgb(white.shown(radiance + emitted), luminance)

"""Primary rays: which point of which surface each part of a picture shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.scene import View
from hradiosity.space.bvh import Bvh

NOTHING: Final = -1
"""The view leaves the scene, downwards or level."""
ABOVE: Final = -2
"""The view leaves the scene upwards, where the sky is."""


@dataclass(frozen=True)
class ViewHits:
    """What a view shows, in samples from the upper left, row by row.

    width, height : samples across and down
    side : (height · width,) int64, 2 · patch + side; NOTHING or ABOVE where the view leaves the scene
    u, v : (height · width,) float32, the point is ``origin + u edge_u + v edge_v`` of the patch
    depth : (height · width,) float32 [m], along the axis of view; inf where the view leaves the scene
    sample_angle : size of a sample at distance 1, in the middle of the picture [rad]
    """

    width: int
    height: int
    side: NDArray[np.int64]
    u: NDArray[np.float32]
    v: NDArray[np.float32]
    depth: NDArray[np.float32]
    sample_angle: float


def view_axes(view: View) -> NDArray[np.float64]:
    """(3, 3): unit vector forward; half the width to the right and half the height downwards, at distance 1.

    Raises
    ------
    ValueError
        When ``up`` is parallel to ``direction``.
    """
    forward = view.direction / np.linalg.norm(view.direction)
    right = np.cross(forward, view.up)
    length = float(np.linalg.norm(right))
    if length < 1e-9 * float(np.linalg.norm(view.up)):
        raise ValueError(f"view {view.name!r} looks along its own up")
    right /= length
    half_width = np.tan(np.radians(view.field_of_view) / 2.0)
    down = np.cross(forward, right)
    return np.stack([forward, half_width * right, half_width * view.height / view.width * down])


def trace_view(bvh: Bvh, view: View, samples: int) -> ViewHits:
    """Send ``samples`` × ``samples`` rays through each pixel.

    Parameters
    ----------
    bvh : Bvh
    view : View
    samples : int
        Rays across and down a pixel, through the middles of its equal parts.
    """
    device, axes = bvh.device, view_axes(view)
    width, height = samples * view.width, samples * view.height
    n = width * height
    side, uv, depth = device.empty((n,), np.uint32), device.empty((n, 2), np.float32), device.empty((n,), np.float32)
    device.kernel("camera", "primary_hits")(
        n,
        **bvh.kernel_arguments(),
        camera=device.upload(np.vstack([bvh.to_local(view.position)[None], axes]), np.float32),
        hit_side=side,
        hit_uv=uv,
        hit_t=depth,
        width=width,
        height=height,
    )
    host_uv = device.fetch(uv)
    host_side = device.fetch(side).view(np.int32).astype(np.int64)
    lost = np.flatnonzero(host_side < 0)
    across, downwards = (2.0 * (lost % width) + 1.0) / width - 1.0, (2.0 * (lost // width) + 1.0) / height - 1.0
    rise = axes[0, 2] + across * axes[1, 2] + downwards * axes[2, 2]
    host_side[lost] = np.where(rise > 0.0, ABOVE, NOTHING)
    return ViewHits(
        width=width,
        height=height,
        side=host_side,
        u=np.ascontiguousarray(host_uv[:, 0]),
        v=np.ascontiguousarray(host_uv[:, 1]),
        depth=device.fetch(depth),
        sample_angle=2.0 * float(np.linalg.norm(axes[1])) / width,
    )


@dataclass(frozen=True)
class PicturePoints:
    """Points that a picture is shaded at: one in a pixel that shows one side only, all of its samples elsewhere.

    pixel : (n,) int64, from the upper left, row by row
    weight : (n,) float32, share of the pixel; sums to 1 in each
    side, u, v : as in `ViewHits`
    """

    pixel: NDArray[np.int64]
    weight: NDArray[np.float32]
    side: NDArray[np.int64]
    u: NDArray[np.float32]
    v: NDArray[np.float32]


def picture_points(hits: ViewHits, per_pixel: int) -> PicturePoints:
    """Points to shade.

    Parameters
    ----------
    hits : ViewHits
        With ``per_pixel`` × ``per_pixel`` samples in each pixel.
    per_pixel : int
        Odd, so that one sample is in the middle.
    """
    if per_pixel % 2 == 0:
        raise ValueError(f"per_pixel must be odd, is {per_pixel}")
    height, width = hits.height // per_pixel, hits.width // per_pixel
    number = np.arange(hits.height * hits.width).reshape(height, per_pixel, width, per_pixel)
    by_pixel = number.transpose(0, 2, 1, 3).reshape(height * width, per_pixel**2)
    side = hits.side[by_pixel]
    whole = (side == side[:, :1]).all(axis=1)
    pixels = np.arange(height * width)
    sample = np.concatenate([by_pixel[whole, per_pixel**2 // 2], by_pixel[~whole].ravel()])
    return PicturePoints(
        pixel=np.concatenate([pixels[whole], np.repeat(pixels[~whole], per_pixel**2)]),
        weight=np.where(np.arange(len(sample)) < whole.sum(), 1.0, 1.0 / per_pixel**2).astype(np.float32),
        side=hits.side[sample],
        u=hits.u[sample],
        v=hits.v[sample],
    )


def project(view: View, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixel coordinates (x to the right, y down, from the upper left corner) of points in front of the camera.

    Parameters
    ----------
    points : (n, 3) float64 [m]

    Returns
    -------
    (n, 2) float64 [pixels], NaN for points behind the camera
    """
    forward, right, down = view_axes(view)
    offset = points - view.position
    depth, x, y = np.einsum("nk,ak->an", offset, np.stack([forward, right, down]))
    depth = np.where(depth > 0.0, depth, np.nan)
    x /= np.einsum("k,k->", right, right) * depth
    y /= np.einsum("k,k->", down, down) * depth
    return np.stack([(0.5 + 0.5 * x) * view.width, (0.5 + 0.5 * y) * view.height], axis=1)

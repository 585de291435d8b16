"""Patches to shoot at, and a float64 referee that tries every patch."""

import numpy as np
from scipy.spatial.transform import Rotation

from hradiosity.model.geometry import Patches


def make_patches(origin, edge_u, edge_v, is_triangle) -> Patches:
    n = len(origin)
    zeros = np.zeros(n, np.int32)
    return Patches(
        origin=np.asarray(origin, float).reshape(n, 3),
        edge_u=np.asarray(edge_u, float).reshape(n, 3),
        edge_v=np.asarray(edge_v, float).reshape(n, 3),
        is_triangle=np.broadcast_to(np.asarray(is_triangle, bool), (n,)),
        material=zeros,
        object=zeros,
        surface=zeros,
        solid=zeros,
    )


def random_patches(rng, n, size=0.3) -> Patches:
    """Triangles and parallelograms strewn over a cube of half extent 1."""
    edges = rng.normal(scale=size, size=(2, n, 3))
    return make_patches(rng.uniform(-1, 1, (n, 3)), edges[0], edges[1], rng.random(n) < 0.5)


def from_triangles(corners) -> Patches:
    """Patches of corners (n, 3, 3)."""
    return make_patches(corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], True)


def box(half=1.0) -> Patches:
    """Closed cube of 6 parallelograms around the origin, normals outward."""
    edges = 2 * half * np.eye(3)
    next_edge, last_edge = np.roll(edges, -1, axis=0), np.roll(edges, -2, axis=0)
    origin = np.repeat([[-half] * 3, [half] * 3], 3, axis=0)
    return make_patches(
        origin, np.concatenate([last_edge, -next_edge]), np.concatenate([next_edge, -last_edge]), is_triangle=False
    )


def sphere_triangles(rng, steps=24):
    """Closed tessellated sphere, randomly rotated: corners (n, 3, 3); neighbours share the very same numbers."""
    polar = np.linspace(0, np.pi, steps + 1)
    around = np.linspace(0, 2 * np.pi, 2 * steps + 1)[:-1]
    ring = np.stack([np.cos(around), np.sin(around)], axis=-1)
    points = np.concatenate(
        [np.sin(polar)[:, None, None] * ring, np.broadcast_to(np.cos(polar)[:, None, None], (steps + 1, 2 * steps, 1))],
        axis=-1,
    )
    points[0], points[-1] = (0, 0, 1), (0, 0, -1)
    points = points @ Rotation.random(random_state=rng.integers(2**31)).as_matrix().T
    beside = np.roll(points, -1, axis=1)
    lower = np.stack([points[:-1], points[1:], beside[1:]], axis=2)
    upper = np.stack([points[:-1], beside[1:], beside[:-1]], axis=2)
    return np.concatenate([lower.reshape(-1, 3, 3), upper.reshape(-1, 3, 3)])


def brute_force(patches, origins, directions):
    """Patch, side, t, u, v of each ray's first hit, from the plane equation in float64; patch -1 and t inf: a miss."""
    normal = np.cross(patches.edge_u, patches.edge_v)
    slope = directions @ normal.T
    with np.errstate(divide="ignore", invalid="ignore"):
        t = ((patches.origin - origins[:, None]) * normal).sum(-1) / slope
    t = np.where(np.isfinite(t), t, -1.0)
    offset = origins[:, None] + t[..., None] * directions[:, None] - patches.origin
    a = np.einsum("rpc,pc->rp", offset, patches.edge_u)
    b = np.einsum("rpc,pc->rp", offset, patches.edge_v)
    uu, vv = (patches.edge_u**2).sum(1), (patches.edge_v**2).sum(1)
    uv = (patches.edge_u * patches.edge_v).sum(1)
    gram = uu * vv - uv**2
    u, v = (a * vv - b * uv) / gram, (b * uu - a * uv) / gram
    inside = (u >= 0) & (v >= 0) & np.where(patches.is_triangle, u + v <= 1, (u <= 1) & (v <= 1))
    t = np.where(inside & (t > 0), t, np.inf)
    patch = t.argmin(axis=1)
    rays = np.arange(len(origins))
    first = t[rays, patch]
    side = (slope[rays, patch] > 0).astype(int)
    return np.where(np.isinf(first), -1, patch), side, first, u[rays, patch], v[rays, patch]

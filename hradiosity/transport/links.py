"""Links between nodes of element hierarchies: pairs at mixed levels that together cover all pairs of row elements once.

Hanrahan, Salzman & Aupperle 1991, "A Rapid Hierarchical Radiosity Algorithm", refine pair by pair; here all pairs of a
generation are judged at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.errors import Fault, SceneError
from hradiosity.space.nodes import Nodes
from hradiosity.space.shafts import FREE, HIDDEN, UNKNOWN, EmitterShapes, Receivers, prove_sight
from hradiosity.transport.device_scene import DeviceScene

DROP, KEEP, SPLIT_FIRST, SPLIT_SECOND = range(4)
"""What becomes of a pair. Values as in ``cl/include/hr_nodes.h``."""
FLAT: Final = 2.0**-20
"""Height over a plane, in half extents of the scene, that counts as none."""
PARTIAL_SHARE: Final = 0.25
"""Links that are found partly hidden are split down to this share of the largest form factor."""
NEAR: Final = 0.1
"""Form factor from which on points are also drawn along directions."""
PARTIAL_SAMPLES: Final = 8
"""Rays that tell whether a link is partly hidden."""
BATCH_PAIRS: Final = 1 << 22
"""Pairs on the device at a time."""
MOST_LINKS: Final = 100_000_000
"""More than any device at hand holds."""


@dataclass(frozen=True)
class Refinement:
    """How far pairs are refined.

    form_factor : largest form factor of a link, either way, of nodes that can be split
    occlusion : whether anything can stand between two points at all
    reach : pairs farther apart are not proved free [m]
    seed : of the rays that tell which links are partly hidden
    """

    form_factor: float
    occlusion: bool
    reach: float
    seed: int


@dataclass(frozen=True)
class Links:
    """Pairs of nodes, each once.

    first, second : (n,) int64, first <= second among roots; a group is linked to itself
    factor : (n,) float32, estimate of the larger form factor, from above
    sight : (n,) uint8, FREE where it is proved, else UNKNOWN
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    factor: NDArray[np.float32]
    sight: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.first)

    def subset(self, chosen: NDArray[Any]) -> Links:
        """Some of them, by index or mask."""
        return Links(self.first[chosen], self.second[chosen], self.factor[chosen], self.sight[chosen])


class LinkFinder:
    """Nodes on the device, and what kernels tell about pairs of them.

    Parameters
    ----------
    scene : DeviceScene
    nodes : Nodes
    """

    def __init__(self, scene: DeviceScene, nodes: Nodes) -> None:
        self._scene, self._bvh, self._nodes, self.device = scene, scene.bvh, nodes, scene.device
        self._flat = np.diff(nodes.facet_start) == 1
        self.area = nodes.areas()
        self._on_device = self._upload()
        one = nodes.facet_start[:-1]
        facets = nodes.facets
        self._receivers = Receivers(facets.corners[one], facets.normal[one], facets.patch[one])
        self._emitters = EmitterShapes(
            facets.corners[one], facets.normal[one], facets.patch[one], np.zeros(len(nodes), bool)
        )

    def _upload(self) -> dict[str, DeviceArray]:
        nodes, upload = self._nodes, self.device.upload
        facets, start = nodes.facets, nodes.facet_start
        before = np.concatenate([[0.0], np.cumsum(facets.area)])
        node = np.repeat(np.arange(len(nodes)), np.diff(start))
        share = (before[1:] - before[start[:-1]][node]) / self.area[node]
        share[start[1:] - 1] = 1.0
        return {
            "node_facet": upload(start, np.uint32),
            "node_area": upload(self.area, np.float32),
            "node_sphere": upload(self._spheres(), np.float32),
            "facet_corner": upload(self._bvh.to_local(facets.corners)),
            "facet_normal": upload(facets.normal, np.float32),
            "facet_share": upload(share, np.float32),
            "facet_kind": upload(facets.is_triangle, np.uint32),
            "facet_side": upload(facets.side, np.uint32),
        }

    def _spheres(self) -> NDArray[np.float32]:
        """(n_nodes, 4) local centre and radius of spheres that hold the nodes."""
        start, corners = self._nodes.facet_start[:-1], self._bvh.to_local(self._nodes.facets.corners)
        low = np.minimum.reduceat(corners.min(axis=1), start)
        high = np.maximum.reduceat(corners.max(axis=1), start)
        centre = 0.5 * (low + high)
        node = np.repeat(np.arange(len(start)), np.diff(self._nodes.facet_start))
        radius = np.maximum.reduceat(np.linalg.norm(corners - centre[node, None], axis=2).max(axis=1), start)
        sphere: NDArray[np.float32] = np.column_stack([centre, radius])
        return sphere

    def judge(
        self, first: NDArray[np.int64], second: NDArray[np.int64], most: float
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """DROP … SPLIT_SECOND for each pair, and the estimate of its larger form factor."""
        decision, factor = np.zeros(len(first), np.uint8), np.zeros(len(first), np.float32)
        kernel = self.device.kernel("links", "judge_links")
        for low in range(0, len(first), BATCH_PAIRS):
            part = slice(low, low + BATCH_PAIRS)
            n = len(first[part])
            found, size = self.device.empty((n,), np.uint8), self.device.empty((n,), np.float32)
            kernel(
                n,
                **self._on_device,
                pair_first=self.device.upload(first[part], np.uint32),
                pair_second=self.device.upload(second[part], np.uint32),
                decision=found,
                factor=size,
                n_leaves=self._nodes.n_rows,
                most=most,
                flat=FLAT * self._bvh.scale,
            )
            decision[part], factor[part] = self.device.fetch(found)[:n], self.device.fetch(size)[:n]
        return decision, factor

    def prove(self, first: NDArray[np.int64], second: NDArray[np.int64], reach: float) -> NDArray[np.uint8]:
        """What shafts prove about each pair; nothing about groups."""
        sight = np.full(len(first), UNKNOWN, np.uint8)
        tried = np.flatnonzero(self._flat[first] & self._flat[second])
        sight[tried] = prove_sight(self._bvh, self._receivers, self._emitters, first[tried], second[tried], reach=reach)
        return sight

    def sample(self, links: Links, n_samples: NDArray[np.integer], seed: int) -> NDArray[np.float64]:
        """Open share of the exchange of each link, by shadow rays between random points of both nodes."""
        first, second = links.first, links.second
        share = np.zeros(len(first))
        kernel = self.device.kernel("links", "sample_links")
        for low in range(0, len(first), BATCH_PAIRS):
            part = slice(low, low + BATCH_PAIRS)
            n = len(first[part])
            total, seen = (self.device.empty((n,), np.float32) for _ in range(2))
            kernel(
                n,
                **self._bvh.kernel_arguments(),
                **self._on_device,
                patch_normal=self._scene.geometry["patch_normal"],
                patch_solid=self._scene.solid,
                flush_reach=self._scene.flush_reach,
                link_first=self.device.upload(first[part], np.uint32),
                link_second=self.device.upload(second[part], np.uint32),
                factor=self.device.upload(links.factor[part], np.float32),
                n_samples=self.device.upload(n_samples[part], np.uint32),
                total=total,
                open=seen,
                near=NEAR,
                seed=seed,
                scale=self._bvh.scale,
            )
            whole = self.device.fetch(total)[:n].astype(np.float64)
            share[part] = np.divide(self.device.fetch(seen)[:n], whole, out=np.zeros(n), where=whole > 0.0)
        return share


def refine_links(finder: LinkFinder, nodes: Nodes, space: NDArray[np.integer], rules: Refinement) -> Links:
    """Refine all pairs of roots until every pair of row elements that may see each other is covered by one link.

    Pairs are dropped by geometry only: where one lies behind the other's horizon, or in another space. That all rays
    of a sample were blocked drops nothing, and that none was proves nothing.

    Parameters
    ----------
    finder : LinkFinder
    nodes : Nodes
    space : (n_roots,) int
        Space that each root looks into; no links go between spaces.
    rules : Refinement

    Raises
    ------
    SceneError
        When there are more links than fit.
    """
    nothing = np.zeros(0, np.int64)
    kept = [Links(nothing, nothing, nothing.astype(np.float32), nothing.astype(np.uint8))]
    pending = _root_links(finder, nodes, space, rules)
    while len(pending):
        decision, factor = finder.judge(pending.first, pending.second, rules.form_factor)
        sight = pending.sight
        if rules.occlusion:
            open_ = np.flatnonzero((decision != DROP) & (sight == UNKNOWN))
            sight[open_] = finder.prove(pending.first[open_], pending.second[open_], rules.reach)
            decision[sight == HIDDEN] = DROP
            _split_partial(finder, nodes, Links(pending.first, pending.second, factor, sight), decision, rules)
        found = Links(pending.first, pending.second, factor, sight)
        kept.append(found.subset(decision == KEEP))
        if sum(len(links) for links in kept) > MOST_LINKS:
            asked = f"links of form factors up to {rules.form_factor:g} are more than {MOST_LINKS}"
            raise SceneError([Fault("command line", "--link-form-factor", asked, "a larger one, or --links rows")])
        pending = _children(nodes, found, decision)
    return Links(
        first=np.concatenate([links.first for links in kept]),
        second=np.concatenate([links.second for links in kept]),
        factor=np.concatenate([links.factor for links in kept]),
        sight=np.concatenate([links.sight for links in kept]),
    )


def _root_links(finder: LinkFinder, nodes: Nodes, space: NDArray[np.integer], rules: Refinement) -> Links:
    """Pairs of roots of one space that may see each other; a root with itself only if it is a group."""
    roots = nodes.roots
    n = len(roots)
    is_group = np.diff(nodes.facet_start)[roots] > 1
    first, second = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    rows_at_once = max(1, BATCH_PAIRS // max(n, 1))
    for low in range(0, n, rows_at_once):
        i, j = np.indices((min(rows_at_once, n - low), n - low)).reshape(2, -1) + low
        same = space[i] == space[j]
        wanted = same & ((i < j) | ((i == j) & is_group[i]))
        p, q = roots[i[wanted]], roots[j[wanted]]
        sees = finder.judge(p, q, rules.form_factor)[0] != DROP
        first.append(p[sees])
        second.append(q[sees])
    p, q = np.concatenate(first), np.concatenate(second)
    sight = np.full(len(p), UNKNOWN if rules.occlusion else FREE, np.uint8)
    return Links(p, q, np.zeros(len(p), np.float32), sight)


def _split_partial(
    finder: LinkFinder, nodes: Nodes, found: Links, decision: NDArray[np.uint8], rules: Refinement
) -> None:
    """Split links that rays find partly hidden, and that are not small; changes `decision`."""
    area, p, q = finder.area, found.first, found.second
    first_splits = (p >= nodes.n_rows) & ((area[p] >= area[q]) | (q < nodes.n_rows))
    second_splits = (q >= nodes.n_rows) & ~first_splits
    tried = np.flatnonzero(
        (decision == KEEP)
        & (found.sight == UNKNOWN)
        & (found.factor > PARTIAL_SHARE * rules.form_factor)
        & (first_splits | second_splits)
    )
    share = finder.sample(found.subset(tried), np.full(len(tried), PARTIAL_SAMPLES), rules.seed)
    partial = tried[(share > 0.0) & (share < 1.0)]
    decision[partial] = np.where(first_splits[partial], SPLIT_FIRST, SPLIT_SECOND)


def _children(nodes: Nodes, found: Links, decision: NDArray[np.uint8]) -> Links:
    """The pairs that split ones leave; what is proved of a pair holds for its parts."""
    parts = []
    for verdict in (SPLIT_FIRST, SPLIT_SECOND):
        chosen = np.flatnonzero(decision == verdict)
        split, other = (found.first, found.second) if verdict == SPLIT_FIRST else (found.second, found.first)
        count = np.diff(nodes.child_start)[split[chosen]]
        origin = np.repeat(chosen, count)
        within = np.arange(len(origin)) - np.repeat(np.cumsum(count) - count, count)
        child = nodes.child[nodes.child_start[split[origin]] + within]
        pair = (child, other[origin]) if verdict == SPLIT_FIRST else (other[origin], child)
        parts.append((*pair, found.sight[origin]))
    first, second, sight = (np.concatenate(arrays) for arrays in zip(*parts))
    return Links(first, second, np.zeros(len(first), np.float32), sight)

"""How far interpolation in leaves is from the light, by what each split of a leaf brought to light."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.leaves import CENTRE, Leaves

_QUAD: Final = np.array(
    [
        [[2, 0, 0, 0, 0], [1, 1, 0, 0, 0], [0, 0, 0, 0, 2], [1, 0, 0, 1, 0], [1, 0, 0, 0, 1]],
        [[1, 1, 0, 0, 0], [0, 2, 0, 0, 0], [0, 1, 1, 0, 0], [0, 0, 0, 0, 2], [0, 1, 0, 0, 1]],
        [[1, 0, 0, 1, 0], [0, 0, 0, 0, 2], [0, 0, 1, 1, 0], [0, 0, 0, 2, 0], [0, 0, 0, 1, 1]],
        [[0, 0, 0, 0, 2], [0, 1, 1, 0, 0], [0, 0, 2, 0, 0], [0, 0, 1, 1, 0], [0, 0, 1, 0, 1]],
    ],
    np.float64,
)
_TRIANGLE: Final = np.array(
    [
        [[2, 0, 0, 0, 0], [1, 1, 0, 0, 0], [1, 0, 1, 0, 0], [1, 0, 1, 0, 0], [1, 0, 0, 0, 1]],
        [[1, 1, 0, 0, 0], [0, 2, 0, 0, 0], [0, 1, 1, 0, 0], [0, 1, 1, 0, 0], [0, 1, 0, 0, 1]],
        [[1, 0, 1, 0, 0], [0, 1, 1, 0, 0], [0, 0, 2, 0, 0], [0, 0, 2, 0, 0], [0, 0, 1, 0, 1]],
        [[0, 1, 1, 0, 0], [1, 0, 1, 0, 0], [1, 1, 0, 0, 0], [1, 1, 0, 0, 0], [0, 0, 0, 0, 2]],
    ],
    np.float64,
)
FROM_PARENT: Final = 0.5 * np.stack([_QUAD, _TRIANGLE])
"""(2, 4, 5, 5): what the fan of a parallelogram or a triangle has at corners and centre of each of its children, as
weights of its own corners and centre."""
NEW: Final = FROM_PARENT.max(axis=3) < 1.0
"""(2, 4, 5): places of the children that the parent has no vertex at."""
DECAY: Final = 0.35
"""What is left of the error when edges are halved: a quarter in smooth light, half at a kink."""
FAN: Final = 0.5
"""Root mean square over the leaf of the error of a fan, over what its centre differs from the mean of its corners, at
a kink through the leaf."""
UNSEEN: Final = 0.12
"""Part of the range of light around that a leaf which is partly inside of something may be wrong by; this and `DECAY`
take the fewest leaves on the floor of the office."""


ENOUGH: Final = 2
"""Known vertices from which on their range tells how much light changes in a leaf."""


class LeafErrors:
    """Estimated errors of nodes, which grow in number; light is a number at each corner and centre.

    Nodes come with ``light`` (n, 5), its ``variance`` (n, 5), which is taken out of what the light seems to change
    by, and ``known`` (n, 5), False where the vertex lies inside a solid or is repeated.
    """

    def __init__(self) -> None:
        self._light, self._variance = np.zeros((2, 0, CENTRE + 1))
        self._known = np.zeros((0, CENTRE + 1), np.bool_)
        self._from_parent = np.zeros(0)
        self._range = np.zeros(0)

    def add(
        self, leaves: Leaves, light: NDArray[np.float64], variance: NDArray[np.float64], known: NDArray[np.bool_]
    ) -> None:
        """Take the nodes into account that are new among the leaves, parents before children.

        Parameters
        ----------
        leaves : Leaves
        light, variance : (n, 5) float64
        known : (n, 5) bool
        """
        before = len(self._from_parent)
        self._light, self._known = np.concatenate([self._light, light]), np.concatenate([self._known, known])
        self._variance = np.concatenate([self._variance, variance])
        n_roots = leaves.n_nodes if before == 0 else 0
        self._from_parent = np.concatenate([self._from_parent, np.zeros(n_roots)])
        self._range = np.concatenate([self._range, self._spread(np.arange(before, before + n_roots))])
        while len(self._from_parent) < leaves.n_nodes:
            self._inherit(leaves, np.arange(len(self._from_parent), leaves.n_nodes))

    def _spread(self, nodes: NDArray[np.int64]) -> NDArray[np.float64]:
        """What the light on each node may differ by: its range, or all of it where few vertices know."""
        light, known = self._light[nodes], self._known[nodes]
        high = np.where(known, light, 0.0).max(axis=1, initial=0.0)
        low = np.where(known, light, np.inf).min(axis=1, initial=np.inf)
        spread: NDArray[np.float64] = np.where(known.sum(axis=1) < ENOUGH, high, high - low)
        return spread

    def _inherit(self, leaves: Leaves, nodes: NDArray[np.int64]) -> None:
        """What the parents of nodes missed; of the first nodes, as far as their parents are known already."""
        parent = np.full(leaves.n_nodes, -1)
        split = np.flatnonzero(~leaves.is_leaf)
        first = leaves.first_child[split].astype(np.int64)
        parent[(first[:, None] + np.arange(4)).ravel()] = np.repeat(split, 4)
        late = parent[nodes] >= len(self._from_parent)
        nodes = nodes[: int(np.argmax(late))] if late.any() else nodes
        above = parent[nodes]
        child = nodes - leaves.first_child[above]
        kind = leaves.is_triangle[nodes].astype(np.int64)
        weights = FROM_PARENT[kind, child]
        told = np.einsum("npq,nq->np", weights, np.where(self._known[above], self._light[above], 0.0))
        sure = self._known[nodes] & NEW[kind, child]
        sure &= np.einsum("npq,nq->np", weights, self._known[above].astype(float)) > 1.0 - 1e-9
        noise = self._variance[nodes] + np.einsum("npq,nq->np", weights**2, self._variance[above])
        missed = np.where(sure, (self._light[nodes] - told) ** 2 - noise, 0.0)
        mean_square = np.maximum(missed.sum(axis=1), 0.0) / np.maximum(sure.sum(axis=1), 1)
        inherited = DECAY * np.maximum(np.sqrt(mean_square), 0.5 * self._from_parent[above])
        spread = np.maximum(self._spread(nodes), 0.5 * self._range[above])
        self._from_parent = np.concatenate([self._from_parent, inherited])
        self._range = np.concatenate([self._range, spread])

    def of(self, nodes: NDArray[np.integer]) -> NDArray[np.float64]:
        """(n,) root mean square error that interpolation is expected to have on each node."""
        light, known = self._light[nodes], self._known[nodes]
        corners = known[:, :CENTRE].sum(axis=1)
        mean = (light * known)[:, :CENTRE].sum(axis=1) / np.maximum(corners, 1)
        variance = self._variance[nodes] * known
        noise = variance[:, CENTRE] + variance[:, :CENTRE].sum(axis=1) / np.maximum(corners, 1) ** 2
        square = np.maximum((light[:, CENTRE] - mean) ** 2 - noise, 0.0)
        bend = np.where((corners > 0) & known[:, CENTRE], np.sqrt(square), 0.0)
        error = np.maximum(FAN * bend, FAN * self._from_parent[nodes])
        return np.asarray(error)

    def hidden(self, nodes: NDArray[np.integer], covered: NDArray[np.bool_]) -> NDArray[np.float64]:
        """(n,) further error of nodes that are partly inside of something, by their (n,) `covered` vertices."""
        return np.where(covered, UNSEEN * self._range[nodes], 0.0)

"""Exchange over links at several levels: reciprocal by construction, closed at the row elements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from hradiosity.space.hierarchy import UNLIT, Elements
from hradiosity.space.nodes import Nodes
from hradiosity.space.shafts import UNKNOWN
from hradiosity.transport.exchange import (
    ClosedRows,
    Defects,
    Exchange,
    RowHits,
    close_rows,
    row_sum_defects,
    seen_areas,
    weighted_rms,
)
from hradiosity.transport.link_factors import open_exchange
from hradiosity.transport.links import LinkFinder, Links, Refinement, refine_links


@dataclass(frozen=True)
class LinkedNodes:
    """What stays the same from replicate to replicate.

    links : Links
    exchange : (n_links,) float64, A F of each without obstacles [m²]
    n_samples : (n_links,) int64, shadow rays of each; 0 where the sight is proved
    """

    nodes: Nodes
    finder: LinkFinder
    links: Links
    exchange: NDArray[np.float64]
    n_samples: NDArray[np.int64]

    @property
    def proved_share(self) -> float:
        """Share of the links that shafts prove free."""
        return float((self.links.sight != UNKNOWN).mean()) if len(self.links) else 0.0


@dataclass(frozen=True)
class LinkExchange(ClosedRows):
    """K = D Pᵀ V P D + diag(own), with P the sums over what lies below each node, times the area of its row elements.

    V holds the links, CSR by receiving node, both directions.

    nodes : Nodes
    start, source : (n_nodes + 1,), (n_directed,) uint32
    value : (n_directed,) float64, exchange area over the exposed areas of both nodes [m⁻²]
    scale : (n_rows,) float64, factors D that closed the rows
    own : (n_rows,) float64, exchange of each row element with itself, which closing left [m²]
    blocked, partial : shares of the links that this replicate's rays found hidden, and partly hidden
    """

    nodes: Nodes
    start: NDArray[np.uint32]
    source: NDArray[np.uint32]
    value: NDArray[np.float64]
    scale: NDArray[np.float64]
    own: NDArray[np.float64]
    blocked: float
    partial: float

    @cached_property
    def gathering(self) -> csr_array:
        """P, (n_nodes, n_rows)."""
        return self.nodes.gathering()

    @cached_property
    def links(self) -> csr_array:
        """V, (n_nodes, n_nodes)."""
        n = len(self.nodes)
        return csr_array((self.value, self.source.astype(np.int64), self.start.astype(np.int64)), shape=(n, n))

    def received(self, exitance: NDArray[np.float64]) -> NDArray[np.float64]:
        """K times values of the row elements, (n_rows,) or (n_rows, k): the power that each receives of an exitance."""
        weight = self.scale * self.element_area
        gathered = self.gathering.T @ (self.links @ (self.gathering @ (weight * exitance.T).T))
        power: NDArray[np.float64] = (weight * gathered.T + self.own * exitance.T).T
        return power

    def flattened(self) -> Exchange:
        """The same exchange between single row elements; nearly every pair that sees each other has an entry."""
        weight = diags_array(self.scale * self.element_area, format="csr")
        below = csr_array(self.gathering @ weight)
        flat = csr_array(below.T @ (self.links @ below) + diags_array(self.own, format="csr"))
        flat.sort_indices()
        return Exchange(
            outside=self.outside,
            sky=self.sky,
            element_area=self.element_area,
            defects=self.defects,
            start=flat.indptr.astype(np.uint32),
            source=flat.indices.astype(np.uint32),
            area=flat.data,
        )


def link_nodes(
    finder: LinkFinder, nodes: Nodes, space: NDArray[np.integer], rules: Refinement, most_samples: int
) -> LinkedNodes:
    """Find the links, prove what can be proved, and integrate their form factors.

    Parameters
    ----------
    finder, nodes, space, rules : see `refine_links`
    most_samples : int
        Shadow rays of links as large as the refinement allows, and of larger ones; others get a share.
    """
    links = refine_links(finder, nodes, space, rules)
    exchange = open_exchange(finder.device, nodes, links.first, links.second)
    share = np.ceil(most_samples * links.factor.astype(np.float64) / rules.form_factor)
    samples = np.where(links.sight == UNKNOWN, np.clip(share, 1, most_samples), 0)
    return LinkedNodes(nodes, finder, links, exchange, samples.astype(np.int64))


def build_link_exchange(linked: LinkedNodes, hits: RowHits, elements: Elements, seed: int) -> LinkExchange:
    """Sample how much of each link is open, spread it over exposed areas, and close the rows.

    Rows are closed by factors of the row elements, as for links between them alone: factors of nodes could not mend
    what differs below a node. `hits` tell the exposed areas and what lies outside.
    """
    nodes, links = linked.nodes, linked.links
    element_area, outside, sky = seen_areas(hits, elements)
    gathering = nodes.gathering()
    doubtful = np.flatnonzero(linked.n_samples)
    share = np.ones(len(links))
    share[doubtful] = linked.finder.sample(links.subset(doubtful), linked.n_samples[doubtful], seed)
    area = gathering @ element_area
    both = area[links.first] * area[links.second]
    value = np.divide(linked.exchange * share, both, out=np.zeros(len(links)), where=both > 0.0)
    matrix = _symmetric(links, value, len(nodes))

    def received(x: NDArray[np.float64]) -> NDArray[np.float64]:
        power: NDArray[np.float64] = element_area * (gathering.T @ (matrix @ (gathering @ (element_area * x))))
        return power

    before = row_sum_defects(received(np.ones(len(elements))), outside, element_area)
    scale, own, closing = _closed(received, outside, element_area)
    return LinkExchange(
        outside=outside * scale,
        sky=sky * scale,
        element_area=element_area,
        defects=Defects(
            row_sum_rms=before["row_sum_rms"],
            row_sum_max=before["row_sum_max"],
            **closing,
            reciprocity_rms=0.0,
            lost_share=float((hits.row == UNLIT).mean()) if hits.row.size else 0.0,
        ),
        nodes=nodes,
        start=matrix.indptr.astype(np.uint32),
        source=matrix.indices.astype(np.uint32),
        value=matrix.data,
        scale=scale,
        own=own,
        blocked=float((share == 0.0).mean()) if len(links) else 0.0,
        partial=float(((share > 0.0) & (share < 1.0)).mean()) if len(links) else 0.0,
    )


def _symmetric(links: Links, value: NDArray[np.float64], n_nodes: int) -> csr_array:
    """Both directions of the links that carry light; a link of a node with itself once."""
    carries = value > 0.0
    back = carries & (links.first != links.second)
    row = np.concatenate([links.first[carries], links.second[back]])
    column = np.concatenate([links.second[carries], links.first[back]])
    matrix = csr_array((np.concatenate([value[carries], value[back]]), (row, column)), shape=(n_nodes, n_nodes))
    matrix.sort_indices()
    return matrix


def _closed(
    received: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    outside: NDArray[np.float64],
    area: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], dict[str, Any]]:
    """Factors, what rows lack with them and keep for themselves, and the defects of closing.

    No row may give more than it has. A link's value is shared by all row elements below, so that an excess can't be
    trimmed link by link: the row's own factor shrinks, and what that takes from others they keep for themselves.
    """
    scale, steps = close_rows(received, outside, area)
    total = scale * (received(scale) + outside)
    counts = area > 0.0
    residual = float(np.abs(total[counts] / area[counts] - 1.0).max(initial=0.0))
    first = scale
    scale = scale * np.minimum(np.divide(area, total, out=np.ones_like(area), where=total > 0.0), 1.0)
    own = np.maximum(area - scale * (received(scale) + outside), 0.0)
    whole = float(area.sum())
    return (
        scale,
        own,
        {
            "scale_rms": weighted_rms(first - 1.0, area),
            "scale_max": float(np.abs(first - 1.0)[counts].max(initial=0.0)),
            "self_share": float(own.sum()) / whole if whole > 0.0 else 0.0,
            "closure_residual": residual,
            "closure_steps": steps,
        },
    )

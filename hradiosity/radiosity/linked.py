"""Exchange over hierarchical links in place of rows of rays; all else is as there."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hradiosity.plan import Calibration, ClassicCalibration, LinkCount, Plan
from hradiosity.radiosity.solver import RadiositySolver
from hradiosity.radiosity.surfaces import SurfaceSolver
from hradiosity.solvers.dense import check_dense_size
from hradiosity.solvers.link_operator import MULTILEVEL_SOLVERS, LinkOperator
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.space.hierarchy import UNLIT, Elements
from hradiosity.space.lit_sides import LitSides
from hradiosity.space.nodes import build_nodes
from hradiosity.space.shafts import FARTHEST
from hradiosity.transport.exchange import ClosedRows, Exchange, RowHits
from hradiosity.transport.link_exchange import LinkedNodes, LinkExchange, build_link_exchange, link_nodes
from hradiosity.transport.links import LinkFinder, Refinement

EXPOSURE_RAYS = 16
"""Rays a replicate that tell how much of an element is exposed, where no space is open."""
LINK_BYTES = 64
"""Of a link on the host and on the device."""


class LinkedSurfaces(SurfaceSolver):
    """Estimates the light on all row elements over links at several levels (Hanrahan, Salzman & Aupperle 1991).

    The links are found once; each replicate samples afresh which part of those is open that are not proved free.
    Parameters as of `SurfaceSolver`.
    """

    exchange_by_rays = False
    linked: LinkedNodes

    def count_links(self) -> LinkCount:
        """What was found."""
        links, nodes = self.linked.links, self.linked.nodes
        level = np.searchsorted(nodes.level_start, np.minimum(links.first, links.second), side="right") - 1
        per_level = np.bincount(level, minlength=nodes.n_levels)
        return LinkCount(
            form_factor=self.options.link_form_factor,
            per_level=tuple(int(n) for n in per_level),
            proved_share=self.linked.proved_share,
            rays=int(self.linked.n_samples.sum()),
        )

    def sized_plan(self, calibration: Calibration | ClassicCalibration | None) -> Plan:
        """The plan with the links that were found; expected seconds are not known in this mode.

        Raises
        ------
        SceneError
            When the solver asked for would need too much memory.
        """
        n_rows = len(self.elements)
        if self.options.solver not in MULTILEVEL_SOLVERS and self.plan.interreflection:
            check_dense_size(n_rows, self.options.solver)
        plan = super().sized_plan(None)
        count = self.count_links()
        return replace(plan, links=count, memory_bytes=plan.memory_bytes + LINK_BYTES * count.total)

    def _cut(self, lit: LitSides) -> None:
        super()._cut(lit)
        self._lit, self._seen = lit, np.zeros((0, 2), np.int64)
        self.shares: dict[str, float] = {}
        self._find_links()

    def _divide(self, lit: LitSides) -> Elements:
        """The row elements, as by rows; rays from them only tell what is covered and what is outside."""
        if not lit.open.any():
            self.plan = replace(self.plan, rays_per_element=min(EXPOSURE_RAYS, self.plan.rays_per_element))
        return super()._divide(lit)

    def _find_links(self) -> None:
        """Links inside each lit space; spaces that rays were seen to pass between count as one."""
        n_spaces = len(self._lit.open)
        seen = coo_array((np.ones(len(self._seen)), tuple(self._seen.T)), shape=(n_spaces, n_spaces))
        joined = connected_components(seen, directed=False)[1]
        nodes = build_nodes(self.scene.patches, self.elements)
        side = nodes.facets.side[nodes.facet_start[nodes.roots]]
        rules = Refinement(
            form_factor=self.options.link_form_factor,
            occlusion=self.plan.occlusion,
            reach=FARTHEST * self._lit.free_path,
            seed=self.options.seed,
        )
        with self.record.timed("links"):
            self.linked = link_nodes(
                LinkFinder(self.on_device, nodes),
                nodes,
                joined[self._lit.space.ravel()[side]],
                rules,
                max(4, self.options.rays_per_element // self.plan.replicates),
            )

    def _exchange(self, hits: RowHits, seed: int) -> LinkExchange:
        """Links with the open shares of this replicate."""
        self._join_spaces(hits)
        self.record.rays += int(self.linked.n_samples.sum())
        return build_link_exchange(self.linked, hits, self.elements, seed ^ 0x2545F491)

    def _join_spaces(self, hits: RowHits) -> None:
        """Find the links again if rays pass between spaces that were thought to be apart."""
        row, sample = np.nonzero(hits.row < UNLIT)
        pairs = np.column_stack([self.space[row], self.space[hits.row[row, sample]]]).astype(np.int64)
        seen = np.unique(np.concatenate([self._seen, pairs[pairs[:, 0] != pairs[:, 1]]]), axis=0)
        if len(seen) > len(self._seen):
            self._seen = seen
            self._find_links()

    def _operator(self, exchange: ClosedRows) -> ExchangeOperator:
        """Over all levels, or between single elements for solvers that need rows."""
        if not isinstance(exchange, LinkExchange):
            raise TypeError(f"links are wanted, not {type(exchange).__name__}")
        self.shares = {"blocked": exchange.blocked, "partly_hidden": exchange.partial}
        if self.options.solver in MULTILEVEL_SOLVERS:
            return LinkOperator(self.device, exchange)
        return super()._operator(exchange)

    def _rows(self, exchange: ClosedRows) -> Exchange:
        """The same between single elements."""
        return exchange.flattened() if isinstance(exchange, LinkExchange) else super()._rows(exchange)

    def checkpoint(self) -> dict[str, NDArray[Any]]:
        """Everything that `restore` needs beside the constructor's arguments."""
        return super().checkpoint() | {"seen_spaces": self._seen}

    def restore(self, kept: Any) -> None:
        """Go on from a checkpoint, bit for bit."""
        super().restore(kept)
        if len(kept["seen_spaces"]):
            self._seen = kept["seen_spaces"]
            self._find_links()


class LinkedSolver(RadiositySolver):
    """A run like that of `RadiositySolver` with hierarchical links; parameters and use are the same."""

    surface_solver = LinkedSurfaces

    def _summary(self) -> dict[str, Any]:
        surfaces = self._prepare()
        if not isinstance(surfaces, LinkedSurfaces):
            return super()._summary()
        count = surfaces.count_links()
        return super()._summary() | {"links": asdict(count) | {"total": count.total} | surfaces.shares}

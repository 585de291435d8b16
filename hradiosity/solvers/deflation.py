"""The few nearly constant vectors, one for each nearly closed space, that slow an iteration down; and their removal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.solvers.column_algebra import column_dot
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns

LANCZOS_STEPS = 20
DEFLATE_ABOVE = 0.8
"""Ritz values of S above this are deflated; each is a nearly constant vector on one space."""


def deflation_vectors(operator: ExchangeOperator, spaces: NDArray[np.int32]) -> NDArray[np.float64]:
    """Ritz vectors of S with values above 0.8, (n_rows, k): one for each nearly closed space.

    Parameters
    ----------
    spaces : (n_rows,) int32
        Connected space of each element; the start holds one vector for each (at most 8), so that spaces which are
        not connected at all are found as well.
    """
    n_spaces = min(int(spaces.max(initial=-1)) + 1, 8)
    rng = np.random.Generator(np.random.Philox(key=1))
    start = [operator.root_area * (spaces == k) for k in range(n_spaces)]
    start.append(operator.root_area * (1.0 + rng.random(operator.n_rows)))
    basis: list[NDArray[np.float64]] = []
    images: list[NDArray[np.float64]] = []
    for vector in start:
        candidate = np.asarray(vector, np.float64)
        for _ in range(LANCZOS_STEPS if vector is start[-1] else 1):
            candidate = _orthonormalise(candidate, basis)
            if not candidate.any():
                break
            basis.append(candidate)
            images.append(operator.apply_vector(candidate))
            candidate = images[-1]
    if not basis:
        return np.zeros((operator.n_rows, 0))
    q, image = np.column_stack(basis), np.column_stack(images)
    values, vectors = np.linalg.eigh(np.einsum("ni,nj->ij", q, image))
    kept: NDArray[np.float64] = np.einsum("ni,ik->nk", q, vectors[:, values > DEFLATE_ABOVE])
    return kept


def _orthonormalise(vector: NDArray[np.float64], basis: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    size = np.sqrt(np.einsum("n,n->", vector, vector))
    for _ in range(2):
        for q in basis:
            vector = vector - np.einsum("n,n->", q, vector) * q
    norm = np.sqrt(np.einsum("n,n->", vector, vector))
    return vector / norm if norm > 1e-10 * size else np.zeros_like(vector)


class CoarseSpace:
    """The deflation space of each column: W, A W and (Wᵀ A W)⁻¹ with A = I − R½ S R½.

    W is 0 at black elements, where the solution is: a part of it that came back there would be all of their residual,
    however small.
    """

    def __init__(self, operator: ExchangeOperator, root: Columns, vectors: NDArray[np.float64]) -> None:
        self.size, self._dtype = vectors.shape[1], operator.dtype
        self._w = vectors.astype(self._dtype)
        self._reflects = (root > 0.0).astype(self._dtype)
        self._aw = [self._reflects * w[:, None] - root * operator.apply(root * w[:, None]) for w in self._w.T]
        small = np.array([[column_dot(w[:, None], aw) for aw in self._aw] for w in self._w.T])
        # Where all of a vector's elements are black nothing is left of it, and the matrix has no inverse.
        self._inverse = np.linalg.pinv(np.moveaxis(small, 2, 0), hermitian=True)

    def project(self, residual: Columns) -> Columns:
        """W (Wᵀ A W)⁻¹ (A W)ᵀ r: the part of a direction that is not conjugate to W."""
        return self._combine(np.array([column_dot(aw, residual) for aw in self._aw]))

    def remove(self, residual: Columns) -> tuple[Columns, Columns]:
        """W c and A W c with c = (Wᵀ A W)⁻¹ Wᵀ r."""
        factors = self._factors(np.array([column_dot(w[:, None], residual) for w in self._w.T]))
        image = np.zeros_like(residual)
        for aw, factor in zip(self._aw, factors):
            image += aw * factor
        return self._reflects * np.einsum("ni,ic->nc", self._w, factors), image

    def _factors(self, right: NDArray[np.float64]) -> Columns:
        factors: Columns = np.einsum("cij,jc->ic", self._inverse, right).astype(self._dtype)
        return factors

    def _combine(self, right: NDArray[np.float64]) -> Columns:
        combined: Columns = self._reflects * np.einsum("ni,ic->nc", self._w, self._factors(right))
        return combined

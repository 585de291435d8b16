"""The few nearly constant vectors, one for each nearly closed space, that slow an iteration down; and their removal."""

from __future__ import annotations

from typing import Generic

import numpy as np
from numpy.typing import NDArray

from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Columns
from hradiosity.solvers.vectors import V, Vectors

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


class CoarseSpace(Generic[V]):
    """The deflation space of each column: W, A W and (Wᵀ A W)⁻¹ with A = I − R½ S R½.

    W is 0 at black elements, where the solution is: a part of it that came back there would be all of their residual,
    however small.

    Parameters
    ----------
    vectors : Vectors
        The algebra of A.
    root : (n_rows, 8 n_groups), R½
    deflation : (n_rows, k) float64
        From `deflation_vectors`.
    """

    def __init__(self, vectors: Vectors[V], root: Columns, deflation: NDArray[np.float64]) -> None:
        self.size, self._vectors = deflation.shape[1], vectors
        self._w = [vectors.put(np.where(root > 0.0, w[:, None], 0.0).astype(root.dtype)) for w in deflation.T]
        self._aw = [vectors.put(np.zeros_like(root)) for _ in self._w]
        for image, w in zip(self._aw, self._w):
            vectors.image(image, w)
        small = np.array([[vectors.products(w, aw).sum(axis=0) for aw in self._aw] for w in self._w])
        # Where all of a vector's elements are black nothing is left of it, and the matrix has no inverse.
        self._inverse = np.linalg.pinv(np.moveaxis(small, 2, 0), hermitian=True)

    def project(self, vector: V, direction: V) -> None:
        """Take W (Wᵀ A W)⁻¹ (A W)ᵀ v off a direction: its part that is not conjugate to W, if v is the direction."""
        for factor, w in zip(self._factors(self._aw, vector), self._w):
            self._vectors.add(direction, -factor, w)

    def remove(self, residual: V, solution: V) -> None:
        """Add W c to the solution, and take A W c off the residual, with c = (Wᵀ A W)⁻¹ Wᵀ r."""
        for factor, w, aw in zip(self._factors(self._w, residual), self._w, self._aw):
            self._vectors.add(solution, factor, w)
            self._vectors.add(residual, -factor, aw)

    def _factors(self, rows: list[V], vector: V) -> NDArray[np.float64]:
        """(k, n_columns) (Wᵀ A W)⁻¹ times the products of some vectors with one."""
        right = np.array([self._vectors.products(row, vector).sum(axis=0) for row in rows])
        factors: NDArray[np.float64] = np.einsum("cij,jc->ic", self._inverse, right)
        return factors

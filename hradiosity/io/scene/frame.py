"""From the units and axes of a file to metres with z up."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hradiosity.io.meshes import METRES


@dataclass(frozen=True)
class Frame:
    """Unit and upward axis of a file.

    unit : m, cm, mm, in or ft
    up : z or y; with y up, (x, y, z) of the file is (x, −z, y) here: right-handed, x stays
    """

    unit: str
    up: str

    def directions(self, values: ArrayLike) -> NDArray[np.float64]:
        """(…, 3) vectors whose length has no meaning, turned to z up."""
        array = np.asarray(values, dtype=np.float64)
        if self.up == "y":
            array = np.stack([array[..., 0], 0.0 - array[..., 2], array[..., 1]], axis=-1)
        return array

    def points(self, values: ArrayLike) -> NDArray[np.float64]:
        """(…, 3) points or edges of the file, in metres with z up."""
        return self.directions(values) * METRES[self.unit]

    def length(self, value: float) -> float:
        """A length of the file in metres."""
        return value * METRES[self.unit]


def rotation(axis: Sequence[float] | NDArray[np.float64], angle_deg: float) -> NDArray[np.float64]:
    """(3, 3) right-handed rotation about an axis (any length but 0) by an angle in degrees (Rodrigues' formula)."""
    turn: NDArray[np.float64] = rotations(np.asarray(axis, np.float64)[None], np.array([angle_deg]))[0]
    return turn


def rotations(axis: NDArray[np.float64], angle_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3, 3) right-handed rotations about axes (n, 3) by angles (n,) in degrees; see `rotation`."""
    x, y, z = (axis / np.linalg.norm(axis, axis=1, keepdims=True)).T
    none = np.zeros_like(x)
    cross = np.array([[none, -z, y], [z, none, -x], [-y, x, none]]).transpose(2, 0, 1)
    angle = np.radians(angle_deg)
    # A quarter turn shall keep axis-parallel faces axis-parallel to the last bit.
    sine, cosine = (
        np.where(np.abs(value) < 1e-15, 0.0, value)[:, None, None] for value in (np.sin(angle), np.cos(angle))
    )
    turned: NDArray[np.float64] = np.eye(3) + sine * cross + (1.0 - cosine) * np.einsum("nij,njk->nik", cross, cross)
    return turned

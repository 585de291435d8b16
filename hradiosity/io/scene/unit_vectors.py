"""Directions of a scene file."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.report import Report

UP: Final = np.array([0.0, 0.0, 1.0])


def unit_vectors(vectors: ArrayLike, location: Location, report: Report) -> NDArray[np.float64]:
    """(n, 3) vectors at length 1; one without direction is reported and points up."""
    array = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    length = np.linalg.norm(array, axis=1, keepdims=True)
    for number in np.flatnonzero(length[:, 0] == 0.0):
        which = f"vector {number} " if len(array) > 1 else ""
        report.fault(location, f"{which}[0, 0, 0] has no direction", "a vector with a length")
    return np.where(length > 0.0, array / np.where(length > 0.0, length, 1.0), UP)

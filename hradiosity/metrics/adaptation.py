"""Chromatic adaptation: how colours look once the eye has taken a light for white."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

_CAT16: Final = np.array(
    [[0.401288, 0.650173, -0.051461], [-0.250268, 1.204414, 0.045854], [-0.002079, 0.048952, 0.953127]]
)
"""Sharpened responses from X, Y, Z. Li, Li, Wang, Xu, Luo, Cui, Melgosa, Brill & Pointer (2017), CAT16."""


def adaptation_matrix(white: NDArray[np.float64], shown_as: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix from X, Y, Z under one white to colours that look alike under another, adaptation being complete.

    The one-step transform of CAT16 with D = 1: responses scale with those to the whites, both taken at Y = 1.

    Parameters
    ----------
    white : (3,) float64
        X, Y, Z of the light that is taken for white, in any unit.
    shown_as : (3,) float64
        X, Y, Z of the white that it becomes, in any unit.

    Returns
    -------
    (3, 3) float64
        Luminance Y of `white` stays what it is.

    Raises
    ------
    ValueError
        When a white has no luminance, or no eye could take it for white: a response to it is not positive.
    """
    if not (white[1] > 0.0 and shown_as[1] > 0.0):
        raise ValueError(f"whites must have luminance, are {white} and {shown_as}")
    before, after = (np.einsum("rc,c->r", _CAT16, w / w[1]) for w in (white, shown_as))
    if not ((before > 0.0).all() and (after > 0.0).all()):
        raise ValueError(f"{white} can't be taken for white: a sharpened response to it is not positive")
    matrix: NDArray[np.float64] = np.linalg.solve(_CAT16, (after / before)[:, None] * _CAT16)
    return matrix

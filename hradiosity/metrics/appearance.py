"""Colour appearance: CIECAM02 (CIE 159:2004) and the uniform space CAM02-UCS of Luo, Cui and Li 2006."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

ADAPTING_LUMINANCE: Final = 100.0
"""L_A [cd m⁻²] of CIE 224:2017."""
BACKGROUND: Final = 20.0
"""Y_b, luminance of the background where white has 100; CIE 224:2017."""
IMPACT: Final = 0.69
"""Factor c of an average surround, whose other factors are 1; adaptation is complete (D = 1)."""
_CAT02: Final = np.array([[0.7328, 0.4296, -0.1624], [-0.7036, 1.6975, 0.0061], [0.0030, 0.0136, 0.9834]])
_CONES: Final = np.array([[0.38971, 0.68898, -0.07868], [-0.22981, 1.18340, 0.04641], [0.0, 0.0, 1.0]])
_HPE_FROM_CAT02: Final = _CONES @ np.linalg.inv(_CAT02)
"""From the sharpened responses of adaptation to those of Hunt, Pointer and Estévez."""
_ACHROMATIC: Final = np.array([2.0, 1.0, 0.05])
_LEVEL: Final = 0.2 * (1.0 / (5.0 * ADAPTING_LUMINANCE + 1.0)) ** 4 * 5.0 * ADAPTING_LUMINANCE + 0.1 * (
    1.0 - (1.0 / (5.0 * ADAPTING_LUMINANCE + 1.0)) ** 4
) ** 2 * (5.0 * ADAPTING_LUMINANCE) ** (1.0 / 3.0)
"""F_L, how far responses are compressed at this luminance."""


def uniform_appearance(tristimulus: NDArray[np.float64], white: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lightness and the two opponent coordinates of CAM02-UCS, as seen in the conditions of CIE 224:2017.

    Parameters
    ----------
    tristimulus : (n, 3, m) float64
        X, Y, Z of m surfaces under each of n lights, in any scale.
    white : (n, 3) float64
        Of the perfect diffuser under each light, in the same scale.

    Returns
    -------
    (n, 3, m) float64
        J′, a′, b′.
    """
    scale = 100.0 / white[:, 1]
    adaptation = 100.0 / np.einsum("nc,rc->nr", white * scale[:, None], _CAT02)
    matrix = np.einsum("pr,nr,rc->npc", _HPE_FROM_CAT02, adaptation, _CAT02) * scale[:, None, None]
    response = _compressed(np.einsum("npc,ncm->npm", matrix, tristimulus))
    response_white = _compressed(np.einsum("npc,nc->np", matrix, white))
    relative = BACKGROUND / 100.0
    induction = 0.725 * relative**-0.2
    achromatic = np.einsum("p,npm->nm", _ACHROMATIC, response) - 0.305
    achromatic_white = np.einsum("p,np->n", _ACHROMATIC, response_white) - 0.305
    exponent = IMPACT * (1.48 + np.sqrt(relative))
    lightness = 100.0 * (np.maximum(achromatic, 0.0) / achromatic_white[:, None]) ** exponent
    red, green, blue = np.moveaxis(response, 1, 0)
    a, b = red - (12.0 * green - blue) / 11.0, (red + green - 2.0 * blue) / 9.0
    hue = np.arctan2(b, a)
    eccentricity = 0.25 * (np.cos(hue + 2.0) + 3.8)
    strength = 50000.0 / 13.0 * induction * eccentricity * np.hypot(a, b)
    strength /= red + green + 1.05 * blue
    chroma = np.maximum(strength, 0.0) ** 0.9 * np.sqrt(lightness / 100.0) * (1.64 - 0.29**relative) ** 0.73
    colourfulness = np.log1p(0.0228 * chroma * _LEVEL**0.25) / 0.0228
    prime = 1.7 * lightness / (1.0 + 0.007 * lightness)
    return np.stack([prime, colourfulness * np.cos(hue), colourfulness * np.sin(hue)], axis=1)


def _compressed(response: NDArray[np.float64]) -> NDArray[np.float64]:
    """Responses of cones after compression, CIE 159:2004, equations 13 and 14; odd for negative ones."""
    power = (_LEVEL * np.abs(response) / 100.0) ** 0.42
    return np.copysign(400.0 * power / (27.13 + power), response) + 0.1

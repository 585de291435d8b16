"""What pictures take for white: the display's own white, or the light of the scene's lamps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.adaptation import adaptation_matrix
from hradiosity.metrics.colorimetric import SRGB_WHITE, xyz_weights
from hradiosity.model.lamps import lamp_flux
from hradiosity.model.scene import Scene

WhiteName = Literal["as-measured", "lamps"]
WHITES: Final[tuple[WhiteName, ...]] = ("as-measured", "lamps")
_AS_MEASURED: Final = "CIE 1931 XYZ to sRGB without adaptation to the light"


@dataclass(frozen=True)
class White:
    """How colours are shown.

    matrix : (3, 3) float64, from X, Y, Z as measured to those that are shown
    words : what it does, for the files
    """

    matrix: NDArray[np.float64]
    words: str

    def shown(self, xyz: NDArray[np.floating]) -> NDArray[np.float64]:
        """X, Y, Z (n, 3) as shown."""
        if np.array_equal(self.matrix, np.eye(3)):
            return xyz.astype(np.float64)
        adapted: NDArray[np.float64] = np.einsum("nc,rc->nr", xyz, self.matrix)
        return adapted


def as_measured() -> White:
    """Colours as a colorimeter finds them: warm light looks warm."""
    return White(np.eye(3), _AS_MEASURED)


def white_of(scene: Scene, name: WhiteName) -> White:
    """The white of a scene's pictures, see `white_of_light`; the light is that of all lamps together."""
    return white_of_light(lamp_light(scene) if name == "lamps" else np.zeros(3), name)


def white_of_light(light: NDArray[np.float64], name: WhiteName) -> White:
    """The white of pictures of a scene whose lamps send `light` (3,), X, Y, Z of any unit.

    With "lamps" the light of all lamps together, weighted with their flux, becomes the display's white (CIE D65);
    that of the sky in a scene without lamps. Where nothing shines colours stay as measured, and the words say so.
    """
    if name == "as-measured":
        return as_measured()
    if not light[1] > 0.0:
        return White(np.eye(3), f"{_AS_MEASURED}: nothing shines")
    x, y = SRGB_WHITE
    matrix = adaptation_matrix(light, np.array([x / y, 1.0, (1.0 - x - y) / y]))
    total = float(light.sum())
    place = f"x = {light[0] / total:.4f}, y = {light[1] / total:.4f}"
    return White(matrix, f"the lamps' mean light, {place}, is shown as the white of sRGB by CAT16, complete adaptation")


def lamp_light(scene: Scene) -> NDArray[np.float64]:
    """(3,) X, Y, Z of the flux of all lamps [lm], or of the sky's radiance [cd m⁻²] where there is none."""
    light: NDArray[np.float64] = np.einsum("b,bc->c", lamp_flux(scene), xyz_weights(scene.bands))
    return light

"""Images of a solution: ``gather_image`` computes the light of every pixel, with its noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.model.scene import View
from hradiosity.model.spectrum import Bands
from hradiosity.show.image_light import ImageLight, image_light
from hradiosity.show.image_pixels import SUMS, trace_pass
from hradiosity.solution import Solution
from hradiosity.space.bvh_build import build_bvh
from hradiosity.transport.device_scene import DeviceScene, upload_scene
from hradiosity.transport.glow import sampled_scene

PASSES: Final = 4
"""Independent estimates that an image is the mean of; their spread is its noise."""
SAMPLES: Final = 16
"""In each pixel, all passes together, unless another number is asked for."""
_XYZ_SHOWN = 1e-9


@dataclass(frozen=True)
class Image:
    """Light of the pixels of a view, rows from above, each the mean over the pixel's area.

    view : View
    xyz : (height, width, 3) float64, CIE 1931 X, Y, Z of the radiance; Y is the luminance [cd m⁻²]
    standard_error : (height, width, 3) float64, of `xyz`, from the spread of the passes
    dull, bright : (height, width, 3) float64, parts of `xyz`: by surfaces that do not shine; by lamps and sky
    shining : (height, width) float64, share of the pixel that lamps and sky take, or nothing at all
    surface : (height, width) float64, share of the pixel that surfaces take
    illuminance : (height, width) float64 [lx], of the surfaces seen; 0 where there are none
    illuminance_error : (height, width) float64 [lx], standard error of `illuminance`
    spectrum : (height, width, n_bands) float32, spectral radiance [W m⁻² sr⁻¹ nm⁻¹]; None unless asked for
    bands : Bands
    samples : in each pixel
    passes : independent estimates behind the standard errors
    """

    view: View
    xyz: NDArray[np.float64]
    standard_error: NDArray[np.float64]
    dull: NDArray[np.float64]
    bright: NDArray[np.float64]
    shining: NDArray[np.float64]
    surface: NDArray[np.float64]
    illuminance: NDArray[np.float64]
    illuminance_error: NDArray[np.float64]
    spectrum: NDArray[np.float32] | None
    bands: Bands
    samples: int
    passes: int

    @property
    def noise(self) -> NDArray[np.float64]:
        """(height, width) standard error of the luminance over the luminance; 0 where there is none."""
        luminance = self.xyz[..., 1]
        return np.divide(
            self.standard_error[..., 1], luminance, out=np.zeros_like(luminance), where=luminance > _XYZ_SHOWN
        )

    @property
    def noise_quantiles(self) -> tuple[float, float]:
        """Median and 95th percentile of `noise` over the pixels that have light; 0 where none has."""
        lit = self.noise[self.xyz[..., 1] > 0.0]
        median, high = np.quantile(lit, [0.5, 0.95]) if len(lit) else np.zeros(2)
        return float(median), float(high)


def gather_image(
    solution: Solution,
    device: Device,
    view: View,
    *,
    samples: int = SAMPLES,
    seed: int = 0,
    spectra: bool = False,
    on_device: DeviceScene | None = None,
) -> Image:
    """The image of one view, by final gather: nothing of it is interpolated or smoothed.

    Each sample is a point of a surface seen through the pixel. Direct light is computed there, one lamp by chance, as
    closed form and shadow ray; reflected light comes over two paths that look the solution up where readings do. All
    bands. The same arguments give the same bits.

    Parameters
    ----------
    solution : Solution
    device : Device
    view : View
    samples : int
        In each pixel, rounded up to the same number in each of four passes.
    seed : int
        Images of other seeds are independent.
    spectra : bool
        Keep the spectrum of each pixel.
    on_device : DeviceScene, optional
        The scene's ray structure, where it is at hand already.

    Raises
    ------
    ValueError
        When there is less than one sample.
    """
    scene = device_scene(solution, device) if on_device is None else on_device
    light = image_light(solution, scene, [view])
    growing = GrowingImage(light, view, solution.scene.bands, samples=samples, seed=seed, spectra=spectra)
    for _ in range(PASSES):
        growing.add_pass()
    return growing.image()


class GrowingImage:
    """An image pass by pass.

    Parameters
    ----------
    light : ImageLight
    view : View
    bands : Bands
    samples, seed, spectra
        As of `gather_image`.
    """

    def __init__(
        self, light: ImageLight, view: View, bands: Bands, *, samples: int, seed: int = 0, spectra: bool = False
    ) -> None:
        if samples < 1:
            raise ValueError(f"an image needs at least 1 sample a pixel, not {samples}")
        self.passes = 0
        self._light, self._view, self._bands, self._seed = light, view, bands, seed
        self._each = -(-samples // PASSES)
        n_pixels = view.width * view.height
        self._sums, self._squares = np.zeros((n_pixels, SUMS)), np.zeros((n_pixels, 4))
        self._spectrum = np.zeros((n_pixels, len(bands)), np.float32) if spectra else None

    @property
    def samples(self) -> int:
        """In each pixel so far."""
        return self._each * self.passes

    def add_pass(self) -> None:
        """Trace one more pass."""
        seed = (self._seed * 0x9E3779B1 + (self.passes + 1) * 0x85EBCA6B) & 0xFFFFFFFF
        found = trace_pass(self._light, self._view, self._each, seed, self._spectrum)
        self._sums += found
        self._squares += _measured(found) ** 2
        self.passes += 1

    def image(self) -> Image:
        """The mean of the passes so far.

        Raises
        ------
        RuntimeError
            Before the second pass: noise would be unknown.
        """
        if self.passes < 2:
            raise RuntimeError("an image needs two passes")
        shape, mean = (self._view.height, self._view.width), self._sums / self.passes
        measured, surface = _measured(mean), mean[:, 8]
        error = np.sqrt(np.maximum(self._squares / self.passes - measured**2, 0.0) / (self.passes - 1))
        lux, lux_error = (
            np.divide(values, surface, out=np.zeros_like(surface), where=surface > 0.0).reshape(shape)
            for values in (mean[:, 3], error[:, 3])
        )
        summed, per_nm = self._spectrum, (1.0 / (self.passes * self._bands.width)).astype(np.float32)
        return Image(
            view=self._view,
            xyz=measured[:, :3].reshape(*shape, 3),
            standard_error=error[:, :3].reshape(*shape, 3),
            dull=mean[:, :3].reshape(*shape, 3),
            bright=mean[:, 4:7].reshape(*shape, 3),
            shining=mean[:, 7].reshape(shape),
            surface=surface.reshape(shape),
            illuminance=lux,
            illuminance_error=lux_error,
            spectrum=None if summed is None else (summed * per_nm).reshape(*shape, -1),
            bands=self._bands,
            samples=self.samples,
            passes=self.passes,
        )


def device_scene(solution: Solution, device: Device) -> DeviceScene:
    """The ray structure of a solution's scene, with the emitters that shadow rays go to."""
    sampled = sampled_scene(solution.scene, solution.plan.weak_emitters)
    bvh = build_bvh(device, solution.scene.patches)
    return upload_scene(device, sampled, bvh, occlusion=solution.plan.occlusion)


def _measured(found: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 4) X, Y, Z of all light and the illuminance times the share of surfaces."""
    return np.column_stack([found[:, :3] + found[:, 4:7], found[:, 3]])

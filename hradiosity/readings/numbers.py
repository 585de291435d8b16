"""The numbers that are read off the spectra of a replicate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import chromaticity, xyz_weights
from hradiosity.metrics.derived import DerivedNumbers
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Sensor
from hradiosity.model.spectrum import Bands

POWERS = ("irradiance", "illuminance", "mean_illuminance")
"""Numbers that grow with the light, as those in lux do; a common factor cancels in all others."""
OF_SENSORS = ("mean_illuminance", "uniformity")
"""Numbers that each sensor has one of; the others belong to readings."""


class ReadingNumbers:
    """Numbers of the readings of some sensors, from spectra.

    Parameters
    ----------
    sensors : sequence of Sensor
    bands : Bands
    full : bool
        With R1 to R14, Rf and Rg.

    Attributes
    ----------
    parts : slices of all readings, by sensor name
    tilt : (n_bands,) float64, from −1 or more at one end of the bands to 1 or less at the other
    """

    def __init__(self, sensors: Sequence[Sensor], bands: Bands, *, full: bool = False) -> None:
        ends = np.cumsum([0, *(s.n_readings for s in sensors)])
        self.parts = {s.name: slice(int(ends[i]), int(ends[i + 1])) for i, s in enumerate(sensors)}
        self._luminous = luminous_weights(bands)
        self._xyz = xyz_weights(bands)
        self._derived = DerivedNumbers(bands, full=full)
        middle = bands.centre - 0.5 * (bands.centre[0] + bands.centre[-1])
        self.tilt = middle / max(float(np.abs(middle).max()), np.finfo(np.float64).tiny)

    def of(self, spectra: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        """All numbers by name.

        Parameters
        ----------
        spectra : (n, n_bands) float64 [W m⁻² per band]

        Returns
        -------
        dict
            ``irradiance`` (n, n_bands), ``illuminance`` (n,) [lx], ``chromaticity`` (n, 2) CIE 1931 x and y, NaN
            without light, ``mean_illuminance`` [lx] and ``uniformity`` (n_sensors,), and those of
            `hradiosity.metrics.derived`, (n,).
        """
        return {
            "irradiance": spectra,
            **self.illuminances(spectra),
            "chromaticity": chromaticity(np.einsum("xb,bc->xc", spectra, self._xyz)),
            **self._derived(spectra),
        }

    def illuminances(self, spectra: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        """Only ``illuminance``, ``mean_illuminance`` and ``uniformity``, which take next to no time."""
        lux = np.einsum("xb,b->x", spectra, self._luminous)
        sensors = np.array([_mean_and_uniformity(lux[part]) for part in self.parts.values()]).reshape(-1, 2)
        return {"illuminance": lux, "mean_illuminance": sensors[:, 0], "uniformity": sensors[:, 1]}

    def shares_of_mean(self, lux: NDArray[np.float64], mean: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) illuminance of each reading over the mean (n_sensors,) of its sensor; 0 where there is no light."""
        whole = np.repeat(mean, [part.stop - part.start for part in self.parts.values()])
        return np.divide(lux, whole, out=np.zeros_like(lux), where=whole > 0.0)

    def effect_of(
        self, spectra: NDArray[np.float64], numbers: Mapping[str, NDArray[np.float64]], relative: float
    ) -> dict[str, NDArray[np.float64]]:
        """How far each number may be off when every band may be off by a share `relative` of itself.

        Powers by that share. Of the others the change when the spectra are tilted, by that share at either end of the
        bands; uniformity by twice that share, since its lowest reading and its mean may be off in opposite directions,
        but that of a single reading is 1 whatever the light.
        """
        effect = {name: relative * np.abs(value) for name, value in numbers.items() if is_power(name)}
        several = np.array([part.stop - part.start > 1 for part in self.parts.values()], bool)
        effect["uniformity"] = 2.0 * relative * numbers["uniformity"] * several
        others = numbers.keys() - effect.keys()
        if others:
            tilted = self.of(spectra * (1.0 + relative * self.tilt))
            effect |= {name: np.abs(tilted[name] - numbers[name]) for name in others}
        return effect


def is_power(name: str) -> bool:
    """Whether a number grows with the light."""
    return name in POWERS or name.endswith("_lx")


def _mean_and_uniformity(lux: NDArray[np.float64]) -> tuple[float, float]:
    """Mean illuminance [lx], and the lowest over it; 0 where there is no light."""
    mean = float(lux.mean())
    return mean, float(lux.min()) / mean if mean > 0.0 else 0.0

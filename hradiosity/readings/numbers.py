"""The numbers that are read off the spectra of a replicate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import chromaticity, xyz_weights
from hradiosity.metrics.derived import DerivedNumbers
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.metrics.uniformity import even_light
from hradiosity.metrics.weights import band_weights
from hradiosity.model.scene import Action, Sensor
from hradiosity.model.spectrum import Bands

POWERS = ("irradiance", "illuminance", "mean_illuminance", "lowest_illuminance", "highest_illuminance")
"""Numbers that grow with the light, as those in lux or W m⁻² do; a common factor cancels in all others."""
RATIOS = ("uniformity", "diversity")
"""Of two readings of a sensor, or of one and the mean."""
OF_SENSORS = ("mean_illuminance", "lowest_illuminance", "highest_illuminance", *RATIOS)
"""Numbers that each sensor has one of; the others belong to readings."""
_POWER_UNITS = ("_lx", "_w_m2")
_LEVELS = ("mean", "lowest", "highest")


class ReadingNumbers:
    """Numbers of the readings of some sensors, from spectra.

    Parameters
    ----------
    sensors : sequence of Sensor
    bands : Bands
    full : bool
        With R1 to R14, Rf and Rg.
    actions : sequence of Action
        Further action spectra that light is weighted by.
    illuminance_only : bool
        Without colour and everything else that takes time.

    Attributes
    ----------
    parts : slices of all readings, by sensor name
    tilt : (n_bands,) float64, from −1 or more at one end of the bands to 1 or less at the other
    """

    def __init__(
        self,
        sensors: Sequence[Sensor],
        bands: Bands,
        *,
        full: bool = False,
        actions: Sequence[Action] = (),
        illuminance_only: bool = False,
    ) -> None:
        ends = np.cumsum([0, *(s.n_readings for s in sensors)])
        self.parts = {s.name: slice(int(ends[i]), int(ends[i + 1])) for i, s in enumerate(sensors)}
        self._luminous = luminous_weights(bands)
        self._xyz = xyz_weights(bands)
        self._derived = None if illuminance_only else DerivedNumbers(bands, full=full)
        self._actions = {f"{action.name}_w_m2": band_weights(action.spectrum, bands) for action in actions}
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
            without light, those of `illuminances`, those of `hradiosity.metrics.derived`, (n,), and ``NAME_w_m2``
            (n,) for each action spectrum.
        """
        if self._derived is None:
            return {"irradiance": spectra, **self.illuminances(spectra)}
        return {
            "irradiance": spectra,
            **self.illuminances(spectra),
            "chromaticity": chromaticity(np.einsum("xb,bc->xc", spectra, self._xyz)),
            **self._derived(spectra),
            **{name: np.einsum("xb,b->x", spectra, weight) for name, weight in self._actions.items()},
        }

    def illuminances(self, spectra: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        """Only those of the illuminance, which take next to no time: its own, and of each sensor (n_sensors,) its mean,
        lowest and highest one, ``uniformity`` U₀, lowest over mean, and ``diversity`` U_d, lowest over highest.
        """
        lux = np.einsum("xb,b->x", spectra, self._luminous)
        found = [even_light(lux[part]) for part in self.parts.values()]
        return {
            "illuminance": lux,
            **{f"{name}_illuminance": np.array([getattr(light, name) for light in found]) for name in _LEVELS},
            **{name: np.array([getattr(light, name) for light in found]) for name in RATIOS},
        }

    def shares_of_mean(self, lux: NDArray[np.float64], mean: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) illuminance of each reading over the mean (n_sensors,) of its sensor; 0 where there is no light."""
        whole = np.repeat(mean, [part.stop - part.start for part in self.parts.values()])
        return np.divide(lux, whole, out=np.zeros_like(lux), where=whole > 0.0)

    def effect_of(
        self, spectra: NDArray[np.float64], numbers: Mapping[str, NDArray[np.float64]], relative: float
    ) -> dict[str, NDArray[np.float64]]:
        """How far each number may be off when every band may be off by a share `relative` of itself.

        Powers by that share. Of the others the change when the spectra are tilted, by that share at either end of the
        bands; uniformity and diversity by twice that share, since their readings and the mean may be off in opposite
        directions, but those of a single reading are 1 whatever the light.
        """
        effect = {name: relative * np.abs(value) for name, value in numbers.items() if is_power(name)}
        several = np.array([part.stop - part.start > 1 for part in self.parts.values()], bool)
        effect |= {name: 2.0 * relative * numbers[name] * several for name in RATIOS}
        others = numbers.keys() - effect.keys()
        if others:
            tilted = self.of(spectra * (1.0 + relative * self.tilt))
            effect |= {name: np.abs(tilted[name] - numbers[name]) for name in others}
        return effect


def is_power(name: str) -> bool:
    """Whether a number grows with the light."""
    return name in POWERS or name.endswith(_POWER_UNITS)

"""What the replicates say of the readings: spectra and the numbers derived from them, each with its own interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import chromaticity, xyz_weights
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Sensor
from hradiosity.model.spectrum import Bands
from hradiosity.readings.interval import RunningMoments
from hradiosity.solution import Readings


class ReadingMoments:
    """Running means and spreads of all readings of some sensors.

    Parameters
    ----------
    sensors : sequence of Sensor
    bands : Bands

    Attributes
    ----------
    position, normal : (n, 3) float64, of all sensors, one after another
    """

    def __init__(self, sensors: Sequence[Sensor], bands: Bands) -> None:
        self.position = np.concatenate([np.zeros((0, 3)), *(s.position for s in sensors)])
        self.normal = np.concatenate([np.zeros((0, 3)), *(s.normal for s in sensors)])
        ends = np.cumsum([0, *(len(s.position) for s in sensors)])
        self._parts = {s.name: slice(int(ends[i]), int(ends[i + 1])) for i, s in enumerate(sensors)}
        self._luminous = luminous_weights(bands)
        self._xyz = xyz_weights(bands)
        n = len(self.position)
        self._moments = {
            "spectra": RunningMoments((n, len(bands))),
            "lux": RunningMoments((n,)),
            "chromaticity": RunningMoments((n, 2)),
            "sensors": RunningMoments((len(sensors), 2)),
            "enclosed": RunningMoments((n,)),
        }

    @property
    def count(self) -> int:
        """Number of replicates."""
        return self._moments["spectra"].count

    def add(self, spectra: NDArray[np.float64], enclosed: NDArray[np.float64]) -> None:
        """Take one more replicate into account.

        Parameters
        ----------
        spectra : (n, n_bands) float64 [W m⁻² per band]
        enclosed : (n,) float64
        """
        lux = np.einsum("xb,b->x", spectra, self._luminous)
        self._moments["spectra"].add(spectra)
        self._moments["lux"].add(lux)
        self._moments["chromaticity"].add(chromaticity(np.einsum("xb,bc->xc", spectra, self._xyz)))
        summary = np.array([_mean_and_uniformity(lux[part]) for part in self._parts.values()]).reshape(-1, 2)
        self._moments["sensors"].add(summary)
        self._moments["enclosed"].add(enclosed)

    def readings(self) -> dict[str, Readings]:
        """Means so far and half widths of their 95 % intervals, by sensor name."""
        width = {key: moments.half_width() for key, moments in self._moments.items()}
        return {name: self._readings(index, name, width) for index, name in enumerate(self._parts)}

    def errors(self) -> NDArray[np.float64]:
        """(n,) accuracy of every reading, see `Readings.accuracy`; empty before two replicates."""
        if self.count < 2:
            return np.zeros(0)
        return np.concatenate([np.zeros(0), *(r.accuracy for r in self.readings().values())])

    def checkpoint(self) -> dict[str, NDArray[np.float64]]:
        """Everything that `restore` needs."""
        return {
            f"{name}/{key}": array for name, kept in self._moments.items() for key, array in kept.checkpoint().items()
        }

    def restore(self, kept: Mapping[str, NDArray[np.float64]]) -> None:
        """Go on from a checkpoint, bit for bit.

        Raises
        ------
        ValueError
            When it is of other sensors or bands.
        """
        for name, moments in self._moments.items():
            moments.restore({key: kept[f"{name}/{key}"] for key in ("count", "mean", "squares")})

    def _readings(self, index: int, name: str, width: Mapping[str, NDArray[np.float64]]) -> Readings:
        part = self._parts[name]
        moments = self._moments
        spectra = moments["spectra"].mean[part]
        return Readings(
            sensor=name,
            position=self.position[part],
            normal=self.normal[part],
            irradiance=spectra,
            half_width=width["spectra"][part],
            illuminance=moments["lux"].mean[part],
            illuminance_half_width=width["lux"][part],
            mean_illuminance=float(moments["sensors"].mean[index, 0]),
            mean_illuminance_half_width=float(width["sensors"][index, 0]),
            uniformity_half_width=float(width["sensors"][index, 1]),
            chromaticity=chromaticity(np.einsum("xb,bc->xc", spectra, self._xyz)),
            chromaticity_half_width=width["chromaticity"][part],
            enclosed=moments["enclosed"].mean[part],
        )


def _mean_and_uniformity(lux: NDArray[np.float64]) -> tuple[float, float]:
    """Mean illuminance [lx], and the lowest over it; 0 where there is no light."""
    mean = float(lux.mean())
    return mean, float(lux.min()) / mean if mean > 0.0 else 0.0

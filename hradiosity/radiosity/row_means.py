"""The light on the row elements, mean over the replicates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.plan import SpectralColumns
from hradiosity.readings.interval import RunningMean, part_of
from hradiosity.solution import Surfaces
from hradiosity.solvers.result import Progress


class RowMeans:
    """Running means over replicates; light counts by the exposed share of its row.

    A row that the rays of one replicate found wholly covered has no light there, which says nothing about the rest.

    Parameters
    ----------
    n_rows, n_columns : int
    """

    def __init__(self, n_rows: int, n_columns: int) -> None:
        self._indirect = RunningMean((n_rows, n_columns))
        self._direct = RunningMean((n_rows, n_columns))
        self._exposed = RunningMean((n_rows,))

    @property
    def count(self) -> int:
        """Replicates so far."""
        return self._exposed.count

    @property
    def exposed(self) -> NDArray[np.float64]:
        """(n_rows,) share of each row that is not covered."""
        return self._exposed.mean

    @property
    def indirect(self) -> NDArray[np.float64]:
        """(n_rows, n_columns) irradiance by way of other surfaces; 0 where a row was never exposed."""
        return self._over_exposed(self._indirect)

    @property
    def direct(self) -> NDArray[np.float64]:
        """(n_rows, n_columns) irradiance straight from lamps and sky."""
        return self._over_exposed(self._direct)

    def add(
        self, irradiance: NDArray[np.floating], direct: NDArray[np.floating], exposed: NDArray[np.floating]
    ) -> None:
        """Take a replicate into account: (n_rows, n_columns) light, all of it and the direct part; (n_rows,) share."""
        share = exposed[:, None]
        self._indirect.add(share * (irradiance - direct))
        self._direct.add(share * direct)
        self._exposed.add(exposed)

    def surfaces(self, columns: SpectralColumns, space: NDArray[np.int32]) -> Surfaces:
        """What they say in bands; (n_rows,) space that each row looks into."""
        direct = self.direct
        return Surfaces(
            irradiance=columns.to_bands(self.indirect + direct),
            direct=columns.to_bands(direct),
            space=space,
            exposed=self.exposed,
        )

    def surfaces_with(self, progress: Progress, columns: SpectralColumns, space: NDArray[np.int32]) -> Surfaces:
        """As `surfaces`, with what the solver of a further replicate has so far; without the direct part."""
        now, before = columns.to_bands(progress.irradiance()), columns.to_bands(self.indirect + self.direct)
        mean = (self.count * before + now) / (self.count + 1)
        exposed = self.exposed if self.count else np.ones(len(space))
        return Surfaces(irradiance=mean, direct=np.zeros_like(mean), space=space, exposed=exposed)

    def checkpoint(self) -> dict[str, NDArray[Any]]:
        """Everything that `restore` needs."""
        return {
            f"{name}/{key}": array for name, kept in self._all().items() for key, array in kept.checkpoint().items()
        }

    def restore(self, kept: Mapping[str, NDArray[Any]]) -> None:
        """Go on from a checkpoint, bit for bit."""
        for name, mean in self._all().items():
            mean.restore(part_of(kept, name))

    def _all(self) -> dict[str, RunningMean]:
        return {"indirect": self._indirect, "direct": self._direct, "exposed": self._exposed}

    def _over_exposed(self, light: RunningMean) -> NDArray[np.float64]:
        share = self._exposed.mean[:, None]
        mean: NDArray[np.float64] = np.divide(light.mean, share, out=np.zeros_like(light.mean), where=share > 0.0)
        return mean

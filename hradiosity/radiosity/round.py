"""The replicates of one size: their elements, and the light on them, which is kept or computed again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from numpy.typing import NDArray

from hradiosity.planning_memory import KEPT_LIGHT_BYTES
from hradiosity.radiosity.point_reader import ReplicateLight
from hradiosity.radiosity.record import Record
from hradiosity.radiosity.seeds import replicate_seed
from hradiosity.radiosity.surfaces import SurfaceSolver
from hradiosity.readings.reflected import MeanLight, mean_light

TOO_FEW: Final = "further points need the light of two replicates or more, computed by this process"


class Round:
    """Replicates with elements, rays and samples of one size.

    Parameters
    ----------
    make : callable
        Elements of that size, without light; their account goes into the record.
    record : Record
    seed : int
        Of the run.

    Attributes
    ----------
    surfaces : SurfaceSolver
    kept : light of the first replicates
    """

    def __init__(self, make: Callable[[Record], SurfaceSolver], record: Record, seed: int) -> None:
        self.surfaces = make(record)
        self.kept: list[ReplicateLight] = []
        self._make, self._seed = make, seed
        self._again: SurfaceSolver | None = None
        self._mean: MeanLight | None = None

    @property
    def count(self) -> int:
        """Replicates so far."""
        return self.surfaces.iteration.means.count

    def light(self, number: int) -> ReplicateLight:
        """What readings of a replicate are taken from: of an earlier one, or of the next."""
        if number < len(self.kept):
            return self.kept[number]
        surfaces = self.surfaces if self.count == number else self._repeated(number)
        seed = replicate_seed(self._seed, number)
        light = surfaces.replicate(seed)
        on = ReplicateLight(surfaces.on_device, surfaces.on_device_elements, light, surfaces.plan, seed)
        if number == len(self.kept) and (number < 2 or (number + 1) * light.nbytes <= KEPT_LIGHT_BYTES):
            self.kept.append(on)
        return on

    def mean_light(self) -> tuple[ReplicateLight, MeanLight]:
        """The last replicate that is kept, and the mean light of those that are on the same elements.

        Raises
        ------
        RuntimeError
            Before two of them are kept.
        """
        alike = [on for on in self.kept if on.elements is self.kept[-1].elements]
        if len(alike) < 2:
            raise RuntimeError(TOO_FEW)
        if self._mean is None or self._mean.replicates != len(alike):
            self._mean = mean_light(alike[-1].scene.device, [on.light for on in alike])
        return alike[-1], self._mean

    def restore(self, kept: Mapping[str, NDArray[Any]]) -> None:
        """Go on from a checkpoint of the surfaces; light of replicates that it does not know of is dropped."""
        self.surfaces.restore(kept)
        self.kept = self.kept[: self.count]

    def _repeated(self, number: int) -> SurfaceSolver:
        """The surfaces as they were before a replicate, computed from the start: the same bits."""
        if self._again is None or self._again.iteration.means.count > number:
            self._again = self._make(Record())
        while self._again.iteration.means.count < number:
            self._again.replicate(replicate_seed(self._seed, self._again.iteration.means.count))
        return self._again

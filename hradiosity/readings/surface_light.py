"""The solution of a replicate as paths look it up."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.device import DeviceArray
from hradiosity.estimate import MESH
from hradiosity.plan import SpectralColumns


@dataclass(frozen=True)
class SurfaceLight:
    """The solution as paths look it up.

    reflectance : (n_paints, 8 n_groups) float32 on the device, see `hradiosity.transport.glow.Glow`
    glow : (n_paints, 8 n_groups) float32 on the device, exitance of paints that shine; None if none does
    emission : (n_emitters, 8 n_groups) float32, exitance or intensity of each emitter; and the same on the device
    reflected : (n_rows, 8 n_groups) float32 on the device, ρE of each row element, and its glow
    row_size : (n_rows,) float32 on the device, edge of each element [m]; infinite for those that were found wholly
        covered and thus have no light to look up, below 0 where it may be looked up at a first hit that is near
    sky : (8 n_groups,) float32 on the device, π · radiance
    emitter_choice : (n_rows, n_emitters) float32 on the device, summed probability of drawing an emitter,
        see `hradiosity.transport.lamp_choice.drawn_at_hits`
    row_direct : (n_rows, n_emitters) float32 on the device, direct light of each element for unit emission
    weight : (8 n_groups,) float32 on the device, brightness of a unit of each column
    row_space : (n_rows,) int32, connected space that each element looks into
    change : (n_rows, 8 n_groups) float32 on the device, what a companion with coarser settings would add to
        `reflected`; None where there is none
    changed_by : part of the intervals that the change tells about, "mesh" or "exchange"
    spots : (n_spots, 3) float64, middles of places that pass much of the light, in the ray structure's frame [m]
    """

    columns: SpectralColumns
    reflectance: DeviceArray
    glow: DeviceArray | None
    emission: NDArray[np.float32]
    emission_on_device: DeviceArray
    reflected: DeviceArray
    row_size: DeviceArray
    sky: DeviceArray
    emitter_choice: DeviceArray
    row_direct: DeviceArray
    weight: DeviceArray
    row_space: NDArray[np.int32]
    change: DeviceArray | None = None
    changed_by: str = MESH
    spots: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))

    @property
    def nbytes(self) -> int:
        """Bytes on the device that no other replicate shares."""
        own = (self.reflected, self.row_size, self.emitter_choice, self.row_direct, self.change)
        return sum(int(array.nbytes) for array in own if array is not None)

"""Open share of the exchange between row elements, by rays between them."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.space.hierarchy import COVERED
from hradiosity.transport.cell_pairs import RowPairs
from hradiosity.transport.device_scene import DeviceElements, DeviceScene
from hradiosity.transport.exchange import RowHits

LEAST_SAMPLES: Final = 4
MOST_SAMPLES: Final = 64
BATCH_PAIRS: Final = 2**21
"""Pairs on the device at a time."""


def open_share(
    scene: DeviceScene,
    elements: DeviceElements,
    hits: RowHits,
    pairs: RowPairs,
    seed: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """What stands between leaves of the exchange of pairs, what solids cover taken off; its standard error; and rays.

    Exactly 1 where nothing stands between and neither element has a covered point. Elsewhere Σ w v / Σ w over random
    pairs of the points where the exchange rays start, w = cos cos / r⁴ (a ratio estimator: what is common to both sums
    falls out of its error). Pairs take samples in proportion to their form factors.

    Parameters
    ----------
    hits : RowHits
        Of the same seed: its rays tell which points solids cover.
    """
    share, error = np.ones(len(pairs.first)), np.zeros(len(pairs.first))
    covered = (hits.row == COVERED).any(axis=1)
    in_doubt = ~pairs.proved if scene.occlusion else np.zeros(len(share), bool)
    sampled = np.flatnonzero(in_doubt | covered[pairs.first] | covered[pairs.second])
    n_rays = hits.row.shape[1]
    samples = _samples(elements, pairs, sampled, n_rays)
    device = scene.device
    kernel = device.kernel("row_pairs", "sample_row_pairs")
    for low in range(0, len(sampled), BATCH_PAIRS):
        part = sampled[low : low + BATCH_PAIRS]
        sums = device.empty((len(part), 4), np.float32)
        kernel(
            len(part),
            **scene.geometry,
            **elements.cells,
            hit_row=hits.on_device,
            pair_first=device.upload(pairs.first[part], np.uint32),
            pair_second=device.upload(pairs.second[part], np.uint32),
            pair_samples=device.upload(samples[low : low + BATCH_PAIRS], np.uint32),
            sums=sums,
            n_rays=n_rays,
            occlusion=int(scene.occlusion),
            seed=seed,
            scale=scene.scale,
        )
        share[part], error[part] = _ratio(device.fetch(sums).astype(np.float64), samples[low : low + BATCH_PAIRS])
    return share, error, int(samples.sum())


def _samples(elements: DeviceElements, pairs: RowPairs, sampled: NDArray[np.int64], n_rays: int) -> NDArray[np.int64]:
    """Samples of each pair: as many as rays of both elements would meet the other, within bounds."""
    area = elements.elements.area
    factors = pairs.exchange[sampled] * (1.0 / area[pairs.first[sampled]] + 1.0 / area[pairs.second[sampled]])
    return np.clip(np.ceil(n_rays * factors), LEAST_SAMPLES, MOST_SAMPLES).astype(np.int64)


def _ratio(sums: NDArray[np.float64], samples: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Σ w v / Σ w and its standard error; nothing is seen where all points lay behind a horizon."""
    weight, seen, square, seen_square = sums.T
    share = np.divide(seen, weight, out=np.zeros_like(weight), where=weight > 0.0)
    rest = seen_square * (1.0 - 2.0 * share) + share**2 * square
    spread = np.sqrt(np.maximum(rest, 0.0) * samples / (samples - 1))
    return share, np.divide(spread, weight, out=np.ones_like(weight), where=weight > 0.0)

"""Runs of the cost suite with known readings, for its tests."""

import numpy as np

from hradiosity.estimate import Estimate, student_quantile
from hradiosity.solution import Readings
from hradiosity.suites.cost.values import Run

N, BANDS = 40, 3


def known(value, spread=0.0):
    """An estimate whose half width at 95 % is `spread` over value."""
    value = np.asarray(value, float)
    return Estimate(value, spread * value / student_quantile(0.95, 3), 3)


def readings_of(lux, spread=0.0, count=4):
    """One sensor whose illuminance, and whose bands alike, are `lux`; half widths `spread` over value."""
    lux = np.asarray(lux, float)
    spectra = np.repeat(lux[:, None], BANDS, axis=1)
    place = np.zeros((len(lux), 3))
    return {
        "desk": Readings(
            sensor="desk",
            position=place,
            normal=place,
            enclosed=np.zeros(len(lux)),
            numbers={
                "irradiance": known(spectra, spread),
                "illuminance": known(lux, spread),
                "mean_illuminance": known(lux.mean()),
                "uniformity": known(lux.min() / max(lux.mean(), 1e-9)),
                "chromaticity": known(np.full((len(lux), 2), 1 / 3)),
                "cct_k": known(np.where(lux > 0, 4000.0 + lux, np.nan)),
                "ra": known(np.where(lux > 0, 80.0 + lux, np.nan)),
                "melanopic_edi_lx": known(0.5 * lux),
            },
        )
    }


def run_of(setting, lux, seconds, *, seed=0, spread=0.0, elements=1000):
    return Run(
        setting=setting,
        seed=seed,
        elements=elements,
        replicates=4,
        cpu_seconds=seconds,
        busy_seconds=seconds,
        wall_seconds=seconds,
        memory_bytes=2**20,
        stage_seconds={"geometry": 0.0, "readings": seconds},
        work={"readings": 1.0},
        readings=readings_of(lux, spread),
        convergence={},
    )

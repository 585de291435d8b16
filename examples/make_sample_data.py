"""Make ``hradiosity/metrics/samples/tables.npz`` from colour-science (BSD-3-Clause).

Only needed when a table is added: ``python examples/make_sample_data.py``, from the root of the checkout.
"""

from pathlib import Path

import colour
import numpy as np
from colour.colorimetry.datasets.illuminants import SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES
from colour.quality.cfi2017 import load_TCS_CIE2017
from colour.quality.datasets import SDS_TCS
from numpy.typing import NDArray

TARGET = Path(__file__).resolve().parents[1] / "hradiosity" / "metrics" / "samples" / "tables.npz"


def tables() -> dict[str, NDArray[np.float64] | NDArray[np.float32]]:
    """Every table by name, wavelengths in nm; reflectances in single precision, which keeps their digits."""
    rendering = [SDS_TCS["CIE 1995"][f"TCS{number:02d}"] for number in range(1, 15)]
    fidelity = load_TCS_CIE2017(colour.SpectralShape(380, 780, 1))
    daylight = [SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES[name] for name in ("S0", "S1", "S2")]
    return {
        "cie13.3/wavelength": rendering[0].wavelengths,
        "cie13.3/reflectance": np.stack([sample.values for sample in rendering], axis=1),
        "cie224/wavelength": fidelity.wavelengths,
        "cie224/reflectance": fidelity.values.astype(np.float32),
        "daylight/wavelength": daylight[0].wavelengths,
        "daylight/power": np.stack([component.values for component in daylight], axis=1),
    }


if __name__ == "__main__":
    made = tables()
    np.savez_compressed(TARGET, **made)
    print(f"{len(made)} tables, {TARGET.stat().st_size} bytes")

"""Make ``hradiosity/model/photometry/tables.npz`` from colour-science (BSD-3-Clause), published formulas and the CIE.

Only needed when a table is added: ``python examples/make_photometry_data.py CIE_illum_FLs_1nm.csv``, from the root of
the checkout. The file is the fluorescent lamps of CIE 015:2018 every 1 nm (doi 10.25039/CIE.DS.54hy6srn, CC BY-SA 4.0),
which the CIE lets one download.
"""

import sys
from pathlib import Path

import colour
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from hradiosity.io.spectra import read_spectrum_csv

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "hradiosity" / "model" / "photometry" / "tables.npz"
WAVELENGTH = np.arange(360.0, 831.0)

FLUORESCENT = (*(f"FL{i}" for i in range(1, 13)), *(f"FL3.{i}" for i in range(1, 16)))
"""Columns of the CIE's file with values every 1 nm, after the wavelength."""

FLUORESCENT_SUMS = {"FL1": 3416.3131, "FL2": 2968.9113, "FL11": 2968.3194, "FL3.15": 144499.6924}
"""Sums of some columns as the file's metadata state them."""

ILLUMINANTS = (
    *("C", "D50", "D55", "D65", "D75", "ID50", "ID65"),
    *FLUORESCENT,
    *(f"HP{i}" for i in range(1, 6)),
    *(f"LED-{kind}" for kind in ("B1", "B2", "B3", "B4", "B5", "BH1", "RGB1", "V1", "V2")),
)

OCULAR_DENSITY = np.array(
    [
        *(2.4971, 1.9971, 1.4971, 0.9901, 0.6301, 0.4741, 0.3741, 0.3171, 0.2741, 0.2331),
        *(0.2041, 0.1841, 0.1641, 0.1441, 0.1301, 0.1171, 0.1041, 0.0901, 0.0771, 0.0661),
        *(0.0571, 0.0481, 0.0411, 0.0351, 0.0291, 0.0251, 0.0211, 0.0181, 0.0151, 0.0121),
        *(0.0101, 0.0081, 0.0068, 0.0055, 0.0043, 0.0033, 0.0024, 0.0016, 0.0011, 0.0005),
        0.0,
    ]
)
"""Decadic optical density before the retina of the 32 years old observer of CIE S 026:2018, every 10 nm from 380 nm,
less its value at 780 nm (the action spectrum is normalised afterwards). It is what the standard's melanopic column
leaves when `pigment` and the wavelength are divided out."""


def tabulated(wavelength: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values at `WAVELENGTH`, 0 outside the table."""
    return np.interp(WAVELENGTH, wavelength, np.nan_to_num(values), left=0.0, right=0.0)


def pigment(wavelength: NDArray[np.float64], peak: float) -> NDArray[np.float64]:
    """Absorbance of a vitamin A1 pigment: Govardovskii et al. 2000, Vis. Neurosci. 17, 509, equations 1, 2, 4, 5."""
    x = peak / wavelength
    a = 0.8795 + 0.0459 * np.exp(-((peak - 300) ** 2) / 11940)
    alpha = 1 / (np.exp(69.7 * (a - x)) + np.exp(28 * (0.922 - x)) + np.exp(-14.9 * (1.104 - x)) + 0.674)
    beta = 0.26 * np.exp(-(((wavelength - (189 + 0.315 * peak)) / (-40.5 + 0.195 * peak)) ** 2))
    return alpha + beta


def melanopic() -> NDArray[np.float64]:
    """Melanopic action spectrum: a pigment with its peak at 480 nm behind the media of the eye, per unit of energy.

    Computed every 5 nm, as the standard does, and joined by monotone cubics.
    """
    nodes = np.arange(380.0, 781.0, 5.0)
    density = np.interp(nodes, np.arange(380.0, 781.0, 10.0), OCULAR_DENSITY)
    action = pigment(nodes, 480.0) * 10.0**-density * nodes
    inside = (WAVELENGTH >= 380) & (WAVELENGTH <= 780)
    joined = PchipInterpolator(nodes, action / action.max())(np.clip(WAVELENGTH, 380, 780))
    return np.where(inside, joined, 0.0)


def alpha_opic() -> NDArray[np.float64]:
    """Action spectra of CIE S 026: cones are the 10° fundamentals of CIE 170-1, rods are V'(λ) of CIE 1951."""
    cones = colour.MSDS_CMFS["Stockman & Sharpe 10 Degree Cone Fundamentals"]
    rods = colour.SDS_LEFS["CIE 1951 Scotopic Standard Observer"]
    long, medium, short = (tabulated(cones.wavelengths, cones.values[:, i]) for i in range(3))
    return np.stack([short, medium, long, tabulated(rods.wavelengths, rods.values), melanopic()], axis=1)


def illuminant(name: str) -> NDArray[np.float64]:
    """(2, m) wavelength and relative power; lamps are brought to 1 nm by Sprague's method, as CIE 167:2005 asks.

    Daylight keeps its 5 nm: CIE 15:2018 defines it as linear in between.
    """
    table = colour.SDS_ILLUMINANTS[name].copy()
    if name.startswith(("FL", "HP", "LED")):
        table.interpolate(colour.SpectralShape(380, 780, 1), interpolator=colour.SpragueInterpolator)
    return np.stack([table.wavelengths, np.maximum(np.round(table.values, 6), 0.0)])


def fluorescent_every_nm(path: Path) -> dict[str, NDArray[np.float64]]:
    """(2, 401) wavelength and relative power of the CIE's fluorescent lamps, with their lines where they are."""
    rows = [line.split(",") for line in path.read_text(encoding="utf-8-sig").splitlines()]
    values = np.array([[float(cell) for cell in row] for row in rows if len(row) == 28 and row[0].strip().isdigit()])
    if values.shape != (401, 28):
        raise ValueError(f"{path} has {values.shape} numbers, not 401 rows of 28")
    lamps = dict(zip(FLUORESCENT, values.T[1:], strict=True))
    for name, total in FLUORESCENT_SUMS.items():
        if abs(lamps[name].sum() / total - 1.0) > 1e-6:
            raise ValueError(f"the values of {name} add up to {lamps[name].sum()}, not to {total}")
    return {name: np.stack([values[:, 0], np.round(column, 4)]) for name, column in lamps.items()}


def tables(fluorescent: Path) -> dict[str, NDArray[np.float64]]:
    """Every table by name; spectra are (2, m) rows of wavelength and value."""
    found = {"wavelength": WAVELENGTH, "alpha_opic": alpha_opic()}
    efficiency = colour.SDS_LEFS["CIE 1924 Photopic Standard Observer"]
    found["luminous_efficiency"] = tabulated(efficiency.wavelengths, efficiency.values)
    found["observer/1931"] = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].values
    found["observer/1964"] = colour.MSDS_CMFS["CIE 1964 10 Degree Standard Observer"].values
    illuminant_a = colour.sd_CIE_standard_illuminant_A(colour.SpectralShape(300, 830, 1))
    found["illuminant/A"] = np.stack([illuminant_a.wavelengths, illuminant_a.values])
    found["illuminant/E"] = np.array([[300.0, 830.0], [100.0, 100.0]])
    for name in ILLUMINANTS:
        found[f"illuminant/{name}"] = illuminant(name)
    for name, lamp in fluorescent_every_nm(fluorescent).items():
        found[f"fine/{name}"] = lamp
    for name, table in colour.SDS_COLOURCHECKERS["ISO 17321-1"].items():
        found[f"colorchecker/{name.split(' (')[0]}"] = np.stack([table.wavelengths, table.values])
    for name in ("white", "red", "green"):
        wall = read_spectrum_csv(ROOT / "scenes" / "cornell_box" / "spectra" / f"{name}.csv")
        found[f"cornell/{name}"] = np.stack([wall.wavelength, wall.value])
    return found


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("say where the CIE's fluorescent lamps are: make_photometry_data.py CIE_illum_FLs_1nm.csv")
    made = tables(Path(sys.argv[1]))
    np.savez_compressed(TARGET, **made)
    print(f"{len(made)} tables, {TARGET.stat().st_size} bytes")

"""Numbers of colour and the eye beside those of other programs, and how long many spectra take.

``python -m hradiosity.suites.colour_table``; other bands by ``--first 380 --last 780 --step 1``. The values are
in ``data/colour.json``, with the tolerances that bars are made of. Where a value is outside, the line says so.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import chromaticity, xyz
from hradiosity.metrics.derived import DerivedNumbers
from hradiosity.metrics.eye import RECEPTORS, daylight_efficacy_ratio
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands, band_integral
from hradiosity.suites.validation.data import colour_values

_IN_FILE: Final = ("l-cone-opic", "m-cone-opic", "s-cone-opic", "rhodopic", "melanopic")
_COLUMNS: Final = ("XYZ", "xy", "CCT K", "Duv", "Ra", "Rf", "Rg", "DER")
MANY: Final = 10_000


@dataclass(frozen=True)
class Line:
    """Of one light: largest deviation by column, and the columns whose tolerance it exceeds.

    Where two programs have a number, the deviation is that from the nearer one: they differ by up to the tolerance.
    """

    light: str
    deviation: Mapping[str, float]
    outside: tuple[str, ...]


def table(bands: Bands) -> list[Line]:
    """A line an illuminant and black body of the file."""
    values = colour_values()
    numbers, tolerance = DerivedNumbers(bands, full=True), _tolerances(values["tolerances"])
    lines = []
    for light, power, references in _lights(values, bands):
        found = {name: float(value[0]) for name, value in numbers(power).items()}
        deviations: dict[str, float] = {}
        for given in references:
            one: dict[str, float] = {}
            for column, value in _deviations(given, found, power, bands):
                one[column] = max(one.get(column, 0.0), value)
            deviations = {c: min(one.get(c, math.inf), deviations.get(c, math.inf)) for c in {**deviations, **one}}
        lines.append(Line(light, deviations, tuple(c for c, d in deviations.items() if d > tolerance[c])))
    return lines


def _lights(values: Mapping[str, Any], bands: Bands) -> Iterator[tuple[str, NDArray[np.float64], list[Any]]]:
    """Names, (1, n_bands) powers, and what each of the other programs says of the light."""
    for name, given in values["illuminants"].items():
        yield name, band_integral(photometry.illuminant(name, bands), bands, "hold").value[None], list(given.values())
    for name, given in values["analytic_spectra"].items():
        if name.startswith("Planck"):
            spectrum = photometry.blackbody(float(name.removeprefix("Planck")))
            yield name, band_integral(spectrum, bands, "hold").value[None], [given]


def _tolerances(given: Mapping[str, float]) -> dict[str, float]:
    keys = ("XYZ_rel", "xy_abs", "CCT_K", "Duv_abs", "Ra_abs", "Rf_abs", "Rg_abs", "DER_rel")
    return {column: given[key] for column, key in zip(_COLUMNS, keys, strict=True)}


def _deviations(
    given: Mapping[str, Any], found: Mapping[str, float], power: NDArray[np.float64], bands: Bands
) -> Iterator[tuple[str, float]]:
    """Column and deviation of each number that one program has."""
    for key, observer in (("XYZ_2deg", "1931"), ("XYZ_10deg", "1964"), ("XYZ2", "1931"), ("XYZ_rel", "1931")):
        if key in given:
            own = xyz(power, bands, observer)[0]
            yield "XYZ", float(np.abs(100.0 * own / own[1] - given[key]).max() / 100.0)
    for key, observer in (("xy_2deg", "1931"), ("xy_10deg", "1964"), ("xy", "1931")):
        if key in given:
            yield "xy", float(np.abs(chromaticity(xyz(power, bands, observer))[0] - given[key]).max())
    for column, key, name in (
        *(("CCT K", "CCT", "cct_k"), ("Duv", "Duv", "duv")),
        *(("Ra", "Ra", "ra"), ("Rf", "Rf", "rf"), ("Rg", "Rg", "rg")),
    ):
        if key in given:
            yield column, abs(found[name] - given[key])
    if "DER_lc_mc_sc_rh_mel" in given:
        order = [RECEPTORS.index(name) for name in _IN_FILE]
        own = daylight_efficacy_ratio(power, bands)[0, order]
        yield "DER", float(np.abs(own / given["DER_lc_mc_sc_rh_mel"] - 1.0).max())


def seconds_of_many(bands: Bands, *, full: bool, count: int = MANY) -> float:
    """CPU seconds that the numbers of so many spectra take, kernels of numpy warm."""
    rng = np.random.default_rng(0)
    names = ("A", "D65", "LED-B3", "FL11")
    basis = np.concatenate([band_integral(photometry.illuminant(n, bands), bands, "hold").value[None] for n in names])
    power = np.einsum("nk,kb->nb", rng.uniform(0.1, 1.0, (count, len(names))), basis)
    numbers = DerivedNumbers(bands, full=full)
    numbers(power[:64])
    start = time.process_time()
    numbers(power)
    return time.process_time() - start


def table_lines(lines: Sequence[Line]) -> list[str]:
    """The table in words."""
    tolerance = _tolerances(colour_values()["tolerances"])
    rows: list[tuple[str, ...]] = [("light", *_COLUMNS, "outside")]
    rows.append(("tolerance", *(f"{tolerance[c]:g}" for c in _COLUMNS), ""))
    for line in lines:
        cells = [f"{line.deviation[c]:.1e}" if c in line.deviation else "" for c in _COLUMNS]
        rows.append((line.light, *cells, ", ".join(line.outside)))
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows]


def main() -> None:
    """Print the table and the times."""
    parser = argparse.ArgumentParser(description=__doc__)
    for edge, default in (("first", 360.0), ("last", 830.0)):
        parser.add_argument(f"--{edge}", type=float, default=default, help=f"centre of the {edge} band [nm]")
    parser.add_argument("--step", type=float, default=5.0, help="width of the bands [nm]")
    asked = parser.parse_args()
    bands = Bands.uniform(asked.first, asked.last, asked.step)
    for line in table_lines(table(bands)):
        print(line)
    for full, what in ((False, "usual numbers"), (True, "all numbers")):
        print(f"{MANY} spectra, {what}: {seconds_of_many(bands, full=full):.2f} CPU s")


if __name__ == "__main__":
    main()

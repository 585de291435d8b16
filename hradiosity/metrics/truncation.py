"""How much of what a number weights lies outside the bands that were computed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.eye import RECEPTORS
from hradiosity.model import photometry
from hradiosity.model.spectrum import Bands, Spectrum

WORTH_TELLING: Final = 1e-3
"""Smallest share outside the bands that is told."""


@dataclass(frozen=True)
class Truncation:
    """What the bands leave out of one number.

    number : what it is called
    outside : share of its weight, 0 … 1, for light of the spectrum asked about; of several weights the largest share
    """

    number: str
    outside: float

    @property
    def is_worth_telling(self) -> bool:
        """Whether it is more than what any number from 380 to 780 nm lacks."""
        return self.outside >= WORTH_TELLING


def outside_share(action: Spectrum, bands: Bands, light: Spectrum | None = None) -> float:
    """Share of an action spectrum's weight that lies outside the bands.

    Parameters
    ----------
    action : Spectrum
        Zero where it isn't tabulated.
    bands : Bands
        Gaps between them are outside as well.
    light : Spectrum, optional
        That it weights, without lines; equal energy if left out. It holds its end values where it isn't tabulated.

    Returns
    -------
    float
        0 … 1; 0 for an action spectrum without weight.

    Raises
    ------
    ValueError
        For an action spectrum, or light, with lines.
    """
    if len(action.line_power):
        raise ValueError("an action spectrum weights light by wavelength; it can't have lines")
    edges = np.concatenate([bands.lower, bands.upper])
    low, high = action.wavelength[0], action.wavelength[-1]
    fine = np.arange(low, high, 0.25)
    at = np.unique(np.concatenate([fine, action.wavelength, edges[(edges > low) & (edges < high)]]))
    return float(_outside(at, np.interp(at, action.wavelength, action.value)[:, None], bands, light)[0])


def truncation(bands: Bands, light: Spectrum | None = None) -> tuple[Truncation, ...]:
    """What the bands leave out of each number.

    Colour rendering and fidelity compare two lights in the same bands, and so lose less than the colours that they are
    made of; the share told for them is that of the colours.

    Parameters
    ----------
    bands : Bands
    light : Spectrum, optional
        Without lines. Equal energy if left out, which is a hard case: light of lamps ends before the eye does.

    Raises
    ------
    ValueError
        For light with lines.
    """
    wavelength, two_degrees = photometry.observer("1931")
    ten_degrees = photometry.observer("1964")[1]
    names = photometry.ALPHA_OPIC_NAMES
    alpha = photometry.alpha_opic()[1]
    groups = {
        "illuminance": photometry.luminous_efficiency().value[:, None],
        "x, y, u′, v′, X, Y, Z, colour temperature, Duv, Ra, R1 to R14": two_degrees,
        "Rf, Rg": ten_degrees,
        **{f"{name} EDI and DER": alpha[:, [names.index(name)]] for name in RECEPTORS},
    }
    at = np.unique(np.concatenate([wavelength, bands.lower, bands.upper]))
    at = at[(at >= wavelength[0]) & (at <= wavelength[-1])]
    found = []
    for name, actions in groups.items():
        brought = np.stack([np.interp(at, wavelength, column) for column in actions.T], axis=1)
        found.append(Truncation(name, float(_outside(at, brought, bands, light).max())))
    return tuple(found)


def truncation_lines(bands: Bands, light: Spectrum | None = None) -> list[str]:
    """A line for each number that the bands leave more than 0.1 % out of.

    Parameters
    ----------
    bands : Bands
    light : Spectrum, optional
        Without lines; equal energy if left out.

    Raises
    ------
    ValueError
        For light with lines.
    """
    of = "equal-energy light" if light is None else "the light"
    extent = f"{bands.lower[0]:g} to {bands.upper[-1]:g} nm"
    return [
        f"{item.number}: {100.0 * item.outside:.2g} % of the weight, for {of}, lies outside the bands ({extent})"
        for item in truncation(bands, light)
        if item.is_worth_telling
    ]


def _outside(
    at: NDArray[np.float64], actions: NDArray[np.float64], bands: Bands, light: Spectrum | None
) -> NDArray[np.float64]:
    """(k,) shares outside of (m, k) actions at (m,) wavelengths that hold all edges; by trapezoids."""
    if light is not None and len(light.line_power):
        raise ValueError("shares outside the bands are told for light without lines")
    power = np.ones_like(at) if light is None else np.interp(at, light.wavelength, light.value)
    weighted = actions * power[:, None]
    area = 0.5 * (weighted[:-1] + weighted[1:]) * np.diff(at)[:, None]
    band = np.searchsorted(bands.lower, at[:-1], side="right") - 1
    inside = (band >= 0) & (at[:-1] < bands.upper[band])
    whole = area.sum(axis=0)
    out = np.zeros(actions.shape[1])
    np.divide(area[~inside].sum(axis=0), whole, out=out, where=whole > 0.0)
    return out

"""Spectra that the bands don't hold, and reflectances that nobody measured."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hradiosity.model import photometry
from hradiosity.model.scene import Luminaire, Scene
from hradiosity.model.spectrum import Bands, band_integral
from hradiosity.space.check.finding import Finding, nowhere

COVERED = 0.99
"""Share of the luminous efficiency's integral that bands must hold."""
CUT = 0.1
"""Power density in an outermost band over the highest one, from which more light is likely beyond."""
_NARROW = 4.0
"""One band, or two beside one another, that hold this many times the density on both sides have a line in them."""
_SHARE = 0.02
"""Lines with a smaller share of the light don't count."""


def spectral_findings(scene: Scene) -> Iterator[Finding]:
    """Bands that miss visible light, lamps that shine beyond the bands, lines, and guessed reflectances."""
    yield from _guessed(scene)
    held = _held(scene.bands)
    if held < COVERED:
        yield Finding(
            "bands-miss-light",
            "info",
            "bands",
            nowhere(),
            0.0,
            f"the bands from {scene.bands.lower[0]:g} to {scene.bands.upper[-1]:g} nm hold {100 * held:.3g} % of the "
            "luminous efficiency",
            "illuminance and colour count light in the bands only",
            "cover 380 to 780 nm without gaps if photometric results matter",
        )
    for number in np.unique(scene.emitters.luminaire):
        yield from _of_lamp(scene.luminaires[number], scene.bands)


def _held(bands: Bands) -> float:
    """Share of the integral of the luminous efficiency that lies in the bands."""
    efficiency = photometry.luminous_efficiency()
    whole = Bands.explicit(efficiency.wavelength[[0, -1]])
    held = band_integral(efficiency, bands, "zero").value.sum()
    return float(held / band_integral(efficiency, whole, "zero").value.sum())


def _guessed(scene: Scene) -> Iterator[Finding]:
    """Materials in use whose spectrum was made up from a colour."""
    for number in np.unique(scene.patches.material):
        material = scene.materials[number]
        if not material.measured:
            own = scene.patches.material == number
            area = float(scene.patches.area[own].sum())
            yield Finding(
                "not-measured",
                "warning",
                material.name,
                scene.patches.centroid[own].mean(axis=0),
                float(np.sqrt(area)),
                f"the reflectance of material '{material.name}' ({area:.3g} m²) was guessed from a colour",
                "spectra and colour rendering are unreliable where its light counts",
                "give it a measured spectrum",
            )


def _of_lamp(lamp: Luminaire, bands: Bands) -> Iterator[Finding]:
    power = lamp.emission
    if not power.any() or len(bands) < 3:
        return
    density = power / bands.width
    ends = [f"{bands.centre[k]:g} nm" for k in (0, -1) if density[k] > CUT * density.max()]
    if ends:
        yield Finding(
            "lamp-cut-off",
            "info",
            lamp.name,
            nowhere(),
            0.0,
            f"luminaire '{lamp.name}' still shines at {' and '.join(ends)}, where the bands end",
            "its light beyond is left out of radiant quantities",
            "",
        )
    place, sent = _lines(power, bands)
    told = sent > _SHARE * power.sum()
    if told.any():
        yield Finding(
            "line-in-band",
            "info",
            lamp.name,
            nowhere(),
            0.0,
            f"{100 * sent[told].sum() / power.sum():.3g} % of the light of luminaire '{lamp.name}' is in lines "
            f"narrower than the bands, at {', '.join(f'{wavelength:.4g}' for wavelength in place[told])} nm",
            "their power is kept, but reflectances count with their mean over a band",
            "use narrower bands there if a reflectance changes steeply",
        )


def _lines(power: NDArray[np.float64], bands: Bands) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean wavelengths [nm] and power of what stands in one band, or in two that share a line, with little beside."""
    density = np.concatenate([[0.0, 0.0], power / bands.width, [0.0, 0.0]])
    little = _NARROW * np.maximum(density[:-3], density[3:])
    narrow = np.zeros(len(density), bool)
    for shift in (1, 2):
        narrow[shift : shift + len(little)] |= density[shift : shift + len(little)] > little
    narrow = narrow[2:-2]
    group = np.cumsum(narrow & ~np.concatenate([[False], narrow[:-1]]))[narrow] - 1
    sent = np.bincount(group, power[narrow]).astype(np.float64)
    place = np.bincount(group, power[narrow] * bands.centre[narrow]) / sent
    return place, sent

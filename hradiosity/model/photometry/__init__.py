"""Standard observers, illuminants and reflectances, as tables inside the package.

``tables.npz`` is made by ``examples/make_photometry_data.py``, which names the source of each table.
"""

import difflib
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.constants import PLANCK_C1L, PLANCK_C2
from hradiosity.model.spectrum import Bands, Spectrum

ALPHA_OPIC_NAMES: Final = ("s-cone-opic", "m-cone-opic", "l-cone-opic", "rhodopic", "melanopic")
"""Columns of `alpha_opic`, in the order of CIE S 026."""
NARROW: Final = 2.0 + 1e-9
"""Widest band [nm] for which lamps come with their lines where they are."""


@cache
def _tables() -> dict[str, NDArray[np.float64]]:
    """All tables by name; read once."""
    with np.load(Path(__file__).with_name("tables.npz")) as stored:
        return {name: stored[name] for name in stored.files}


def _names(group: str) -> tuple[str, ...]:
    return tuple(name.removeprefix(group) for name in _tables() if name.startswith(group))


def _pick(group: str, name: str) -> NDArray[np.float64]:
    """Table ``name`` of a group; ``ValueError`` with the nearest names when there is none."""
    table = _tables().get(group + name)
    if table is None:
        raise ValueError(unknown_name(group.strip("/"), name, _names(group)))
    return table


def unknown_name(what: str, name: str, known: Sequence[str]) -> str:
    """Sentence for a name that isn't in a list, with the nearest ones that are."""
    by_lower = {candidate.lower(): candidate for candidate in known}
    near = [by_lower[match] for match in difflib.get_close_matches(name.lower(), list(by_lower), n=5, cutoff=0.5)]
    return f"no {what} is called {name!r}; " + (
        f"did you mean {', '.join(near)}?" if near else f"there are {', '.join(known)}"
    )


def _spectrum(table: NDArray[np.float64]) -> Spectrum:
    return Spectrum(table[0], table[1])


def observer(name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Colour matching functions of a standard observer.

    Parameters
    ----------
    name : "1931" or "1964"
        CIE 1931 2° or CIE 1964 10° (CIE 15:2018).

    Returns
    -------
    wavelength : (471,) float64 [nm]
    functions : (471, 3) float64
        x̄, ȳ, z̄.

    Raises
    ------
    ValueError
        For another name.
    """
    return _tables()["wavelength"], _pick("observer/", name)


def luminous_efficiency() -> Spectrum:
    """Photopic V(λ) of CIE 018:2019, 360–830 nm in 1 nm, 1 at 555 nm."""
    return Spectrum(_tables()["wavelength"], _tables()["luminous_efficiency"])


def alpha_opic() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Action spectra of the five receptors of the eye, CIE S 026:2018, per unit of energy.

    Returns
    -------
    wavelength : (471,) float64 [nm]
    action : (471, 5) float64
        Columns as in `ALPHA_OPIC_NAMES`, each with its peak at 1.
    """
    return _tables()["wavelength"], _tables()["alpha_opic"]


def illuminant_names() -> tuple[str, ...]:
    """Names that `illuminant` knows."""
    return _names("illuminant/")


def illuminant(name: str, bands: Bands | None = None) -> Spectrum:
    """Relative spectral power per nm of a CIE illuminant, in the scale of its table.

    Fluorescent lamps have two tables in CIE 015:2018. The usual one, every 5 nm, shares a line between the two nearest
    values, so that sums over bands of about 5 nm come out right; the other, every 1 nm, has the lines where they are,
    which serves narrow bands only: in bands of 5 nm a line would move to the middle of its band.

    Parameters
    ----------
    name : str
        One of `illuminant_names`.
    bands : Bands, optional
        What the light will be counted in: where all are at most 2 nm wide, the finer table is taken if there is one.

    Raises
    ------
    ValueError
        For an unknown name, with near matches.
    """
    usual = _pick("illuminant/", name)
    fine = bands is not None and float(bands.width.max()) <= NARROW
    return _spectrum(_tables().get(f"fine/{name}", usual) if fine else usual)


def colorchecker_names() -> tuple[str, ...]:
    """Names of the 24 patches of the classic ColorChecker, row by row."""
    return _names("colorchecker/")


def colorchecker(name: str) -> Spectrum:
    """Reflectance of a patch of the classic ColorChecker, ISO 17321-1, 380–780 nm.

    Raises
    ------
    ValueError
        For an unknown name, with near matches.
    """
    return _spectrum(_pick("colorchecker/", name))


def reflectance_names() -> tuple[str, ...]:
    """Names that `reflectance` knows, besides ``grey/<percent>``."""
    return tuple(name for name in _tables() if name.startswith(("cornell/", "colorchecker/")))


def reflectance(name: str) -> Spectrum:
    """Reflectance from the library: ``cornell/white``, ``colorchecker/dark skin``, ``grey/<percent>`` and others.

    Raises
    ------
    ValueError
        For an unknown name, with near matches, or a grey outside 0 to 100 percent.
    """
    if name.startswith("grey/"):
        return Spectrum.constant(_grey(name))
    if name not in reflectance_names():
        raise ValueError(unknown_name("reflectance", name, (*reflectance_names(), "grey/50")))
    return _spectrum(_tables()[name])


def _grey(name: str) -> float:
    """Reflectance, 0 … 1, that ``grey/<percent>`` names."""
    try:
        percent = float(name.removeprefix("grey/"))
    except ValueError as error:
        raise ValueError(f"{name!r}: a grey is named by its percentage, such as grey/50") from error
    if not 0 <= percent <= 100:
        raise ValueError(f"{name!r}: the percentage of a grey lies between 0 and 100")
    return percent / 100


def blackbody(temperature: float) -> Spectrum:
    """Spectral radiance of a black body [W m⁻² sr⁻¹ nm⁻¹], 300–1100 nm in 1 nm; Planck's law in vacuum.

    Parameters
    ----------
    temperature : float
        [K]

    Raises
    ------
    ValueError
        Unless it is between 500 K and 100 000 K; colder bodies give no light that can be seen.
    """
    if not 500 <= temperature <= 1e5:
        raise ValueError(f"a black body's temperature lies between 500 and 100000 K here, not {temperature}")
    wavelength = np.arange(300.0, 1101.0)
    metres = wavelength * 1e-9
    per_metre = PLANCK_C1L / metres**5 / np.expm1(PLANCK_C2 / (metres * temperature))
    return Spectrum(wavelength, per_metre * 1e-9)

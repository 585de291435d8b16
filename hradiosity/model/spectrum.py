"""Spectra and the bands they are binned into; wavelengths in nanometres throughout."""

from dataclasses import dataclass, field
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

MAX_BANDS: Final = 401
"""Most bands in one run: 1 nm from 380 to 780 nm."""

Outside = Literal["hold", "zero", "refuse"]
"""What a spectrum is where it was not measured: its end value, nothing, or an error."""


def _frozen(values: ArrayLike) -> NDArray[np.float64]:
    """Own, read-only float64 copy."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class Bands:
    """Wavelength intervals that light is counted in; ascending, without overlap, gaps allowed.

    lower, upper : (n,) float64 [nm], edges of each band; 1 to 401 bands

    Raises ``ValueError`` when the edges are no such list.
    """

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]

    def __post_init__(self) -> None:
        lower, upper = _frozen(self.lower), _frozen(self.upper)
        if lower.ndim != 1 or lower.shape != upper.shape:
            raise ValueError(f"band edges must be two lists of one length, have shapes {lower.shape} and {upper.shape}")
        if not 1 <= len(lower) <= MAX_BANDS:
            raise ValueError(f"between 1 and {MAX_BANDS} bands are possible, not {len(lower)}")
        if not (np.isfinite(lower).all() and np.isfinite(upper).all() and lower[0] > 0):
            raise ValueError("band edges must be finite and above 0 nm")
        if not (upper > lower).all():
            raise ValueError("each band's upper edge must lie above its lower edge")
        if not (lower[1:] >= upper[:-1]).all():
            raise ValueError("bands must ascend and must not overlap")
        object.__setattr__(self, "lower", lower)
        object.__setattr__(self, "upper", upper)

    @classmethod
    def uniform(cls, first: float = 380.0, last: float = 780.0, step: float = 5.0) -> "Bands":
        """Bands of one width centred on first, first + step, …, last [nm].

        Raises ``ValueError`` when last is not a whole number of steps from first.
        """
        if not (np.isfinite([first, last, step]).all() and step > 0 and last >= first):
            raise ValueError(f"uniform bands need first <= last and step > 0, got {first}, {last}, {step}")
        steps = round((last - first) / step)
        if steps >= MAX_BANDS:
            raise ValueError(f"between 1 and {MAX_BANDS} bands are possible, not {steps + 1}")
        if abs(first + steps * step - last) > 1e-6 * step:
            raise ValueError(f"{first} to {last} nm is not a whole number of {step} nm steps")
        return cls.explicit(first + step * (np.arange(steps + 2) - 0.5))

    @classmethod
    def explicit(cls, edges_or_pairs: ArrayLike) -> "Bands":
        """Bands between neighbours of a list of edges (n + 1,), or from (n, 2) pairs of lower and upper edge [nm]."""
        edges = np.asarray(edges_or_pairs, dtype=np.float64)
        if edges.ndim == 1:
            return cls(edges[:-1], edges[1:])
        if edges.ndim == 2 and edges.shape[1] == 2:
            return cls(edges[:, 0], edges[:, 1])
        raise ValueError(f"bands are given as a list of edges or of pairs, not as an array of shape {edges.shape}")

    @property
    def centre(self) -> NDArray[np.float64]:
        """(n,) middle of each band [nm]."""
        return 0.5 * (self.lower + self.upper)

    @property
    def width(self) -> NDArray[np.float64]:
        """(n,) width of each band [nm]."""
        return self.upper - self.lower

    def __len__(self) -> int:
        return len(self.lower)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Bands):
            return NotImplemented
        return np.array_equal(self.lower, other.lower) and np.array_equal(self.upper, other.upper)

    def __hash__(self) -> int:
        return hash((self.lower.tobytes(), self.upper.tobytes()))


@dataclass(frozen=True, eq=False)
class Spectrum:
    """A tabulated function of the wavelength, linear between its points, plus narrow lines.

    wavelength : (m,) float64 [nm], strictly ascending; two points or more, or none when there are only lines
    value : (m,) float64, reflectance or power density per nm
    line_wavelength : (k,) float64 [nm], lines much narrower than a band, in any order
    line_power : (k,) float64, whole power of each line, in the unit of ``value`` times nm

    Raises ``ValueError`` when shapes, order or numbers are wrong.
    """

    wavelength: NDArray[np.float64]
    value: NDArray[np.float64]
    line_wavelength: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    line_power: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        for name in ("wavelength", "value", "line_wavelength", "line_power"):
            array = _frozen(getattr(self, name))
            if array.ndim != 1 or not np.isfinite(array).all():
                raise ValueError(f"{name} must be a list of finite numbers")
            object.__setattr__(self, name, array)
        if self.wavelength.shape != self.value.shape:
            raise ValueError(f"{len(self.wavelength)} wavelengths but {len(self.value)} values")
        if self.line_wavelength.shape != self.line_power.shape:
            raise ValueError(f"{len(self.line_wavelength)} line wavelengths but {len(self.line_power)} line powers")
        if len(self.wavelength) == 1 or len(self.wavelength) + len(self.line_wavelength) == 0:
            raise ValueError("a spectrum needs at least two points, or lines")
        if not (np.diff(self.wavelength) > 0).all():
            raise ValueError("wavelengths must strictly ascend")

    @classmethod
    def constant(cls, value: float) -> "Spectrum":
        """The same value at every wavelength that bands may have in practice, 1 nm to 1 mm."""
        return cls(np.array([1.0, 1e6]), np.array([value, value]))


class Binned(NamedTuple):
    """A spectrum brought onto bands.

    value : (n_bands,) float64
    outside_share : share of the summed band width where the spectrum was not tabulated, 0 … 1
    """

    value: NDArray[np.float64]
    outside_share: float


def _continuous_integral(spectrum: Spectrum, bands: Bands, outside: Outside) -> Binned:
    """Exact integral of the piecewise linear part over each band.

    The table is cut at the band edges, and each piece is a trapezoid: sums of terms of one sign, where a difference of
    cumulative integrals could turn out slightly negative.
    """
    if outside not in ("hold", "zero", "refuse"):
        raise ValueError(f"outside must be 'hold', 'zero' or 'refuse', not {outside!r}")
    if len(spectrum.wavelength) == 0:
        return Binned(np.zeros(len(bands)), 0.0)
    cut = np.unique(np.concatenate([spectrum.wavelength, bands.lower, bands.upper]))
    length = np.diff(cut)
    start = cut[:-1]
    band = np.searchsorted(bands.lower, start, side="right") - 1
    in_band = (band >= 0) & (start < bands.upper[band])
    tabulated = (start >= spectrum.wavelength[0]) & (start < spectrum.wavelength[-1])
    share = float(length[in_band & ~tabulated].sum() / length[in_band].sum())
    if outside == "refuse" and share > 0:
        raise ValueError(
            f"the spectrum covers {spectrum.wavelength[0]:g} to {spectrum.wavelength[-1]:g} nm, "
            f"the bands need {bands.lower[0]:g} to {bands.upper[-1]:g} nm"
        )
    height = np.interp(cut, spectrum.wavelength, spectrum.value)
    area = 0.5 * (height[:-1] + height[1:]) * length
    used = in_band & tabulated if outside == "zero" else in_band
    integral = np.zeros(len(bands))
    np.add.at(integral, band[used], area[used])
    return Binned(integral, share)


def band_mean(spectrum: Spectrum, bands: Bands, outside: Outside) -> Binned:
    """Mean of a spectrum over each band, exact for the piecewise linear table: reflectance per band.

    Parameters
    ----------
    spectrum : Spectrum
        Without lines.
    bands : Bands
    outside : "hold", "zero" or "refuse"
        What the spectrum is where it was not tabulated.

    Returns
    -------
    Binned
        ``value`` in the unit of ``spectrum.value``; never outside its range, also not by rounding.

    Raises
    ------
    ValueError
        For a spectrum with lines, or one that does not cover the bands when ``outside`` is "refuse".
    """
    if len(spectrum.line_power):
        raise ValueError("a spectrum with lines has no mean per band, only an integral")
    integral = _continuous_integral(spectrum, bands, outside)
    lowest, highest = spectrum.value.min(), spectrum.value.max()
    if outside == "zero" and integral.outside_share > 0:
        lowest, highest = min(lowest, 0.0), max(highest, 0.0)
    return Binned(np.clip(integral.value / bands.width, lowest, highest), integral.outside_share)


def band_integral(spectrum: Spectrum, bands: Bands, outside: Outside) -> Binned:
    """Integral of a spectrum over each band, exact for the piecewise linear table: power per band from power per nm.

    A line is shared by the band that contains it and the neighbour that it is nearer to, if both are equally wide, so
    that its mean wavelength stays: whole in the middle of a band, half on the edge between two. In one band alone it
    would move by up to half a width, which turns x of a mercury line by 0.008 in bands of 5 nm. Without such a
    neighbour it goes whole into the band; on an edge of other bands into the upper one, on the upper edge of a band
    without a neighbour into that band. Lines between or beyond the bands are left out.

    Parameters
    ----------
    spectrum : Spectrum
    bands : Bands
    outside : "hold", "zero" or "refuse"
        What the continuous part is where it was not tabulated.

    Returns
    -------
    Binned
        ``value`` in the unit of ``spectrum.value`` times nm.

    Raises
    ------
    ValueError
        When the table does not cover the bands and ``outside`` is "refuse".
    """
    power, outside_share = _continuous_integral(spectrum, bands, outside)
    band = np.searchsorted(bands.lower, spectrum.line_wavelength, side="right") - 1
    kept = (band >= 0) & (spectrum.line_wavelength <= bands.upper[band])
    band, sent = band[kept], spectrum.line_power[kept]
    offset = spectrum.line_wavelength[kept] - bands.centre[band]
    beside = np.clip(band + np.where(offset < 0.0, -1, 1), 0, len(bands) - 1)
    low, high = np.minimum(band, beside), np.maximum(band, beside)
    alike = np.isclose(bands.width[band], bands.width[beside], rtol=1e-9, atol=0.0)
    paired = (low < high) & (bands.upper[low] == bands.lower[high]) & alike
    share = np.where(paired, np.abs(offset) / bands.width[band], 0.0)
    np.add.at(power, band, (1.0 - share) * sent)
    np.add.at(power, beside, share * sent)
    return Binned(power, outside_share)

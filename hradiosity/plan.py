"""The plan of a run as a value: what is computed, what is not, and why."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Effect:
    """One thing that a scene may or may not call for.

    name : as in ``--effects name=on``
    needed : whether it will be computed
    because : the reason, in words
    saved_seconds : estimate of what leaving it out saves; 0 when it is needed or nothing is known
    """

    name: str
    needed: bool
    because: str
    saved_seconds: float = 0.0

    def line(self, width: int = 0) -> str:
        """The effect in words, its name padded to `width`."""
        saved = f" (saves about {self.saved_seconds:.2g} s)" if self.saved_seconds >= 0.05 else ""
        return f"{self.name:<{width}}  {'computed' if self.needed else 'left out'}  {self.because}{saved}"


@dataclass(frozen=True)
class SpectralColumns:
    """The right-hand sides that are solved instead of all bands; the bands follow from them exactly.

    Bands in which every material has equal reflectance form a class with one operator. Inside a class the light of
    sources with one spectral shape is solved once and multiplied by that shape afterwards.

    reflectance : (n_materials + 1, n_columns) float32; the last row is the black back of one-sided surfaces
    emission : (n_luminaires, n_columns) float32, exitance or intensity in units of each column
    sky : (n_columns,) float32, π · radiance of the sky in units of each column
    expansion : (n_columns, n_bands) float64, bands = columns @ expansion
    n_classes : number of classes of bands
    variants : (n_columns, n_bands) float64 each, the expansions of the scene's variants
    """

    reflectance: NDArray[np.float32]
    emission: NDArray[np.float32]
    sky: NDArray[np.float32]
    expansion: NDArray[np.float64]
    n_classes: int
    variants: tuple[NDArray[np.float64], ...] = ()

    @property
    def n_columns(self) -> int:
        """Number of right-hand sides."""
        return int(self.expansion.shape[0])

    @property
    def n_groups(self) -> int:
        """Groups of eight columns, the last one filled up with zeros."""
        return max(1, -(-self.n_columns // 8))

    def padded(self, columns: NDArray[np.floating]) -> NDArray[np.float32]:
        """(n, n_columns) as float32 with zero columns up to eight times `n_groups`."""
        out = np.zeros((*columns.shape[:-1], 8 * self.n_groups), np.float32)
        out[..., : self.n_columns] = columns
        return out

    def to_bands(self, columns: NDArray[np.floating]) -> NDArray[np.float64]:
        """(n, n_columns or more) values of the columns as values of the bands, (n, n_bands)."""
        used = np.asarray(columns[..., : self.n_columns], np.float64)
        bands: NDArray[np.float64] = np.einsum("...c,cb->...b", used, self.expansion)
        return bands

    @property
    def summed(self) -> NDArray[np.float64]:
        """(n_columns, n_bands) what a unit of each column stands for in the scene and all its variants together."""
        return np.asarray(np.sum([self.expansion, *self.variants], axis=0))

    @property
    def members(self) -> list[NDArray[np.bool_]]:
        """(n_columns,) which columns the scene is made of, then the same of each variant."""
        return [np.asarray(expansion.any(axis=1)) for expansion in (self.expansion, *self.variants)]

    def of_variant(self, number: int) -> SpectralColumns:
        """The same columns as they make up the bands of a variant."""
        return replace(self, expansion=self.variants[number], variants=())

    def unlike(self, number: int) -> SpectralColumns:
        """The columns with what a variant's bands and the scene's do not have in common, all counted as gain.

        Where a column has a relative error, errors of the difference of both are bounded by that share of these bands:
        columns that both have alike cancel.
        """
        return replace(self, expansion=np.abs(self.variants[number] - self.expansion), variants=())


@dataclass(frozen=True)
class Calibration:
    """How fast a device was in an earlier run; what another scene will take follows from it within a factor of 2.

    exchange_rays_per_s : exchange rays from row elements
    shadow_rays_per_s : shadow rays from row elements
    reading_paths_per_s : paths from readings, see `hradiosity.planning_seconds.reading_paths`
    exchange_s_per_ray : pooling and closing the exchange, for each exchange ray
    solve_s_per_ray_column : solution, for each right-hand side and ray of `hradiosity.planning_seconds.solution_rays`
    """

    exchange_rays_per_s: float
    shadow_rays_per_s: float
    reading_paths_per_s: float
    exchange_s_per_ray: float
    solve_s_per_ray_column: float


@dataclass(frozen=True)
class ClassicCalibration:
    """How fast a device was in an earlier run of the classic mode.

    seconds_per_pixel : of a hemicube, see `hradiosity.planning_classic.pixels_drawn`
    seconds_per_product : of all the rest, see `hradiosity.planning_classic.products`
    """

    seconds_per_pixel: float
    seconds_per_product: float


@dataclass(frozen=True)
class SightShare:
    """What shafts proved about the lamps of one kind and the elements of the lit space that they shine into.

    lamp : name of the luminaire
    space : number of the lit space, from 0
    lamps : lamps of that kind there
    pairs : pairs of an element and a lamp that face each other
    free : those of them with nothing in between for sure
    """

    lamp: str
    space: int
    lamps: int
    pairs: int
    free: int

    @property
    def is_whole(self) -> bool:
        """Whether nothing stands between any of them."""
        return self.free == self.pairs


@dataclass(frozen=True)
class LinkCount:
    """Hierarchical links between nodes over the row elements.

    form_factor : largest form factor of a link of nodes that can be split
    per_level : links by the level of the finer end, single elements first
    proved_share : share of them that shafts prove free
    rays : shadow rays for the others, per replicate
    """

    form_factor: float
    per_level: tuple[int, ...]
    proved_share: float
    rays: int

    @property
    def total(self) -> int:
        """Number of links."""
        return sum(self.per_level)

    def line(self, n_elements: int) -> str:
        """In words."""
        each = self.total / max(n_elements, 1)
        return (
            f"{self.total} links of form factors up to {self.form_factor:g} at {len(self.per_level)} levels, "
            f"{each:.3g} an element; {100 * self.proved_share:.0f} % proved free by shafts, "
            f"{self.rays / 1e6:.2g} million rays a replicate for the others"
        )


@dataclass(frozen=True)
class Plan:
    """What a run will do; prints itself.

    effects : those that were weighed
    columns : right-hand sides
    n_bands, n_patches, n_emitters, n_readings : sizes of the scene; of the emitters, those that get shadow rays
    weak_emitters : (n,) bool, emitters of the scene that are left to the rays that meet them
    element_size : edge of a row element [m]
    n_elements : number of row elements
    elements_asked : number of them that was asked for; 0 if their edge was
    size_bound : why there are more or fewer than that, in words; empty if there is no reason but rounding
    rays_per_element, light_points, light_samples, gather_samples, replicates : samples of each kind, per replicate
    occlusion : whether shadow rays are traced
    interreflection : whether reflected light is computed
    memory_bytes : estimated peak of the device arrays
    seconds : expected wall seconds; None when the device was never measured
    solver : what solves for the light on the surfaces; empty when nothing reflects
    shooters, hemicubes, shots : of the classic mode: patches that shoot, and what is drawn and shot in all replicates
        together; 0 in the mode of rays
    links : hierarchical links; None for exchange by rows of rays
    form_factors : in the words of ``--form-factors``
    pairs : that they are computed for, at most; of cells that face each other, for hemicubes of elements; 0 for rays
    most_pairs : that memory allows
    sight : what shafts proved of each kind of lamp in each lit space; empty where none were tried
    """

    effects: tuple[Effect, ...]
    columns: SpectralColumns
    n_bands: int
    n_patches: int
    n_emitters: int
    weak_emitters: NDArray[np.bool_]
    n_readings: int
    element_size: float
    n_elements: int
    elements_asked: int
    size_bound: str
    rays_per_element: int
    light_points: int
    light_samples: int
    gather_samples: int
    replicates: int
    occlusion: bool
    interreflection: bool
    memory_bytes: int
    seconds: float | None
    solver: str = ""
    shooters: int = 0
    hemicubes: int = 0
    shots: int = 0
    sight: tuple[SightShare, ...] = ()
    links: LinkCount | None = None
    form_factors: str = "rays"
    pairs: int = 0
    most_pairs: int = 0

    @property
    def gathers(self) -> bool:
        """Whether light comes from surfaces that rays meet."""
        return self.interreflection or bool(self.weak_emitters.any())

    def lines(self) -> list[str]:
        """The plan in words, a line each."""
        width = max((len(effect.name) for effect in self.effects), default=0)
        out = [effect.line(width) for effect in self.effects]
        out += [f"lamp '{s.lamp}' in space {s.space}: free everywhere" for s in self.sight if s.is_whole]
        out += [
            f"{self.n_patches} patches in {self.n_elements} elements of about {self.element_size:.3g} m; "
            f"emitters with shadow rays: {self.n_emitters}, readings: {self.n_readings}, bands: {self.n_bands}",
            f"about {self._effort()}, in {self.replicates} replicates; {self.memory_bytes / 2**20:.0f} MiB",
            f"solver: {self.solver or 'none, since nothing reflects'}",
        ]
        if self.pairs:
            kind = "elements" if self.form_factors == "hemicube" else "cells"
            counts = f"{self.pairs / 1e6:.2g} million pairs of {kind}, of {self.most_pairs / 1e6:.2g} million that fit"
            out.append(f"form factors: {self.form_factors}, for up to {counts}; --elements makes them fewer")
        if self.links is not None:
            out.append(self.links.line(self.n_elements))
        if self.size_bound:
            counts = f"{self.elements_asked} asked for, {self.n_elements} made"
            out.append(f"elements: {counts}: {self.size_bound}; --element-size forces it")
        aside = "reading files, pictures and the audit aside"
        known = "not measured on this device yet" if self.seconds is None else f"about {self.seconds:.2g} s, {aside}"
        return [*out, f"time: {known}"]

    def _effort(self) -> str:
        if self.hemicubes:
            return f"{self.hemicubes} hemicubes and {self.shots} shots"
        rays = self.replicates * (self.n_elements * self.rays_per_element + 2 * self.n_readings * self.gather_samples)
        return f"{rays / 1e6:.2g} million rays and as many towards the lamps"

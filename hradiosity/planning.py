"""What a scene calls for: effects, right-hand sides, sizes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.model.geometry import NONE
from hradiosity.model.scene import Scene
from hradiosity.model.variants import stacked_emission, stacked_reflectance, stacked_sky
from hradiosity.options import Options
from hradiosity.plan import Calibration, Effect, Plan, SightShare, SpectralColumns
from hradiosity.planning_memory import element_bytes, kept_bytes, path_bytes
from hradiosity.planning_seconds import shadow_seconds, with_seconds
from hradiosity.space.convexity import is_convex
from hradiosity.space.hierarchy import Elements
from hradiosity.space.lit_sides import LitSides
from hradiosity.space.shafts import FREE, HIDDEN, UNKNOWN
from hradiosity.transport.glow import weak_emitters

LEAST_SHARE, LARGEST_SHARE = 0.05, 0.2
"""Bounds of a row element's edge, as shares of the mean free path of light."""

SHARED_BY = 8
"""Emitters that each get all the shadow rays asked for; more share as many as these have together."""
MANY_TIMES, LEAST_RAYS_SHARE = 4, 0.5
"""Times the elements asked for from which on each sends fewer rays, and the least part of them."""
FEW_REFLECTIONS = 0.7
"""Mean reflectance in any band up to which they do: the closure of rows has an error of one over the rays of each,
which grows with the number of reflections."""
FEW_READINGS, MOST_FOR_FEW = 1000, 8.0
"""Readings from which on each has the paths of a quality, and times as many that each of few may have."""
MOST_BY_PATH = 64_000
"""Elements that the free path may ask for: between two plates as wide as a field it is short."""
MOST_TIMES, ANYWAY = 16, 2000
"""Times the elements asked for, and elements in any case, up to which a short mean free path makes more: between plates
that nearly touch it would make millions."""

REFINEMENT = "refinement"
"""Name of the effect that elements are split where one value for each is too coarse."""
MOST_ELEMENTS = 5_000_000
"""More than any device at hand holds the exchange of; so many are asked for by a slip of units."""


def spectral_columns(scene: Scene) -> SpectralColumns:
    """The fewest right-hand sides from which all bands follow exactly.

    Bands in which every material that is used has the same reflectance form a class. In a class, sources whose spectra
    are equal up to a factor need one right-hand side; if there are as many shapes as bands, the bands are solved as
    they are. The bands of variants are further bands.
    """
    used = np.unique(scene.patches.material) if len(scene.patches) else np.zeros(0, np.int32)
    reflectance = stacked_reflectance(scene)
    sources = np.concatenate([stacked_emission(scene), stacked_sky(scene)[None]])
    _, band_class = np.unique(reflectance[used].T, axis=0, return_inverse=True)
    parts = [
        _columns_of_class(sources, np.flatnonzero(band_class.ravel() == k)) for k in range(int(band_class.max()) + 1)
    ]
    first_band = np.concatenate([np.full(len(p[0]), p[2], np.int64) for p in parts])
    emission = np.concatenate([p[1] for p in parts], axis=1)
    column_reflectance = np.zeros((len(scene.materials) + 1, emission.shape[1]))
    column_reflectance[:-1] = reflectance[:, first_band]
    expansion, *variants = np.split(np.concatenate([p[0] for p in parts]), 1 + len(scene.variants), axis=1)
    return SpectralColumns(
        reflectance=column_reflectance.astype(np.float32),
        emission=emission[:-1].astype(np.float32),
        sky=emission[-1].astype(np.float32),
        expansion=expansion,
        n_classes=len(parts),
        variants=tuple(variants),
    )


def _columns_of_class(
    sources: NDArray[np.float64], bands: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Expansion (n_columns, n_bands), emission (n_sources, n_columns) and a band of one class."""
    inside = sources[:, bands]
    peak = inside.max(axis=1)
    shining = np.flatnonzero(peak > 0.0)
    shapes = inside[shining] / peak[shining, None]
    _, first, shape_of = np.unique(np.round(shapes, 12), axis=0, return_index=True, return_inverse=True)
    if len(first) < len(bands):
        expansion = np.zeros((len(first), sources.shape[1]))
        expansion[:, bands] = shapes[first]
        emission = np.zeros((len(sources), len(first)))
        emission[shining, shape_of.ravel()] = peak[shining]
        top = np.maximum(emission.max(axis=0, initial=0.0), np.finfo(float).tiny)
        return expansion * top[:, None], emission / top, int(bands[0])
    top = np.maximum(inside.max(axis=0), np.finfo(float).tiny)
    expansion = np.zeros((len(bands), sources.shape[1]))
    expansion[np.arange(len(bands)), bands] = top
    return expansion, inside / top, int(bands[0])


def paths_of_reading(options: Options, n_readings: int) -> int:
    """Paths from a reading, all replicates together, see `Options.more_for_few`.

    A run to an accuracy sets out with few: it adds what each reading needs.
    """
    if not options.more_for_few or options.accuracy is not None:
        return options.gather_samples
    return round(options.gather_samples * min(max(FEW_READINGS / max(n_readings, 1), 1.0), MOST_FOR_FEW))


def _light_samples(options: Options, n_emitters: int) -> int:
    """Shadow rays from a reading to each emitter in a replicate: many emitters average out, and share the rays."""
    return max(1, round(options.light_samples * shared_rays(n_emitters) / options.replicates))


def shared_rays(n_emitters: int) -> float:
    """Part of the shadow rays asked for that each emitter gets."""
    return min(1.0, SHARED_BY / max(n_emitters, 1))


def make_plan(scene: Scene, options: Options, lit: LitSides) -> Plan:
    """Weigh each effect against the scene, and choose sizes that the options leave open.

    Parameters
    ----------
    scene : Scene
    options : Options
    lit : LitSides

    Raises
    ------
    SceneError
        When the edge that is asked for gives too many elements.
    """
    columns = spectral_columns(scene)
    occlusion = _occlusion(scene, options)
    interreflection = _interreflection(scene, options)
    glow, weak = _glow(scene, options, lit)
    area = float(np.einsum("p,ps->", scene.patches.area, lit.lit)) if len(scene.patches) else 0.0
    size, size_bound = _element_size(area, options, lit.free_path)
    n_elements = _elements_of(area, size) + int(lit.lit.sum())
    n_readings = sum(len(s.position) for s in scene.sensors)
    replicates = options.replicates
    plan = Plan(
        effects=(
            occlusion,
            interreflection,
            glow,
            _openness(lit),
            _backs(scene, lit),
            _bands(scene, columns),
            _refinement(options, n_readings, interreflection),
            _shadow_refinement(scene, options),
        ),
        columns=columns,
        n_bands=len(scene.bands),
        n_patches=len(scene.patches),
        n_emitters=int(np.count_nonzero(~weak)),
        weak_emitters=weak,
        n_readings=n_readings,
        element_size=size,
        n_elements=n_elements,
        elements_asked=options.elements if options.element_size is None else 0,
        size_bound=size_bound,
        rays_per_element=max(16, -(-_rays_per_element(scene, options, lit, n_elements) // replicates)),
        light_points=-(-options.light_points // replicates),
        light_samples=_light_samples(options, int(np.count_nonzero(~weak))),
        gather_samples=-(-paths_of_reading(options, n_readings) // replicates),
        replicates=replicates,
        occlusion=occlusion.needed,
        interreflection=interreflection.needed,
        memory_bytes=0,
        seconds=None,
        solver=_solver_name(options) if interreflection.needed else "",
    )
    return sized(plan, n_elements)


def _rays_per_element(scene: Scene, options: Options, lit: LitSides, n_elements: int) -> int:
    """Of all replicates. A reading's noise falls with the rays of all elements together: where there are far more
    elements than were asked for, each needs fewer of them. Not where light is reflected often, see `FEW_REFLECTIONS`.
    """
    if n_elements <= MANY_TIMES * options.elements:
        return options.rays_per_element
    weight = scene.patches.area * lit.lit.sum(axis=1)
    reflected = np.einsum("p,pb->b", weight, scene.reflectance[scene.patches.material]) / weight.sum()
    if float(reflected.max(initial=0.0)) > FEW_REFLECTIONS:
        return options.rays_per_element
    share = max((MANY_TIMES * options.elements / n_elements) ** 0.5, LEAST_RAYS_SHARE)
    return int(np.ceil(share * options.rays_per_element))


def _element_size(area: float, options: Options, free_path: float) -> tuple[float, str]:
    """Edge of a row element [m], and in words what keeps it from giving the number of elements asked for."""
    if options.element_size is not None:
        return options.element_size, ""
    size = float(np.sqrt(area / options.elements))
    if size < LEAST_SHARE * free_path:
        return LEAST_SHARE * free_path, f"cells no smaller than {100 * LEAST_SHARE:g} % of the mean free path"
    finest = float(np.sqrt(area / max(MOST_TIMES * options.elements, ANYWAY)))
    if finest > LARGEST_SHARE * free_path:
        return finest, f"no more though they are larger than {100 * LARGEST_SHARE:g} % of the mean free path"
    largest, smallest = LARGEST_SHARE * free_path, float(np.sqrt(area / MOST_BY_PATH))
    if size > max(largest, smallest):
        bound = f"cells no larger than {100 * LARGEST_SHARE:g} % of the mean free path"
        return max(largest, smallest), bound + (f", but {MOST_BY_PATH} at most" if smallest > largest else "")
    return size, ""


def _solver_name(options: Options) -> str:
    """In the words of ``--solver``."""
    if options.mode == "classic":
        return "southwell"
    return f"{options.solver} with {options.blocks} blocks" if options.solver == "block-inversion" else options.solver


def _elements_of(area: float, size: float) -> int:
    """Elements of an edge that an area holds; `SceneError` if that is past any use."""
    count = area / size**2
    if count > MOST_ELEMENTS:
        found = f"elements of {size:g} m on {area:.3g} m² of lit surfaces are {count:.2g}"
        raise SceneError([Fault("command line", "--element-size", found, f"{MOST_ELEMENTS} elements at most")])
    return int(count)


def sized(plan: Plan, n_elements: int, calibration: Calibration | None = None) -> Plan:
    """The plan for another number of elements than it was made for, memory and seconds included."""
    changed = replace(plan, n_elements=n_elements)
    changed = replace(changed, memory_bytes=element_bytes(changed) + path_bytes(changed) + kept_bytes(changed))
    return changed if calibration is None else with_seconds(changed, calibration)


def with_sight(
    plan: Plan,
    sight: NDArray[np.uint8],
    shares: tuple[SightShare, ...],
    *,
    readings_proved: bool,
    calibration: Calibration | None = None,
) -> Plan:
    """The plan once shafts were tried.

    Parameters
    ----------
    sight : (n_rows, n_emitters) uint8
        See `hradiosity.space.shafts`.
    shares : tuple of SightShare
    readings_proved : bool
        The same is sure of all readings.
    calibration : Calibration, optional
        Rates of the device, for the seconds that the proofs save.
    """
    facing = max(int(np.count_nonzero(sight != HIDDEN)), 1)
    free = np.count_nonzero(sight == FREE) / facing
    saved = 0.0 if calibration is None else free * shadow_seconds(plan, calibration)
    whole = int((sight != UNKNOWN).all(axis=0).sum())
    if whole == plan.n_emitters and readings_proved:
        because = "nothing stands between lamps, surfaces and readings: proved by shafts"
    else:
        because = f"{100 * free:.0f} % of {facing} element-lamp pairs proved free by shafts"
        because += f", for {whole} of {plan.n_emitters} lamps all" if whole else ""
    occlusion = Effect("occlusion", whole < plan.n_emitters or not readings_proved, because, saved)
    effects = tuple(occlusion if effect.name == "occlusion" else effect for effect in plan.effects)
    seconds = None if plan.seconds is None else plan.seconds - saved
    return replace(plan, effects=effects, occlusion=occlusion.needed, seconds=seconds, sight=shares)


def sight_shares(
    scene: Scene, elements: Elements, space: NDArray[np.int32], sight: NDArray[np.uint8]
) -> tuple[SightShare, ...]:
    """What is sure of each kind of lamp in each space (n_rows,) that it stands in; point sources stand in all."""
    lamps = scene.emitters
    cell = elements.first_cell[np.maximum(lamps.patch, 0), 0]
    own = np.where(lamps.patch == NONE, -1, space[elements.cell_row[np.minimum(cell, len(elements.cell_row) - 1)]])
    out = []
    for s in np.unique(space):
        inside = sight[space == s]
        facing, free = (inside != HIDDEN).sum(axis=0), (inside == FREE).sum(axis=0)
        here = ((own == s) | (own == -1)) & (facing > 0)
        for k in np.unique(lamps.luminaire[here]):
            of_kind = here & (lamps.luminaire == k)
            counts = int(of_kind.sum()), int(facing[of_kind].sum()), int(free[of_kind].sum())
            out.append(SightShare(scene.luminaires[k].name, int(s), *counts))
    return tuple(out)


def _occlusion(scene: Scene, options: Options) -> Effect:
    if options.occlusion is not None:
        return Effect("occlusion", options.occlusion, "as asked for")
    lamps = scene.emitters.position[scene.emitters.patch == NONE]
    if is_convex(scene.patches, np.concatenate([lamps, *(s.position for s in scene.sensors)])):
        return Effect("occlusion", False, "the scene is convex: nothing can stand between two points")
    return Effect("occlusion", True, "surfaces can stand between two points")


def _interreflection(scene: Scene, options: Options) -> Effect:
    if options.interreflection is not None:
        return Effect("interreflection", options.interreflection, "as asked for")
    used = np.unique(scene.patches.material)
    if len(used) == 0 or float(stacked_reflectance(scene)[used].max(initial=0.0)) == 0.0:
        return Effect("interreflection", False, "nothing reflects")
    return Effect("interreflection", True, "surfaces reflect")


def _glow(scene: Scene, options: Options, lit: LitSides) -> tuple[Effect, NDArray[np.bool_]]:
    """Whether emitters are left to the rays that meet them, and which."""
    n = len(scene.emitters)
    if options.mode == "classic" or not n:
        return Effect("glow", False, "no lamp is left to the rays that meet it"), np.zeros(n, bool)
    if options.glow is not None:
        return Effect("glow", options.glow, "as asked for"), (scene.emitters.patch != NONE) & options.glow
    weak = weak_emitters(scene, lit)
    found = int(np.count_nonzero(weak))
    if not found:
        return Effect("glow", False, "every lamp stands out and gets shadow rays"), weak
    return Effect("glow", True, f"{found} of {n} lamps are weak or even enough for the rays that meet them"), weak


def _openness(lit: LitSides) -> Effect:
    n_open = int(lit.open.sum())
    if n_open == 0:
        return Effect("outside", False, f"lit spaces: {len(lit.open)}, none of them open")
    return Effect("outside", True, f"lit spaces: {len(lit.open)}, open ones: {n_open}")


def _backs(scene: Scene, lit: LitSides) -> Effect:
    n_backs = int(lit.lit[:, 1].sum())
    if n_backs == 0:
        return Effect("back sides", False, "light reaches front sides only")
    return Effect("back sides", True, f"light reaches the backs of {n_backs} of {len(scene.patches)} patches")


def _bands(scene: Scene, columns: SpectralColumns) -> Effect:
    n = len(scene.bands) * (1 + len(scene.variants))
    if columns.n_columns < n:
        reason = f"{n} bands follow exactly from {columns.n_columns} right-hand sides in {columns.n_classes} classes"
        return Effect("bands singly", False, reason)
    of_variants = f", those of {len(scene.variants)} variants too," if scene.variants else ""
    return Effect("bands singly", True, f"all {n} bands{of_variants} differ in reflectance or light")


def _refinement(options: Options, n_readings: int, interreflection: Effect) -> Effect:
    if options.mode == "classic" or options.links != "rows" or options.form_factors != "rays":
        return Effect(REFINEMENT, False, "only elements that exchange light by rays of their own are split")
    if options.refinement is False:
        return Effect(REFINEMENT, False, "as asked for")
    if not n_readings or not interreflection.needed:
        return Effect(REFINEMENT, False, "no reading depends on light between elements")
    return Effect(REFINEMENT, True, "elements are split if light inside of them turns out to differ too much")


def _shadow_refinement(scene: Scene, options: Options) -> Effect:
    if not options.pictures:
        return Effect("shadow refinement", False, "no pictures or maps are asked for, and readings do not use it")
    if not len(scene.emitters):
        return Effect("shadow refinement", False, "no lamp casts shadows")
    return Effect("shadow refinement", True, "pictures or maps are asked for")

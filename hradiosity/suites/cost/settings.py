"""The settings whose price is measured."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any, Final, Literal, cast, get_args

import numpy as np

from hradiosity.model.spectrum import Bands
from hradiosity.options import QUALITIES, FormFactorName, Lookup, Options, Quality, SolverName

Group = Literal[
    "quality",
    "elements",
    "rays per element",
    "light points",
    "light samples",
    "gather samples",
    "lookup",
    "replicates",
    "form factors",
    "links",
    "classic",
    "combined",
    "solver",
    "effect",
    "bands",
]
"""The last three are priced in tables of their own."""
KNOBS: Final[dict[str, Group]] = {
    "elements": "elements",
    "rays_per_element": "rays per element",
    "light_points": "light points",
    "light_samples": "light samples",
    "gather_samples": "gather samples",
}
"""Options that are varied alone, and what they are called."""
SOLVERS: Final = get_args(SolverName)
DIRECT: Final = ("gaussian-elimination", "block-inversion")
FEW_ELEMENTS: Final = 500
"""Asked for where time grows with the third power of their number."""
FORCED: Final = (
    ("all shadow rays traced", "--occlusion on", {"occlusion": True}),
    ("lamps found by rays alone", "--glow on", {"glow": True}),
    ("shadow rays to all lamps", "--glow off", {"glow": False}),
    ("elements split", "--refinement on", {"refinement": True}),
    ("no elements split", "--refinement off", {"refinement": False}),
    ("all columns solved", "reduced_basis=False", {"reduced_basis": False}),
)
"""Effects that may be forced without making the result wrong: words, how to ask for it, and the change of options."""
BANDS: Final = (9, 24, 41, 81, 401)
SHORT: Final = {
    "elements": "elements",
    "rays_per_element": "rays",
    "light_points": "points",
    "light_samples": "light",
    "gather_samples": "gather",
}
"""The same in names of combinations."""
FACTORS: Final = (0.5, 2.0, 4.0)
LEAST_FACTOR: Final = {"elements": 0.25, "gather_samples": 0.25}
"""Of knobs that make a run much cheaper: short budgets measure little else."""
LEAST_RAYS: Final = 16
"""From each element in every replicate, whatever is asked for."""
REPLICATES: Final = (2, 8)
RESOLUTIONS: Final = (32, 64, 128, 256, 512)
CLASSIC_ELEMENTS: Final = 1000
"""Patches that shoot, about; elements are split where the light changes, and time grows with the square."""
METHODS: Final[tuple[FormFactorName, ...]] = (
    *("rays", "point", "point-disk", "auto", "contour"),
    *("quasi-hemisphere", "hemisphere", "monte-carlo", "hemicube"),
)
"""Of form factors, about by rising cost."""
PAIRED_ELEMENTS: Final = 1000
"""Asked for where all pairs count, and for rays beside them."""
CLASSIC_REPLICATES: Final = 2
"""Hemicubes hardly differ between replicates; two are the fewest that give intervals."""


@dataclass(frozen=True)
class Setting:
    """One way to compute the scene.

    name : short, for tables and pictures
    group : what it belongs to
    options : of the run, seed left at 0
    """

    name: str
    group: Group
    options: Options

    @property
    def flags(self) -> str:
        """How the command line asks for it."""
        for quality in QUALITIES:
            if self.options == Options.of_quality(cast(Quality, quality)):
                return f"--quality {quality}"
        usual, own = asdict(Options()), asdict(self.options)
        return " ".join(f"--{name.replace('_', '-')} {own[name]}" for name in own if own[name] != usual[name])


def qualities() -> list[Setting]:
    """Draft, normal and fine."""
    return [Setting(name, "quality", Options.of_quality(cast(Quality, name))) for name in QUALITIES]


def single_knobs() -> list[Setting]:
    """Each knob alone, the others as in normal."""
    usual = Options()
    found = [
        Setting(f"{word} × {factor:g}", word, replace(usual, **{name: round(factor * getattr(usual, name))}))
        for name, word in KNOBS.items()
        for factor in ([LEAST_FACTOR[name]] if name in LEAST_FACTOR else []) + list(FACTORS)
        if name != "rays_per_element" or factor * usual.rays_per_element > LEAST_RAYS * usual.replicates
    ]
    others = (lookup for lookup in get_args(Lookup) if lookup != usual.lookup)
    found += [Setting(f"lookup {lookup}", "lookup", replace(usual, lookup=lookup)) for lookup in others]
    found += [Setting(f"replicates {n}", "replicates", replace(usual, replicates=n)) for n in REPLICATES]
    return found


def methods() -> list[Setting]:
    """Every method of form factors on few elements, and hierarchical links."""
    few = Options(elements=PAIRED_ELEMENTS)
    found = [Setting(f"{name}, few elements", "form factors", replace(few, form_factors=name)) for name in METHODS]
    return [*found, Setting("hierarchical links", "links", Options(links="hierarchical"))]


def classic() -> list[Setting]:
    """Hemicubes and shooting at several resolutions."""
    usual = Options(mode="classic", elements=CLASSIC_ELEMENTS, replicates=CLASSIC_REPLICATES)
    return [Setting(f"classic {n}²", "classic", replace(usual, hemicube_resolution=n)) for n in RESOLUTIONS]


def combined(factors: dict[str, float]) -> Setting:
    """Several knobs at once, each times a factor.

    Parameters
    ----------
    factors : dict
        Of the names in `KNOBS`.
    """
    usual = Options()
    changed: dict[str, Any] = {name: round(factor * getattr(usual, name)) for name, factor in factors.items()}
    short = ", ".join(f"{SHORT[name]} ×{factor:g}" for name, factor in factors.items())
    return Setting(short, "combined", replace(usual, **changed))


def warm_up() -> Setting:
    """A small run that builds the kernels; nothing of it is told."""
    return Setting("warm-up", "quality", Options.of_quality("draft", elements=500, gather_samples=64, light_samples=16))


def for_solver(name: SolverName) -> Setting:
    """A run that does little beside solving."""
    options = Options.of_quality("draft", solver=name, gather_samples=2, light_samples=1, replicates=2)
    if name in DIRECT:
        options = replace(options, elements=FEW_ELEMENTS)
    return Setting(name, "solver", options)


def for_bands(count: int) -> Setting:
    """Draft, for a scene in so many bands."""
    return Setting(f"{count} bands", "bands", Options.of_quality("draft"))


def bands_like(bands: Bands, count: int) -> Bands:
    """So many bands of one width over the range of others."""
    return Bands.explicit(np.linspace(bands.lower[0], bands.upper[-1], count + 1))


def forced(options: Options, change: dict[str, bool]) -> Options:
    """Options with an effect of `FORCED`."""
    changes: dict[str, Any] = dict(change)
    return replace(options, **changes)


def efforts_of(options: Options) -> dict[str, float]:
    """What grows along each group of settings."""
    found: dict[str, float] = {word: float(getattr(options, name)) for name, word in KNOBS.items()}
    return found | {"replicates": float(options.replicates), "classic": float(options.hemicube_resolution)}

"""What a user may choose about a run."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final, Literal, get_args

Mode = Literal["rays", "classic"]
Quality = Literal["draft", "normal", "fine"]
LinkKind = Literal["rows", "hierarchical"]
FormFactorName = Literal[
    "rays", "hemicube", "point", "point-disk", "hemisphere", "quasi-hemisphere", "monte-carlo", "contour", "auto"
]
Lookup = Literal[1, 2, 3]
SolverName = Literal[
    "cg", "southwell", "overshooting", "jacobi", "gauss-seidel", "gaussian-elimination", "block-inversion", "auto"
]
QUALITIES: Final = MappingProxyType(
    {
        "draft": {
            "elements": 3000,
            "light_points": 16,
            "gather_samples": 512,
            "light_samples": 256,
        },
        "normal": {},
        "fine": {"elements": 16000, "light_points": 64, "gather_samples": 8192, "light_samples": 2048},
    }
)
"""What each quality sets apart from the defaults; README tells what each costs."""


@dataclass(frozen=True, kw_only=True)
class Options:
    """Settings of a run; None lets the plan decide.

    elements : row elements that the lit area is cut into, about; small patches and the mean free path bound it
    element_size : edge of a row element [m], instead
    rays_per_element : exchange rays from each row element, all replicates together, 16 in each or more; down to half as
        many where there are more than four times as many elements as asked for and light is not reflected often
    light_points : points on each row element from which a ray goes to each emitter, all replicates together
    light_samples : shadow rays from a reading to each emitter, all replicates together; as many as to eight emitters in
        all where there are more of them
    gather_samples : paths from a reading, all replicates together
    more_for_few : where there are fewer than a thousand readings, as many paths as a thousand have together, but no
        more than eight times as many for each: beside the elements they cost little; in qualities, without an accuracy
    lookup : first hit of a path at which the solution may be looked up, 1, 2 or 3; later ones halve the error of coarse
        elements, but double and triple the variance and the price of a path: more elements are the cheaper way
    replicates : independent runs whose spread gives the intervals, at least 2
    accuracy : wanted half width of the 95 % interval over the value, of each reading; readings that lack it get more
        samples, and other elements where these are in the way: the other settings say where to start
    time : wall seconds that the run may take
    audit : check the intervals by unbiased paths after the run; a run with a time limit leaves a fifth of it to that
    occlusion, interreflection : force an effect on or off
    glow : leave all lamps with an area to the rays that meet them, without shadow rays, or none
    refinement : split elements inside of which light changes, even where it hardly matters, or none
    pictures : pictures or maps will be drawn, which calls for shadow refinement
    full_metrics : R1 to R14, Rf and Rg too are derived from each reading
    tolerance : of the linear solver, residual over right-hand side
    solver : ``--solver`` of the command line; the classic mode always shoots
    blocks : along each edge of the matrix, for the solver "block-inversion"
    reduced_basis : solve a few columns and combine the others from them where a certificate allows it; False solves
        all
    seed : of all random numbers, 0 to 2³² − 1
    mode : ``--mode`` of the command line: "rays", or "classic" for hemicubes, shooting and adaptive subdivision
    links : ``--links`` of the command line: how elements exchange light in the mode "rays": "rows" by rays from each
        element, "hierarchical" over links between coarser and finer parts of patches
    link_form_factor : largest form factor of a hierarchical link, either way, unless both ends are single elements
    hemicube_resolution : pixels along an edge of a hemicube's top face, even and at least 8; of the classic mode
        and of hemicubes as form factors
    form_factors : ``--form-factors`` of the command line: what the exchange between elements is made of in the mode
        "rays": "rays" from each element, a "hemicube" over each, or another method for all pairs of their cells, whose
        number bounds the elements; the classic mode always has hemicubes
    """

    elements: int = 8000
    element_size: float | None = None
    rays_per_element: int = 256
    light_points: int = 32
    light_samples: int = 1024
    gather_samples: int = 2048
    more_for_few: bool = False
    lookup: Lookup = 1
    replicates: int = 8
    accuracy: float | None = None
    time: float | None = None
    audit: bool = False
    occlusion: bool | None = None
    interreflection: bool | None = None
    glow: bool | None = None
    refinement: bool | None = None
    pictures: bool = False
    full_metrics: bool = False
    tolerance: float = 1e-3
    solver: SolverName = "cg"
    blocks: int = 4
    reduced_basis: bool = True
    seed: int = 0
    mode: Mode = "rays"
    links: LinkKind = "rows"
    link_form_factor: float = 0.02
    hemicube_resolution: int = 256
    form_factors: FormFactorName = "rays"

    @classmethod
    def of_quality(cls, quality: Quality, **changes: Any) -> Options:
        """The settings of a quality, with some of them changed; samples that are said are meant, however few read."""
        preset: dict[str, Any] = dict(QUALITIES[quality]) | {"more_for_few": "gather_samples" not in changes}
        return cls(**(preset | changes))

    def __post_init__(self) -> None:
        if self.element_size is not None and not 0.0 < self.element_size < float("inf"):
            raise ValueError(f"element_size must be > 0 m, is {self.element_size}")
        if not 0 <= self.seed < 2**32:
            raise ValueError(f"seed must lie between 0 and {2**32 - 1}, is {self.seed}")
        least = {"elements": 1, "rays_per_element": 16, "light_points": 1, "light_samples": 1, "replicates": 2}
        for name, lowest in least.items():
            if getattr(self, name) < lowest:
                raise ValueError(f"{name} must be at least {lowest}, is {getattr(self, name)}")
        if self.gather_samples < self.replicates:
            raise ValueError(f"gather_samples must be at least the {self.replicates} replicates")
        if self.lookup not in get_args(Lookup):
            raise ValueError(f"lookup must be 1, 2 or 3, is {self.lookup}")
        for name in ("accuracy", "time"):
            value = getattr(self, name)
            if value is not None and not value > 0.0:
                raise ValueError(f"{name} must be > 0, is {value}")
        if not 0.0 < self.tolerance < 1.0:
            raise ValueError(f"tolerance must lie between 0 and 1, is {self.tolerance}")
        if self.solver not in get_args(SolverName):
            raise ValueError(f"solver must be one of {', '.join(get_args(SolverName))}, is {self.solver!r}")
        if self.mode == "classic" and self.solver not in ("cg", "southwell"):
            raise ValueError(f"solver must be southwell in the classic mode, is {self.solver!r}")
        if self.blocks < 1:
            raise ValueError(f"blocks must be at least 1, is {self.blocks}")
        if self.mode not in get_args(Mode):
            raise ValueError(f"mode must be one of {', '.join(get_args(Mode))}, is {self.mode!r}")
        if self.links not in get_args(LinkKind):
            raise ValueError(f"links must be one of {', '.join(get_args(LinkKind))}, is {self.links!r}")
        if self.mode == "classic" and self.links != "rows":
            raise ValueError(f"links must be rows in the classic mode, is {self.links!r}")
        if not 0.0 < self.link_form_factor < 1.0:
            raise ValueError(f"link_form_factor must lie between 0 and 1, is {self.link_form_factor}")
        if self.form_factors not in get_args(FormFactorName):
            names = ", ".join(get_args(FormFactorName))
            raise ValueError(f"form_factors must be one of {names}, is {self.form_factors!r}")
        if self.mode == "classic" and self.form_factors not in ("rays", "hemicube"):
            raise ValueError(f"form_factors must be hemicube in the classic mode, is {self.form_factors!r}")
        if self.links != "rows" and self.form_factors != "rays":
            raise ValueError(f"links must be rows with form_factors of {self.form_factors!r}, is {self.links!r}")
        if self.hemicube_resolution < 8 or self.hemicube_resolution % 2:
            raise ValueError(f"hemicube_resolution must be even and at least 8, is {self.hemicube_resolution}")

"""Arguments that several verbs share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from hradiosity.cli.values import Switch, seconds, share
from hradiosity.errors import Fault, SceneError
from hradiosity.options import FormFactorName, LinkKind, Mode, Options, Quality, SolverName

EFFORT = Group("Accuracy and effort", sort_key=1)
EFFECTS = Group("What is computed", sort_key=2)
OUTPUT = Group("Output", sort_key=3)

OVER_QUALITY = (
    *("replicates", "elements", "rays_per_element", "light_points"),
    *("gather_samples", "light_samples", "lookup"),
)
"""Settings that the quality chooses unless they are given."""


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings of a run, as written on the command line.

    Parameters
    ----------
    quality
        Starting point for the settings below: draft, normal or fine; normal if left out, draft where an accuracy or a
        time is asked for. image: normal, and pictures are images: light computed in every pixel, with its noise.
    accuracy
        Like 1%: go on until half the 95 % interval of every reading is below this share of its value, or of 5 % of its
        sensor's mean for darker ones; elements and samples grow as needed.
    time
        Like 30s or 2min: the narrowest intervals that can be had in this time; elements and samples grow to fill it.
    replicates
        Independent runs whose spread gives the intervals, at least 2.
    seed
        Of all random numbers: the same seed gives the same bits.
    elements
        Elements that light is exchanged between, about.
    element_size
        Edge of an element in metres, instead.
    rays_per_element
        Exchange rays from each element, all replicates together; fewer where elements are many times those asked for.
    light_points
        Points on each element from which a shadow ray goes to each lamp, all replicates together.
    gather_samples
        Paths from each reading, all replicates together.
    light_samples
        Shadow rays from each reading to each lamp, all replicates together.
    lookup
        First hit of a path, 1, 2 or 3, at which the solution may be looked up.
    occlusion
        Whether surfaces cast shadows.
    interreflection
        Whether reflected light is computed.
    glow
        Whether lamps are left to the rays that meet them, without shadow rays; auto: where they are weak or even.
    refinement
        Whether elements are split where one value for each makes readings wrong; auto: if by 0.3 %, on: by 0.03 %.
    mode
        How light is exchanged: rays, or classic for hemicubes, shooting and adaptive subdivision.
    hemicube_resolution
        Pixels along an edge of a hemicube's top face, in the classic mode and for form factors by hemicube; even.
    form_factors
        What the exchange between elements is made of: rays from each element, a hemicube over each, or, for all pairs
        of their cells, point, point-disk, hemisphere, quasi-hemisphere, monte-carlo, contour, or auto for the cheapest
        that is good to 0.1 %. The classic mode always has hemicubes.
    links
        How elements exchange light in the mode of rays: over rows of rays from each element, or hierarchical links
        between coarser and finer parts of patches.
    link_form_factor
        Largest form factor of a hierarchical link.
    solver
        What solves for the light on the surfaces: conjugate gradients (cg), progressive shooting (southwell), the same
        with overshooting, jacobi, gauss-seidel; gaussian-elimination and block-inversion for small scenes; or auto,
        which shoots first and finishes with cg. The classic mode always shoots.
    blocks
        Along each edge of the matrix, for block-inversion.
    device
        Number from `hradiosity devices`, or a part of the device's name.
    """

    quality: Annotated[Quality | Literal["image"] | None, Parameter(group=EFFORT)] = None
    accuracy: Annotated[float | None, Parameter(converter=share, group=EFFORT)] = None
    time: Annotated[float | None, Parameter(converter=seconds, group=EFFORT)] = None
    replicates: Annotated[int | None, Parameter(group=EFFORT)] = None
    seed: Annotated[int, Parameter(group=EFFORT)] = Options.seed
    elements: Annotated[int | None, Parameter(group=EFFORT)] = None
    element_size: Annotated[float | None, Parameter(group=EFFORT)] = None
    rays_per_element: Annotated[int | None, Parameter(group=EFFORT)] = None
    light_points: Annotated[int | None, Parameter(group=EFFORT)] = None
    gather_samples: Annotated[int | None, Parameter(group=EFFORT)] = None
    light_samples: Annotated[int | None, Parameter(group=EFFORT)] = None
    lookup: Annotated[int | None, Parameter(group=EFFORT)] = None
    occlusion: Annotated[Switch, Parameter(group=EFFECTS)] = Switch.auto
    interreflection: Annotated[Switch, Parameter(group=EFFECTS)] = Switch.auto
    glow: Annotated[Switch, Parameter(group=EFFECTS)] = Switch.auto
    refinement: Annotated[Switch, Parameter(group=EFFECTS)] = Switch.auto
    mode: Annotated[Mode, Parameter(group=EFFECTS)] = Options.mode
    hemicube_resolution: Annotated[int, Parameter(group=EFFECTS)] = Options.hemicube_resolution
    form_factors: Annotated[FormFactorName, Parameter(group=EFFECTS)] = Options.form_factors
    links: Annotated[LinkKind, Parameter(group=EFFECTS)] = Options.links
    link_form_factor: Annotated[float, Parameter(group=EFFORT)] = Options.link_form_factor
    solver: Annotated[SolverName, Parameter(group=EFFECTS)] = Options.solver
    blocks: Annotated[int, Parameter(group=EFFECTS)] = Options.blocks
    device: str | None = None

    def options(self) -> Options:
        """As the solver takes them.

        Raises
        ------
        SceneError
            When a value is out of range.
        """
        given = {name: getattr(self, name) for name in OVER_QUALITY if getattr(self, name) is not None}
        try:
            return Options.of_quality(
                "normal"
                if self.quality == "image"
                else self.quality or ("normal" if self.accuracy is None and self.time is None else "draft"),
                **given,
                element_size=self.element_size,
                accuracy=self.accuracy,
                time=self.time,
                occlusion=self.occlusion.forced,
                interreflection=self.interreflection.forced,
                glow=self.glow.forced,
                refinement=self.refinement.forced,
                seed=self.seed,
                mode=self.mode,
                hemicube_resolution=self.hemicube_resolution,
                form_factors=self.form_factors,
                links=self.links,
                link_form_factor=self.link_form_factor,
                solver=self.solver,
                blocks=self.blocks,
            )
        except ValueError as error:
            raise SceneError([Fault("command line", "", str(error).replace("_", "-"), "")]) from error

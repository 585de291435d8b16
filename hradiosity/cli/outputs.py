"""Arguments of ``hradiosity render`` about what is written and shown."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from cyclopts import Parameter

from hradiosity.cli.settings import OUTPUT
from hradiosity.cli.values import FalseColor, FalseColorScale, White
from hradiosity.errors import Fault, SceneError


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Outputs:
    """What a run writes and shows, as written on the command line.

    Parameters
    ----------
    resume
        Go on from an interrupted run, or from the result in the folder.
    pictures
        Draw the views of the scene.
    view
        Open a window that shows the light as it is found; the run does not depend on it, and goes on when it is closed.
    white
        What pictures show as white: as-measured, the display's own white, so that warm light looks warm; or lamps,
        the mean light of the scene's lamps, as to an eye that has got used to it.
    false_color
        What false colours stand for: illuminance or luminance.
    false_color_scale
        Linear, or log for equal ratios in equal steps, which shows dark rooms beside bright ones.
    false_color_range
        Lowest and highest number of the false colours, in lx or cd/m²; from the pictures if left out, logarithmic
        ones then over three decades at most.
    sensitivity
        Write sensitivity.csv: what reflectances, lamps and the sky change, which intervals do not cover.
    interval_parts
        In readings.csv, tell what the intervals are made of: sampling, mesh, iteration, spectral, precision.
    full_metrics
        In readings.csv, R1 to R14, Rf and Rg too.
    quiet
        Show nothing but errors.
    json
        One JSON object a line on standard output in place of words.
    """

    resume: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    pictures: Annotated[bool, Parameter(negative="--no-pictures", group=OUTPUT)] = True
    view: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    white: Annotated[White, Parameter(group=OUTPUT)] = White.as_measured
    false_color: Annotated[FalseColor, Parameter(group=OUTPUT)] = "illuminance"
    false_color_scale: Annotated[FalseColorScale, Parameter(group=OUTPUT)] = "linear"
    false_color_range: Annotated[tuple[float, float] | None, Parameter(negative="", group=OUTPUT)] = None
    sensitivity: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    interval_parts: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    full_metrics: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    quiet: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False
    json: Annotated[bool, Parameter(negative="", show_default=False, group=OUTPUT)] = False

    def check(self) -> None:
        """Raise `SceneError` when the range of the false colours is none."""
        if self.false_color_range is None:
            return
        low, high = self.false_color_range
        is_log = self.false_color_scale == "log"
        if not (math.isfinite(low) and math.isfinite(high) and low < high and (low > 0.0 or not is_log)):
            wanted = "the lower number first" + (", and above 0 for a logarithmic scale" if is_log else "")
            found = f"false-color-range {low:g} {high:g} is no range"
            raise SceneError([Fault("command line", "", found, wanted)])

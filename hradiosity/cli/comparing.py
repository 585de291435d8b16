"""Variants of a scene in words."""

from __future__ import annotations

from hradiosity.cli.text import aligned, plus_minus
from hradiosity.solution import Solution

DIFFERENCES_TITLE = "Differences of the variants from the scene, with 95 % intervals of their own"


def variant_lines(solution: Solution) -> list[str]:
    """A table of mean illuminance and uniformity, a line a variant and sensor: what the variant adds.

    Maintained values have a table of their own, and their difference is the user's own factor.
    """
    from hradiosity.model.variants import MAINTAINED

    rows = [("variant", "sensor", "mean lx", "mean %", "uniformity")]
    shown = {name: variant for name, variant in solution.variants.items() if name != MAINTAINED}
    for name, variant in shown.items():
        for sensor, found in variant.differences.items():
            if variant.readings[sensor].kind == "luminance":
                continue
            numbers = found.numbers
            mean, relative, even = (
                numbers[key] for key in ("mean_illuminance", "relative_mean_illuminance", "uniformity")
            )
            rows.append(
                (
                    name,
                    sensor,
                    plus_minus(float(mean.value), float(mean.half_width)),
                    plus_minus(100.0 * float(relative.value), 100.0 * float(relative.half_width)),
                    plus_minus(float(even.value), float(even.half_width)),
                )
            )
    return aligned(rows) if len(rows) > 1 else []

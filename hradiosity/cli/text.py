"""Results in words and aligned columns."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hradiosity.model.scene import Note
    from hradiosity.model.spectrum import Bands
    from hradiosity.readings.glare import Glare
    from hradiosity.solution import Readings, Solution

TOLD_PART = 5e-5
"""Parts of the intervals below this share of the reading are not told."""
_BLOCKS = "▁▂▃▄▅▆▇█"
ADVICE = {
    "sampling": "more replicates or samples narrow them",
    "mesh": "smaller elements narrow them",
    "iteration": "the solver stopped early; a wanted accuracy makes it go on",
    "spectral": "wavelengths were combined; a wanted accuracy makes it solve them all",
}
"""What narrows intervals whose largest part it is."""


def note_lines(notes: Sequence[Note], *, all_of_them: bool = False) -> list[str]:
    """Warnings in full; the other remarks in full or, since ``run.json`` holds them, only their number."""
    warnings = [f"warning: {note}" for note in notes if note.kind == "warning"]
    others = [f"note: {note}" for note in notes if note.kind != "warning"]
    if others and not all_of_them:
        others = [f"{len(others)} remark{'s' if len(others) > 1 else ''} on what was assumed: see notes in run.json"]
    return warnings + others


def image_lines(record: Mapping[str, Any], cpu_seconds: float) -> list[str]:
    """What images cost and how noisy they are."""
    rows = [("view", "pixels", "samples", "noise (median)", "(95 %)", "ΔE2000 to the display (mean, 95 %)")]
    for entry in record["pictures"]:
        rows.append(
            (
                entry["view"],
                f"{entry['width']} × {entry['height']}",
                str(entry["samples"]),
                percent(entry["noise_median"]),
                percent(entry["noise_95"]),
                f"{entry['delta_e_2000_to_display_mean']:.2f}, {entry['delta_e_2000_to_display_95']:.2f}",
            )
        )
    told = [*aligned(rows), f"  {cpu_seconds:.1f} CPU s; noise is the standard error of a pixel's luminance"]
    asked = record["noise_asked_for"]
    if asked is not None and any(entry["noise_median"] > asked for entry in record["pictures"]):
        told.append(f"warning: a median noise of {percent(asked)} was not reached with the points allowed")
    return told


def sensor_lines(readings: Mapping[str, Readings]) -> list[str]:
    """A table of illuminance, a line a sensor, with half widths of 95 % intervals, and one of luminance, if any is."""
    lines: list[str] = []
    for looks, unit in ((False, "lx"), (True, "cd/m²")):
        some = {name: found for name, found in readings.items() if (found.kind == "luminance") == looks}
        if some:
            lines += _level_lines(some, unit)
    return lines


def _level_lines(readings: Mapping[str, Readings], unit: str) -> list[str]:
    rows: list[tuple[str, ...]] = [
        ("sensor", "readings", f"mean {unit}", f"min {unit}", f"max {unit}", "uniformity", "min/max", "accuracy"),
    ]
    for name, found in readings.items():
        numbers = [found.numbers[f"{level}_illuminance"] for level in ("mean", "lowest", "highest")]
        numbers += [found.numbers[key] for key in ("uniformity", "diversity")]
        label = name if found.kind in ("plane", "luminance") else f"{name} ({found.kind})"
        told = [plus_minus(float(number.value), float(number.half_width)) for number in numbers]
        rows.append((label, str(len(found)), *told, percent(float(found.accuracy.max()))))
    return aligned(rows)


def maintained_lines(solution: Solution) -> list[str]:
    """Mean and lowest maintained illuminance, a line a sensor; none without maintenance factors."""
    from hradiosity.model.variants import MAINTAINED

    kept = solution.variants.get(MAINTAINED)
    if kept is None:
        return []
    rows: list[tuple[str, ...]] = [("sensor", "mean lx", "min lx")]
    for name, found in kept.readings.items():
        if found.kind != "luminance":
            numbers = [found.numbers[f"{level}_illuminance"] for level in ("mean", "lowest")]
            rows.append((name, *(plus_minus(float(n.value), float(n.half_width)) for n in numbers)))
    return aligned(rows)


def glare_lines(glare: Mapping[str, Glare]) -> list[str]:
    """UGR of each observer with its half width, or why there is none."""
    rows = [("observer", "UGR", "background cd/m²", "luminaires", "")]
    for name, found in glare.items():
        for i, reason in enumerate(found.reason):
            number = "–" if reason else plus_minus(float(found.ugr[i]), float(found.half_width[i]))
            sources = str(len(found.sources.of(i)))
            rows.append((f"{name} {i}", number, f"{found.background[i]:.4g}", sources, reason))
    return aligned(rows)


def parts_lines(readings: Mapping[str, Readings]) -> list[str]:
    """What the intervals are made of: the median half width of each part, over the reading, largest first."""
    from hradiosity.solution import interval_shares

    shares = interval_shares(readings)
    shown = sorted((item for item in shares.items() if item[1] >= TOLD_PART), key=lambda item: -item[1])
    if not shown:
        return []
    told = ", ".join(f"{name} {percent(share)}" for name, share in shown)
    return [f"the intervals are made of {told} (medians): {ADVICE.get(shown[0][0], '')}".rstrip(": ")]


def outside_lines(bands: Bands) -> list[str]:
    """What the bands leave out of each number, where that is worth a line."""
    from hradiosity.metrics.truncation import truncation

    told = [f"{item.number} {percent(item.outside)}" for item in truncation(bands) if item.is_worth_telling]
    if not told:
        return []
    return [f"{bands.lower[0]:g} to {bands.upper[-1]:g} nm leave out, of equal-energy light: {'; '.join(told)}"]


def error_curve(points: Sequence[tuple[float, float]], width: int = 40) -> str:
    """Error against time as a line of blocks, on a logarithmic scale from the smallest to the largest.

    Parameters
    ----------
    points : sequence of (seconds, error)
        In the order of time; at least one.
    width : int
        Characters for the whole time from 0.
    """
    end = max(points[-1][0], 1e-9)
    column = [min(width - 1, int(width * seconds / end)) for seconds, _ in points]
    level = [math.log(max(error, 1e-9)) for _, error in points]
    low, high = min(level), max(level)
    text = [" "] * width
    for here, until, value in zip(column, [*column[1:], width], level):
        height = (value - low) / (high - low) if high > low else 0.0
        text[here : max(until, here + 1)] = _BLOCKS[round(height * (len(_BLOCKS) - 1))] * max(until - here, 1)
    return "".join(text[:width])


def time_lines(seconds: Mapping[str, float]) -> list[str]:
    """Where the time went: stage, seconds, share."""
    total = max(sum(seconds.values()), 1e-9)
    rows = [("stage", "seconds", "share")]
    rows += [(stage, f"{spent:.2f}", f"{100 * spent / total:.0f} %") for stage, spent in seconds.items()]
    return aligned([*rows, ("all", f"{total:.2f}", "")])


def account_line(solution: Solution) -> str:
    """Size and effort of a run in one line."""
    record = solution.record
    alone = "1 replicate (intervals need two)"
    replicates = alone if solution.replicates == 1 else f"{solution.replicates} replicates"
    return (
        f"{replicates}, {count(record['elements'])} elements, {count(record['rays'])} rays, "
        f"{record['solve_cpu_s']:.1f} s of solve CPU"
    )


def plus_minus(value: float, half_width: float) -> str:
    """``514.7 ± 3.1``: the interval with two digits, the value as many; a value of unknown interval with four."""
    if not math.isfinite(half_width):
        return f"{value:.4g} ± ?"
    if half_width <= 0.0:
        return f"{value:.4g} ± 0"
    digits = max(0, 1 - math.floor(math.log10(half_width)))
    return f"{value:.{digits}f} ± {half_width:.{digits}f}"


def percent(value: float) -> str:
    """A share as ``1.2 %``; ``?`` when unknown."""
    if not math.isfinite(value):
        return "?"
    return f"{100 * value:.2g} %" if value < 0.995 else f"{100 * value:.0f} %"


def count(number: int) -> str:
    """``1.25 million``, ``10 284``."""
    return f"{number / 1e6:.3g} million" if number >= 1_000_000 else f"{number:,}".replace(",", " ")


def aligned(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Columns under each other: the first to the left, the others to the right."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return [
        "  ".join(cell.ljust(widths[k]) if k == 0 else cell.rjust(widths[k]) for k, cell in enumerate(row)).rstrip()
        for row in rows
    ]

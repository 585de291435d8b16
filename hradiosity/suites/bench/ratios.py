"""Two runs side by side, as ratios."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hradiosity.suites.bench.figure import WORDS, Figure
from hradiosity.suites.bench.report import Report, number

WITHIN = "within the spread"
ONCE = "measured once, no verdict"


@dataclass(frozen=True)
class Ratio:
    """A figure in both runs.

    ratio : later over earlier; 1 if both are 0
    verdict : a word of `WORDS` where the ranges of the repeats do not touch, else `WITHIN` or `ONCE`
    """

    name: str
    unit: str
    old: float
    new: float
    ratio: float
    verdict: str


def compare_figures(old: Figure, new: Figure) -> Ratio:
    """Of one name and unit.

    Raises
    ------
    ValueError
        When name or unit differ.
    """
    if (old.name, old.unit) != (new.name, new.unit):
        raise ValueError(f"{old.name} [{old.unit}] and {new.name} [{new.unit}] are not the same figure")
    ratio = 1.0 if old.value == new.value else new.value / old.value if old.value else math.inf
    return Ratio(old.name, old.unit, old.value, new.value, ratio, _verdict(old, new))


def _verdict(old: Figure, new: Figure) -> str:
    if old.spread is None or new.spread is None:
        return ONCE
    if abs(new.value - old.value) <= old.spread + new.spread:
        return WITHIN
    return WORDS[new.unit][new.value > old.value]


def compare_reports(old: Report, new: Report) -> list[Ratio]:
    """Figures that both runs have, in the order of the later one."""
    earlier = {(f.name, f.unit): f for f in old.figures}
    return [compare_figures(earlier[f.name, f.unit], f) for f in new.figures if (f.name, f.unit) in earlier]


def differences(old: Report, new: Report) -> list[str]:
    """What besides the figures is not the same, a line each: ratios may come from that."""
    lines = []
    for name in sorted(old.machine.keys() | new.machine.keys()):
        lines += _difference(name, old.machine.get(name), new.machine.get(name))
    lines += _difference("device", old.device, new.device)
    for name in sorted(old.versions.keys() | new.versions.keys()):
        lines += _difference(name, old.versions.get(name), new.versions.get(name))
    lines += _difference("quick", str(old.quick), str(new.quick))
    for have, lack, which in ((old, new, "old"), (new, old, "new")):
        only = {f"{f.name} [{f.unit}]" for f in have.figures} - {f"{f.name} [{f.unit}]" for f in lack.figures}
        lines += [f"only in the {which} run: {', '.join(sorted(only))}"] if only else []
    return lines


def _difference(name: str, old: str | None, new: str | None) -> list[str]:
    return [] if old == new else [f"{name}: {old or 'none'} → {new or 'none'}"]


def table(ratios: list[Ratio]) -> str:
    """A line a figure."""
    width = max((len(r.name) for r in ratios), default=0)
    head = f"{'':{width}}  {'old':>9} {'new':>9}  {'unit':14} {'new/old':>8}  verdict"
    lines = [
        f"{r.name:{width}}  {number(r.old):>9} {number(r.new):>9}  {r.unit:14} {r.ratio:8.3f}  {r.verdict}"
        for r in ratios
    ]
    return "\n".join([head, *lines])

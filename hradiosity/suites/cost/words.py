"""The report in words: recommendation and tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from hradiosity.suites.cost.errors import Error
from hradiosity.suites.cost.pareto import Quote, quotes
from hradiosity.suites.cost.pricing import costs_and_errors
from hradiosity.suites.cost.values import BandsPrice, Price, Report, Skipped

Rows = list[tuple[str, ...]]
FEW: Final = ", few elements"
"""At the end of the names of settings that differ in their form factors."""
NONE: Final = "none"
"""In place of a number that no reading has."""
SAME_CCT, SAME_RA, SAME = 25.0, 1.0, 0.01
"""Changes of colour temperatures [K], of Ra, and of powers that are too small to matter."""


def share_text(value: float) -> str:
    """``1 %``, ``0.44 %``, ``12 %``: two digits."""
    return f"{float(f'{100.0 * value:.2g}'):g} %"


def seconds_text(seconds: float) -> str:
    """``0.62 s``, ``3.2 s``, ``94 s``, ``31 min``, ``2.5 h``: two digits or so."""
    if seconds < 99.5:
        return f"{float(f'{seconds:.2g}'):g} s"
    if seconds < 600.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.2g} h"


def recommendation(report: Report) -> list[str]:
    """What each accuracy costs, a sentence each; of the mean error of the illuminances, in CPU seconds."""
    found = report.prices
    cost, error = costs_and_errors(found)
    lines = [_quote_line(one, found) for one in quotes(cost, error)]
    if not lines:
        cheapest = min(found, key=lambda price: price.cpu_seconds, default=None)
        if cheapest is None:
            return ["nothing was measured"]
        below = f"no error stands out from the referee's noise of {share_text(report.noise)}"
        return [f"{below}: `{cheapest.setting.flags}` is enough, {seconds_text(cheapest.cpu_seconds)}"]
    lines += _floor_line(report)
    return [*lines, *_classic_line(found, report.skipped), *_bands_line(report)]


def _quote_line(quote: Quote, found: Sequence[Price]) -> str:
    """One accuracy."""
    start = f"{share_text(quote.target)} costs"
    if quote.kind == "extrapolated":
        how = "extrapolated, as if the error fell with the root of the time"
        return f"{start} some {seconds_text(quote.seconds)}: not reached in the budget, {how}"
    setting = found[quote.setting if quote.setting is not None else 0]
    word = "at most" if quote.kind == "at most" else "about"
    reached = f"{share_text(setting.illuminance.rms)} in {seconds_text(setting.cpu_seconds)}"
    return f"{start} {word} {seconds_text(quote.seconds)}: `{setting.setting.flags}` reached {reached}"


def _floor_line(report: Report) -> list[str]:
    """The cheapest setting whose error the referee can't see, if there is one."""
    hidden = [price for price in report.prices if price.illuminance.below_floor]
    if not hidden:
        return []
    best = min(hidden, key=lambda price: price.cpu_seconds)
    noise = share_text(report.noise)
    return [f"below {noise}, the referee's own noise: `{best.setting.flags}`, {seconds_text(best.cpu_seconds)}"]


def _bands_line(report: Report) -> list[str]:
    """The fewest bands that serve colour and the eye like the most, if any fewer do."""
    if len(report.bands) < 2:
        return []
    most = report.bands[-1]
    enough = [b for b in report.bands[:-1] if _serves(b)]
    if not enough:
        return [f"no fewer bands than {most.bands} keep colour and the eye: see the table of bands"]
    few = enough[0]
    known = [
        f"colour temperatures by {_plain(few.cct)} K" if math.isfinite(few.cct) else "",
        f"Ra by {_plain(few.ra)}" if math.isfinite(few.ra) else "",
        f"mean melanopic EDI by {share_text(abs(few.melanopic))}" if math.isfinite(few.melanopic) else "",
        f"mean illuminance by {share_text(abs(few.mean_illuminance))}",
    ]
    seconds = f"{seconds_text(few.cpu_seconds)} against {seconds_text(most.cpu_seconds)} for drafts"
    changes = ", ".join(item for item in known if item)
    return [f"{few.bands} bands serve colour and the eye like {most.bands}: they change {changes} ({seconds})"]


def _serves(price: BandsPrice) -> bool:
    """Whether a change against the most bands is too small to matter; numbers that no reading has don't count."""
    changes = (price.cct / SAME_CCT, price.ra / SAME_RA, price.melanopic / SAME, price.mean_illuminance / SAME)
    return all(abs(change) <= 1.0 for change in changes if math.isfinite(change))


def _classic_line(found: Sequence[Price], skipped: Sequence[Skipped]) -> list[str]:
    """The best resolution of the classic mode, or why there is none."""
    classic = [price for price in found if price.setting.group == "classic"]
    left_out = [item for item in skipped if item.group == "classic" and item.predicted is not None]
    if classic:
        best = min(classic, key=lambda price: price.illuminance.rms)
        pixels = best.setting.options.hemicube_resolution
        reached = f"reaches {share_text(best.illuminance.rms)} at {seconds_text(best.cpu_seconds)}"
        return [f"classic mode with {pixels}² hemicubes {reached}"]
    if left_out:
        least = min(item.predicted for item in left_out if item.predicted is not None)
        why = f"about {seconds_text(least)} was more than was left of its share of the budget"
        return [f"classic mode was not run: {why}"]
    return []


def error_cell(error: Error, value: float | None = None) -> str:
    """A number, or an upper bound."""
    return f"{'< ' if error.below_floor else ''}{share_text(error.rms if value is None else value)}"


def memory_cell(memory: int | None) -> str:
    """MiB."""
    return "" if memory is None else f"{memory / 2**20:.0f}"


def price_rows(found: Sequence[Price]) -> Rows:
    """Settings by rising cost, those on the front marked."""
    head = (
        *("setting", "front", "CPU s", "elements", "MiB", "lx rms", "lx 95 %", "lx max"),
        *("spectral rms", "95 %", "bias", "sampling", "seeds"),
    )
    return [
        head,
        *(
            (
                price.setting.name,
                "*" if price.on_front else "",
                f"{price.cpu_seconds:.3g}",
                str(price.elements),
                memory_cell(price.memory_bytes),
                error_cell(price.illuminance),
                error_cell(price.illuminance, price.illuminance.p95),
                error_cell(price.illuminance, price.illuminance.largest),
                error_cell(price.spectrum),
                error_cell(price.spectrum, price.spectrum.p95),
                _signed(price.bias),
                share_text(price.sampling),
                str(price.seeds),
            )
            for price in found
        ),
    ]


def solver_rows(report: Report) -> Rows:
    """Solvers in the order of their cost."""
    head = ("solver", "elements", "CPU s", "products", "residual")
    return [
        head,
        *(
            (s.name, str(s.elements), f"{s.cpu_seconds:.2g}", f"{s.products:.3g}", f"{s.residual:.1e}")
            for s in sorted(report.solvers, key=lambda s: s.cpu_seconds)
        ),
    ]


def effect_rows(report: Report) -> Rows:
    """Effects that were forced."""
    head = ("forced", "asked for by", "CPU s", "as planned", "change of lx", "noise of the two")
    return [
        head,
        *(
            (
                e.name,
                e.flags,
                f"{e.forced_seconds:.3g}",
                f"{e.usual_seconds:.3g}",
                share_text(e.change) if e.change > 0.0 else "none: as planned",
                share_text(e.sampling) if e.change > 0.0 else "",
            )
            for e in report.effects
        ),
    ]


def bands_rows(report: Report) -> Rows:
    """Numbers of bands."""
    head = ("bands", "columns", "CPU s", "lx rms", "mean lx", "x, y", "CCT, K", "Ra", "mean melanopic EDI")
    return [
        head,
        *(
            (
                str(b.bands),
                str(b.columns),
                f"{b.cpu_seconds:.3g}",
                *(("reference",) * 6 if b is report.bands[-1] else _bands_cells(b)),
            )
            for b in report.bands
        ),
    ]


def _bands_cells(price: BandsPrice) -> tuple[str, ...]:
    """What a number of bands changes."""
    return (
        share_text(price.illuminance),
        _signed(price.mean_illuminance),
        f"{price.chromaticity:.2g}",
        *(_plain(value) for value in (price.cct, price.ra)),
        _signed(price.melanopic) if math.isfinite(price.melanopic) else NONE,
    )


def _plain(value: float) -> str:
    """Two digits; ``none`` where no reading has such a number."""
    return f"{float(f'{value:.2g}'):g}" if math.isfinite(value) else NONE


def skipped_lines(skipped: Sequence[Skipped]) -> list[str]:
    """What was not run, and why, as a list in Markdown: a point a reason, and below it one a group of settings."""
    reasons: dict[str, list[Skipped]] = {}
    for item in skipped:
        reasons.setdefault(item.reason, []).append(item)
    lines = []
    for reason, items in reasons.items():
        timed = any(item.predicted is not None for item in items)
        lines.append(f"* {reason}{' (what they would take)' if timed else ''}:")
        groups = dict.fromkeys(item.group for item in items)
        lines += [f"  * {_group_line(group, [item for item in items if item.group == group])}" for group in groups]
    return lines


def _group_line(group: str, items: Sequence[Skipped]) -> str:
    """The settings of a group, by the seconds that they would take; the group's name is said once."""
    ordered = sorted(items, key=lambda item: item.predicted or 0.0)
    words = [
        item.name.removeprefix(group).strip().removesuffix(FEW)
        + ("" if item.predicted is None else f" ({seconds_text(item.predicted)})")
        for item in ordered
    ]
    few = FEW if any(item.name.endswith(FEW) for item in items) else ""
    return f"{group}{few}: {', '.join(words)}"


def reference_line(report: Report) -> str:
    """What everything was compared with."""
    return (
        f"referee: {report.paths} paths from each of {report.readings} readings, "
        f"{seconds_text(report.reference_cpu_seconds)} of CPU in this run; its noise ({share_text(report.noise)} lx, "
        f"{share_text(report.spectral_noise)} spectra) is taken out"
    )


def markdown(rows: Rows) -> list[str]:
    """A table that is readable as text and as Markdown."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]

    def line(row: Sequence[str]) -> str:
        cells = (cell.ljust(widths[k]) if k == 0 else cell.rjust(widths[k]) for k, cell in enumerate(row))
        return f"| {' | '.join(cells)} |"

    rule = [f"{'-' * max(w - (k > 0), 1)}{':' if k else ''}" for k, w in enumerate(widths)]
    return [line(rows[0]), f"| {' | '.join(rule)} |", *map(line, rows[1:])]


def _signed(value: float) -> str:
    """``+0.12 %``; ``0 %`` for nothing."""
    return share_text(value) if value <= 0.0 or not math.isfinite(value) else f"+{share_text(value)}"

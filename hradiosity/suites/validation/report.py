"""What came of the cases, as a page with curves and tables, and as plain values for JSON."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from hradiosity.errors import OutputError
from hradiosity.io.run_record import versions
from hradiosity.show.charts import ChartPoint, curve_chart
from hradiosity.show.report import Block, Drawing, Folded, Heading, Table, Words, page
from hradiosity.suites.validation.running import SceneBench
from hradiosity.suites.validation.values import CaseResult, NotRun, Outcome, Row

PROVENANCE = (
    "References: not printed figures, but our own recomputation from first principles with 30 digits, graded Gauss "
    "quadrature and a high-order solver of the integral equation; two independent routes agree to 1e-11 or better for "
    "every form factor. Printed figures of CIE 171:2006 were used only to check that the geometry was read aright.",
    "Known to be wrong in print, and not followed here: table 19 (case 5.7) was computed for another geometry; the "
    "formula of 5.8 is the mean over the faces and not the value at a point; 5.9: walls of sky type 3 stand in reverse "
    "order, and some points with the 4 m × 4 m opening are misprinted; 5.11: several edge points with the 4 m × 3 m "
    "opening are off by 2 to 6 %.",
)
HEAD = ("point", "ours", "reference", "deviation", "half width", "bar", "")


def outcome_of(results: Sequence[CaseResult], not_run: Sequence[NotRun], bench: SceneBench, seconds: float) -> Outcome:
    """All results together, with what they were computed with."""
    about = {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "device": bench.device.description,
        "settings": f"quality {bench.quality}" if bench.quality else "each case's own",
        "wall time": f"{seconds:.0f} s",
        **versions(),
    }
    return Outcome(tuple(results), tuple(not_run), seconds, about)


def write_report(outcome: Outcome, path: Path) -> None:
    """Write the page.

    Raises
    ------
    OutputError
        When the file cannot be written.
    """
    try:
        path.write_text(page("hradiosity against known answers", _blocks(outcome)), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: the report cannot be written: {error.strerror}") from error


def as_json(outcome: Outcome) -> dict[str, Any]:
    """Plain values: verdicts, rows, what was not run, versions."""
    return {
        "passed": outcome.passed,
        "seconds": outcome.seconds,
        "about": dict(outcome.about),
        "cases": [
            {
                "name": result.case.name,
                "title": result.case.title,
                "group": result.case.group,
                "quantity": result.case.quantity,
                "unit": result.case.unit,
                "passed": result.passed,
                "seconds": result.seconds,
                "settings": result.settings,
                "points": [{**asdict(row), "deviation": row.deviation, "passed": row.passed} for row in result.rows],
            }
            for result in outcome.results
        ],
        "not_run": [asdict(item) for item in outcome.not_run],
    }


def number_text(value: float) -> str:
    """Seven digits."""
    return f"{value:.7g}"


def share_text(share: float, *, signed: bool = False) -> str:
    """A share in percent with two digits: ``0.012 %``, ``-1.3e-05 %``."""
    return f"{100.0 * share:{'+' if signed else ''}.2g} %"


def cells(row: Row) -> tuple[str, ...]:
    """A line of a case's table."""
    return (
        row.point,
        number_text(row.value),
        number_text(row.reference),
        share_text(row.deviation, signed=True),
        "" if row.relative_half_width is None else share_text(row.relative_half_width),
        share_text(row.tolerance),
        "pass" if row.passed else "FAIL",
    )


def _blocks(outcome: Outcome) -> list[Block]:
    points = sum(len(result.rows) for result in outcome.results)
    failed = [result.case.name for result in outcome.results if not result.passed]
    verdict = f"Outside their bars: {', '.join(failed)}." if failed else "All within their bars."
    blocks: list[Block] = [
        Words(f"{len(outcome.results)} cases, {points} points. {verdict}", "bad" if failed else "good"),
        Words(
            "Each case is a scene in the program's own format, solved as any other scene. Half widths are those of "
            "95 % intervals, relative to the reference; means over surfaces have none. Where a reference is 0, the "
            "deviation is over the mean of the case's references."
        ),
        _summary(outcome),
    ]
    if outcome.not_run:
        rows = tuple((item.name, item.reason) for item in outcome.not_run)
        blocks += [Heading("Not run"), Table(("case", "why"), rows)]
    blocks += [Heading("Where the references are from"), *(Words(text) for text in PROVENANCE)]
    blocks += [Heading("Computed with"), Table(("", ""), tuple(outcome.about.items()))]
    group = ""
    for result in outcome.results:
        if result.case.group != group:
            group = result.case.group
            blocks.append(Heading(group))
        blocks += _case(result)
    return blocks


def summary_cells(result: CaseResult) -> tuple[str, ...]:
    """A case in one row: name, points, worst deviation and where, its bar, seconds, verdict."""
    worst = result.worst
    return (
        result.case.name,
        str(len(result.rows)),
        share_text(worst.deviation, signed=True),
        worst.point,
        share_text(worst.tolerance),
        f"{result.seconds:.1f}",
        "pass" if result.passed else "FAIL",
    )


def _summary(outcome: Outcome) -> Table:
    return Table(
        ("case", "points", "worst deviation", "at", "bar", "seconds", ""),
        tuple(map(summary_cells, outcome.results)),
        frozenset(k for k, result in enumerate(outcome.results) if not result.passed),
        tuple(result.case.name for result in outcome.results),
    )


def _case(result: CaseResult) -> list[Block]:
    case = result.case
    label = case.quantity if case.unit == "1" else f"{case.quantity} [{case.unit}]"
    points = [
        ChartPoint(r.point, r.value, r.reference, r.deviation, r.relative_half_width, r.tolerance, known.curve)
        for r, known in zip(result.rows, case.points)
    ]
    table = Table(HEAD, tuple(map(cells, result.rows)), frozenset(k for k, r in enumerate(result.rows) if not r.passed))
    blocks: list[Block] = [Heading(f"{case.name}: {case.title}", 3, case.name)]
    if case.note:
        blocks.append(Words(case.note))
    if result.settings:
        blocks.append(Words(f"Solved with: {'; '.join(result.settings)}. {result.seconds:.1f} s.", "small"))
    return [
        *blocks,
        Drawing(curve_chart(f"{case.name}: {case.title}", label, points)),
        Folded("all points", table, opened=not result.passed),
    ]

"""``hradiosity validate``."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from hradiosity.cli import FAILED, GOOD
from hradiosity.options import Quality

if TYPE_CHECKING:
    from hradiosity.suites.validation.values import CaseResult, NotRun, Outcome


def validate(
    *,
    case: Annotated[list[str] | None, Parameter(negative="")] = None,
    list: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    quality: Quality | None = None,
    report: Path | None = None,
    device: str | None = None,
    json: Annotated[bool, Parameter(negative="", show_default=False)] = False,
) -> int:
    """Compare the program with published cases, closed forms and a catalogue of form factors.

    Each case is a scene in the program's own format, solved as any other scene.

    Exit status: 0 all within their bars, 1 some not, 2 bad input.

    Parameters
    ----------
    case
        Only this case, all whose names begin with this word (5.7), or all that fit a pattern (cube-*); may be repeated.
    list
        Name the cases and do nothing.
    quality
        Solve with the settings of draft, normal or fine in place of each case's own; bars stay.
    report
        HTML file for curves and tables.
    device
        Number from `hradiosity devices`, or a part of the device's name.
    json
        One JSON object on standard output in place of words.
    """
    from hradiosity.device import Device
    from hradiosity.io.run_record import to_json
    from hradiosity.suites.validation.catalogue import chosen
    from hradiosity.suites.validation.report import as_json, outcome_of, write_report
    from hradiosity.suites.validation.running import SceneBench, run

    cases, not_run = chosen(case or ())
    if list:
        for line in (*(f"{c.name}: {c.title}" for c in cases), *(f"{n.name}: not run: {n.reason}" for n in not_run)):
            print(line)
        return GOOD
    start = time.perf_counter()
    bench = SceneBench(Device(device), quality)
    results = []
    for number, result in enumerate(run(cases, bench), 1):
        results.append(result)
        if json:
            sys.stderr.write(f"{number}/{len(cases)} {result.case.name}: {_verdict(result.passed)}\n")
        else:
            _print_case(result, number, len(cases))
    outcome = outcome_of(results, not_run, bench, time.perf_counter() - start)
    if json:
        print(to_json(as_json(outcome)))
    else:
        _print_summary(outcome)
    if report:
        write_report(outcome, report)
        sys.stderr.write(f"report: {report}\n")
    return GOOD if outcome.passed else FAILED


def _print_case(result: CaseResult, number: int, count: int) -> None:
    """Heading and a line a point."""
    from hradiosity.cli.text import aligned
    from hradiosity.suites.validation.report import HEAD, cells

    case = result.case
    unit = "" if case.unit == "1" else f" [{case.unit}]"
    print(f"\n{case.name} ({number} of {count}, {result.seconds:.1f} s): {case.title}; {case.quantity}{unit}")
    for line in aligned([HEAD, *map(cells, result.rows)]):
        print(f"  {line}", flush=True)


def _print_summary(outcome: Outcome) -> None:
    """A line a case, what was not run, and the verdict."""
    from hradiosity.cli.text import aligned
    from hradiosity.suites.validation.report import summary_cells

    rows = [("case", "points", "worst", "at", "bar", "seconds", ""), *map(summary_cells, outcome.results)]
    print()
    for line in (*aligned(rows), *_not_run_lines(outcome.not_run)):
        print(line)
    failed = [result.case.name for result in outcome.results if not result.passed]
    points = sum(len(result.rows) for result in outcome.results)
    print(f"\n{len(outcome.results)} cases, {points} points in {outcome.seconds:.0f} s on {outcome.about['device']}")
    print(f"outside their bars: {', '.join(failed)}" if failed else "all within their bars")


def _not_run_lines(not_run: Sequence[NotRun]) -> list[str]:
    """Names by reason, a line each."""
    by_reason: dict[str, list[str]] = {}
    for item in not_run:
        by_reason.setdefault(item.reason, []).append(item.name)
    return [f"not run: {', '.join(names)}: {reason}" for reason, names in by_reason.items()]


def _verdict(passed: bool) -> str:
    return "pass" if passed else "FAIL"

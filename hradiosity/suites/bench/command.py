"""The command line of the benchmarks."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from hradiosity.suites.bench import ratios, report
from hradiosity.suites.bench.figure import Figure
from hradiosity.suites.bench.sections import SECTIONS, choose, measure


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, or compare two kept runs.

    Returns
    -------
    int
        Exit status: 0, or 2 for names or files that can't be used.
    """
    options = _parser().parse_args(arguments)
    try:
        if options.compare:
            _compare(*options.compare)
        else:
            _measure(choose(options.only), quick=options.quick, out=options.out)
    except (ValueError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


def _measure(names: Sequence[str], *, quick: bool, out: Path | None) -> None:
    if out is not None and not out.parent.is_dir():
        raise ValueError(f"{out.parent} is no folder")
    from hradiosity.device import Device
    from hradiosity.suites.bench.session import Session

    session = Session(Device(), quick)
    figures: list[Figure] = []
    for name in names:
        print(f"measuring {name} …", file=sys.stderr, flush=True)
        figures += measure(name, session)
        found = report.make_report(figures, session.notes, device=session.device.description, quick=quick)
        if out is not None:  # after each section, since an interruption should not cost the earlier ones
            out.write_text(report.to_json(found), encoding="utf-8")
    print(f"{found.machine['processor']}, {found.machine['cores']} cores; {found.device}")
    print(report.table(found))


def _compare(old_file: Path, new_file: Path) -> None:
    old, new = _load(old_file), _load(new_file)
    print("\n".join([*ratios.differences(old, new), ratios.table(ratios.compare_reports(old, new))]))


def _load(path: Path) -> report.Report:
    try:
        return report.from_json(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m hradiosity.bench", description="Measure speed and accuracy.")
    parser.add_argument("--only", metavar="NAMES", help=f"of {','.join(SECTIONS)}")
    parser.add_argument("--quick", action="store_true", help="fewer repeats and smaller cases: under two minutes")
    parser.add_argument("--out", type=Path, metavar="FILE", help="keep the figures as JSON")
    parser.add_argument("--compare", type=Path, nargs=2, metavar=("OLD", "NEW"), help="ratios of two kept runs")
    return parser

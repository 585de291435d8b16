"""The command line of the coverage of intervals."""

from __future__ import annotations

import argparse
import ast
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hradiosity.io.cache import cache_folder
from hradiosity.options import QUALITIES, Options
from hradiosity.suites.coverage.scenes import choose


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables.

    Returns
    -------
    int
        Exit status: 0, or 2 for names or values that can't be used.
    """
    chosen = _parser().parse_args(arguments)
    try:
        options = Options.of_quality(chosen.quality, **dict(_setting(text) for text in chosen.set))
        scenes = choose(chosen.scenes)
        _run(chosen, options, scenes)
    except (ValueError, TypeError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


def _run(chosen: argparse.Namespace, options: Options, scenes: Sequence[Any]) -> None:
    from hradiosity.device import Device
    from hradiosity.suites.coverage import report
    from hradiosity.suites.coverage.measure import measure_all
    from hradiosity.suites.coverage.weight import weight_table

    seeds = range(chosen.first_seed, chosen.first_seed + chosen.seeds)
    found = []
    for scene in measure_all(scenes, options, seeds, Device(), chosen.cache):
        found.append(scene)
        sys.stderr.write(f"{scene.wanted.name}: {scene.cpu_seconds:.1f} CPU s a seed\n")
        if chosen.json:
            chosen.json.write_text(json.dumps(report.as_json(found), indent=2) + "\n", encoding="utf-8")
    print(report.table(found))
    for scene in found if chosen.worst else []:
        print(f"\n{report.worst_table(scene, chosen.worst)}")
    if chosen.fit_weight:
        print(f"\n{weight_table(found)}")


def _setting(text: str) -> tuple[str, Any]:
    """An option by its name in `Options`; what is no Python value is a word."""
    name, _, value = text.partition("=")
    try:
        return name, ast.literal_eval(value)
    except (ValueError, SyntaxError):
        return name, value


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m hradiosity.suites.coverage", description="How often intervals hold the true value."
    )
    parser.add_argument("--scenes", metavar="NAMES", help=f"of {','.join(scene.name for scene in choose(None))}")
    parser.add_argument("--seeds", type=int, default=6, help="runs of each scene (6)")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--quality", choices=list(QUALITIES), default="draft")
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="an option of the run, as Options names it"
    )
    parser.add_argument(
        "--cache", type=Path, default=cache_folder() / "coverage", help="folder that keeps unbiased readings"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there as well")
    parser.add_argument(
        "--worst", type=int, default=0, metavar="N", help="list N readings of each scene that fail most"
    )
    parser.add_argument("--fit-weight", action="store_true", help="coverage by weight of the mesh term")
    return parser

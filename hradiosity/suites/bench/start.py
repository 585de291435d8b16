"""How long it takes from the command to its first answer, in processes of their own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from hradiosity.suites.bench.figure import CPU, WALL, Figure, figure_of
from hradiosity.suites.bench.scenes import scene_file
from hradiosity.suites.bench.session import Session


def measure(session: Session) -> list[Figure]:
    """``--help``, import, and the first pictures of the Cornell box, all with kernels that were built before."""
    commands = {"--help": ("-m", "hradiosity", "--help"), "import hradiosity": ("-c", "import hradiosity")}
    figures: list[Figure] = []
    for name, command in commands.items():
        spent = _durations(command, session.turns)
        figures.append(figure_of(f"start: {name}", [cpu for cpu, _ in spent], CPU))
        figures.append(figure_of(f"start: {name}", [wall for _, wall in spent], WALL))
    scene = scene_file(session, "cornell_box")
    return figures if scene is None else figures + _first_pictures(scene, session.turns)


def _durations(command: Sequence[str], turns: int) -> list[tuple[float, float]]:
    """CPU and wall seconds of each turn, after one that is not counted."""
    _output(command)
    durations = []
    for _ in range(turns):
        before, begun = os.times(), time.perf_counter()
        _output(command)
        after, ended = os.times(), time.perf_counter()
        cpu = after.children_user - before.children_user + after.children_system - before.children_system
        durations.append((cpu, ended - begun))
    return durations


def _first_pictures(scene: Path, turns: int) -> list[Figure]:
    """Wall seconds from the start of the process until each picture is written."""
    found: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "preview.png"
        command = ("-m", "hradiosity.suites.bench.first_picture", str(scene), str(picture))
        _output(command)
        for _ in range(turns):
            begun = time.time()
            for name, moment in json.loads(_output(command)).items():
                found.setdefault(name, []).append(moment - begun)
    return [figure_of(f"start: first picture, {name}", repeats, WALL) for name, repeats in found.items()]


def _output(arguments: Sequence[str]) -> str:
    """What a new interpreter prints.

    Raises
    ------
    subprocess.CalledProcessError
        When it fails.
    """
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=True).stdout

"""The audit of the intervals after the solution, and what it found in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hradiosity.cli.display import Display
from hradiosity.cli.text import count, percent
from hradiosity.device import Device
from hradiosity.errors import DeviceError
from hradiosity.model.scene import Scene
from hradiosity.radiosity.auditing import Auditor, audited, missed_by_factor, no_audit_because, not_audited
from hradiosity.solution import Solution


def run_audit(scene: Scene, solution: Solution, device: Device, display: Display) -> tuple[Solution, bool]:
    """The solution with its intervals audited, or with the reason why not; and whether that was interrupted."""
    reason = no_audit_because(solution)
    if reason is not None:
        return not_audited(solution, reason), False
    auditor = Auditor(scene, solution, device)
    try:
        display.stage("auditing the intervals by unbiased paths")
        for state in auditor.states():
            display.stage(f"auditing {state.readings} readings: {count(state.paths)} unbiased paths from each")
    except KeyboardInterrupt:
        return not_audited(solution, "interrupted"), True
    except (DeviceError, MemoryError) as error:
        return not_audited(solution, str(error) or "out of memory"), False
    return audited(solution, auditor.audit()), False


def audit_lines(record: Mapping[str, Any]) -> list[str]:
    """What came of the audit, from the solution's record."""
    found = record.get("audit")
    if found is None:
        return []
    if "skipped" in found:
        return [f"not audited: {found['skipped']}"]
    readings, factor, dull = found["readings"], found["factor"], found["readings"] - found["sharp"]
    outcome = "intervals hold" if 2 * dull <= readings else "nothing speaks against the intervals"
    outcome += ", factor 1.0"
    if factor > 1.0:
        outcome = f"intervals were too narrow, all half widths were multiplied by {factor:.2f}"
    bias = f"{percent(abs(found['bias']))} too {'bright' if found['bias'] > 0.0 else 'dark'}"
    noise = f"; for {dull} of them the paths are noisier than the half width" if dull else ""
    return [
        f"audited {readings} readings by unbiased paths: {outcome}",
        f"all together they are {bias}, ± {percent(found['bias_half_width'])}{noise}",
    ]


def missed_accuracy_lines(solution: Solution) -> list[str]:
    """What to do where the audit's factor alone keeps the readings from the accuracy that was asked for."""
    worst = missed_by_factor(solution)
    if worst is None:
        return []
    wanted, factor = solution.record["options"]["accuracy"], solution.record["audit"]["factor"]
    return [
        f"warning: with the audit's factor the worst reading is accurate to {percent(worst)}, {percent(wanted)} were "
        f"asked for; to go on: the same command with --resume --accuracy {100 * wanted / factor:.3g}%"
    ]

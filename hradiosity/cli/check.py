"""``hradiosity check``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from hradiosity.cli import BAD_INPUT, GOOD
from hradiosity.errors import SceneError

if TYPE_CHECKING:
    from hradiosity.model.scene import Note
    from hradiosity.space.check import Finding

_STYLES = {"fault": "bold red", "warning": "yellow", "info": "dim"}
_TITLES = {
    "fault": "Faults: nothing is computed until they are mended",
    "warning": "Warnings: numbers may be wrong",
    "info": "Worth knowing",
}


def check(scene: Path, /, *, picture: Path | None = None, device: str | None = None, json: bool = False) -> int:
    """Look for what is wrong or doubtful in a scene; exit status 2 when a fault stops it from being rendered.

    Parameters
    ----------
    scene
        Folder with scene.toml, or the file.
    picture
        Draw the findings into this PNG file: an overview with numbers, and a close-up of each.
    device
        Number from `hradiosity devices`, or a part of the device's name.
    json
        One JSON object instead of words.
    """
    from hradiosity.device import Device
    from hradiosity.io.run_record import to_json
    from hradiosity.io.scene_toml import load_scene
    from hradiosity.show.findings_sheet import write_findings_picture
    from hradiosity.space.bvh_build import build_bvh
    from hradiosity.space.check import check_scene
    from hradiosity.space.contact_cuts import cut_at_contacts
    from hradiosity.space.lit_sides import find_lit_sides

    try:
        loaded = load_scene(scene)
    except SceneError as error:
        if json:
            print(to_json({"faults": [asdict(fault) for fault in error.faults], "findings": [], "notes": []}))
        raise
    opened, cut = Device(device), cut_at_contacts(loaded)
    lit = find_lit_sides(cut.scene, build_bvh(opened, cut.scene.patches)).of_parents(cut.parent)
    bvh = build_bvh(opened, loaded.patches)
    findings = check_scene(loaded, bvh, lit)
    if picture is not None:
        write_findings_picture(picture, loaded, bvh, lit, findings)
    if json:
        notes = [{"kind": note.kind, "place": note.place, "message": note.message} for note in loaded.notes]
        print(to_json({"faults": [], "findings": [finding.as_json() for finding in findings], "notes": notes}))
    else:
        _print(loaded.name, findings, loaded.notes)
    return BAD_INPUT if any(finding.severity == "fault" for finding in findings) else GOOD


def _print(name: str, findings: Sequence[Finding], notes: Sequence[Note]) -> None:
    """Findings by severity, each with effect and fix; then what was noticed while the file was read."""
    from rich.console import Console

    from hradiosity.cli.text import note_lines
    from hradiosity.space.check import SEVERITIES

    console = Console(highlight=False)

    def show(text: str, style: str | None = None) -> None:
        console.print(text, style=style, markup=False, soft_wrap=True)

    for severity in SEVERITIES:
        chosen = [finding for finding in findings if finding.severity == severity]
        if chosen:
            show(_TITLES[severity], _STYLES[severity])
        for finding in chosen:
            show(f"  {finding.kind}: {finding.message}")
            if finding.effect:
                show(f"      {finding.effect}", "dim")
            if finding.fix:
                show(f"      → {finding.fix}", "green")
    if notes:
        show("While reading the file", "dim")
        for line in note_lines(notes, all_of_them=True):
            show(f"  {line}")
    if all(finding.severity == "info" for finding in findings):
        show(f"{name}: no fault, no warning")

"""``hradiosity check``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hradiosity.cli import BAD_INPUT, GOOD
from hradiosity.errors import SceneError

if TYPE_CHECKING:
    from hradiosity.device import Device
    from hradiosity.io.mending.mend import Mended
    from hradiosity.model.scene import Note, Scene
    from hradiosity.space.check import Finding, Subject

_STYLES = {"fault": "bold red", "warning": "yellow", "info": "dim"}
_TITLES = {
    "fault": "Faults: nothing is computed until they are mended",
    "warning": "Warnings: numbers may be wrong",
    "info": "Worth knowing",
}


def check(
    scene: Path,
    /,
    *,
    picture: Path | None = None,
    repair: Path | None = None,
    device: str | None = None,
    json: bool = False,
) -> int:
    """Look for what is wrong or doubtful in a scene; exit status 2 when a fault stops it from being rendered.

    Parameters
    ----------
    scene
        Folder with scene.toml, or the file.
    picture
        Draw the findings into this PNG file: an overview with numbers, and a close-up of each.
    repair
        Write a mended copy of the scene into this folder, which must be new or empty, and check that; the scene itself
        stays as it is.
    device
        Number from `hradiosity devices`, or a part of the device's name.
    json
        One JSON object instead of words.
    """
    from hradiosity.device import Device
    from hradiosity.io.mending.mend import check_target, write_mended_copy
    from hradiosity.io.run_record import to_json
    from hradiosity.io.scene_toml import load_scene, scene_file
    from hradiosity.show.findings_sheet import write_findings_picture
    from hradiosity.space.check import check_scene

    if repair is not None:
        check_target(repair)
    try:
        loaded = load_scene(scene)
    except SceneError as error:
        if json:
            print(to_json({"faults": [asdict(fault) for fault in error.faults], "findings": [], "notes": []}))
        raise
    examine = partial(_examined, device=Device(device))
    subject = examine(loaded)
    findings = check_scene(loaded, subject.bvh, subject.lit)
    if picture is not None:
        write_findings_picture(picture, loaded, subject.bvh, subject.lit, findings)
    mended = None if repair is None else write_mended_copy(scene_file(scene), repair, examine)
    left = findings if mended is None else mended.findings
    if json:
        notes = [{"kind": note.kind, "place": note.place, "message": note.message} for note in loaded.notes]
        found: dict[str, Any] = {"faults": [], "findings": [finding.as_json() for finding in findings], "notes": notes}
        if mended is not None:
            copied = {"mended": mended.done, "refused": mended.refused, "findings": [f.as_json() for f in left]}
            found["repair"] = {"folder": str(repair), **copied}
        print(to_json(found))
    else:
        _print(loaded.name, findings, loaded.notes)
        if mended is not None:
            _print_mended(str(repair), mended)
    return BAD_INPUT if any(finding.severity == "fault" for finding in left) else GOOD


def _examined(scene: Scene, device: Device) -> Subject:
    """What checks look at: light reaches the patches where it reaches the pieces that contacts cut them into."""
    from hradiosity.space.bvh_build import build_bvh
    from hradiosity.space.check import Subject
    from hradiosity.space.contact_cuts import cut_at_contacts
    from hradiosity.space.lit_sides import find_lit_sides

    cut = cut_at_contacts(scene)
    lit = find_lit_sides(cut.scene, build_bvh(device, cut.scene.patches)).of_parents(cut.parent)
    return Subject(scene, build_bvh(device, scene.patches), lit)


def _print_mended(folder: str, mended: Mended) -> None:
    """What was mended, what can't be, and what is left in the copy."""
    from rich.console import Console

    console = Console(highlight=False)

    def show(text: str, style: str | None = None) -> None:
        console.print(text, style=style, markup=False, soft_wrap=True)

    show(f"Mended copy in {folder}", "bold")
    for line in mended.done:
        show(f"  {line}", "green")
    if not mended.done:
        show("  nothing was to be mended that can be")
    for line in mended.refused:
        show(f"  not mended, {line}", "yellow")
    left = [finding for finding in mended.findings if finding.severity != "info"]
    for finding in left:
        show(f"  left, {finding.kind}: {finding.message}", _STYLES[finding.severity])
        show(f"      → {finding.fix}")
    if not left:
        show("  no fault, no warning is left")


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

"""What a run has to know of a scene's geometry, whatever its settings."""

from __future__ import annotations

from dataclasses import dataclass

from hradiosity.device import Device
from hradiosity.model.scene import Note, Scene
from hradiosity.radiosity.record import Record
from hradiosity.space.bvh import Bvh
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.check import check_scene, raise_faults
from hradiosity.space.contact_cuts import cut_at_contacts
from hradiosity.space.lit_sides import LitSides, find_lit_sides


@dataclass(frozen=True)
class Geometry:
    """What all rounds of a run share.

    scene : the scene, cut where patches touch
    bvh : its ray structure
    lit : sides that light reaches
    notes : remarks of the scene, and what is doubtful about it
    cpu_seconds : that it took, without looking for what is doubtful, which is no part of solving
    """

    scene: Scene
    bvh: Bvh
    lit: LitSides
    notes: tuple[Note, ...]
    cpu_seconds: float


def find_geometry(device: Device, scene: Scene, seed: int, record: Record) -> Geometry:
    """Build and check; patches are looked at as they were before they were cut, with the light on their pieces.

    Raises
    ------
    SceneError
        When something about the scene makes its light undefined.
    """
    start = device.work_cpu_seconds()
    with record.timed("geometry"):
        cut = cut_at_contacts(scene)
        bvh = build_bvh(device, cut.scene.patches)
        lit = find_lit_sides(cut.scene, bvh, seed=seed)
    spent = device.work_cpu_seconds() - start
    with record.timed("check"):
        whole = cut.scene is scene
        bvh_of_whole = bvh if whole else build_bvh(device, scene.patches)
        lit_of_whole = lit if whole else lit.of_parents(cut.parent)
        findings = check_scene(scene, bvh_of_whole, lit_of_whole, seed=seed) if len(scene.patches) else ()
        raise_faults(findings, scene)
    notes = (*cut.scene.notes, *(finding.as_note() for finding in findings))
    return Geometry(cut.scene, bvh, lit, notes, spent)

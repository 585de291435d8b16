"""Is the model sound? Findings about a loaded scene, named, with place, effect and fix.

Wiring: after `build_bvh` and `find_lit_sides`, a run calls ``check_scene(scene, bvh, lit)``, then
``raise_faults(findings, scene)`` (a `SceneError` with all faults), and puts the other findings into ``run.json`` and
in front of the user (``finding.as_json()``, ``finding.as_note()``).
"""

from __future__ import annotations

from hradiosity.model.scene import Scene
from hradiosity.space.bvh import Bvh
from hradiosity.space.check.cameras import camera_findings
from hradiosity.space.check.coincident import coincident_findings
from hradiosity.space.check.finding import SEVERITIES, Finding, Severity, ordered, raise_faults
from hradiosity.space.check.lamps import lamp_findings
from hradiosity.space.check.sensors import look_from_sensors, sensor_findings
from hradiosity.space.check.shapes import shape_findings
from hradiosity.space.check.shells import shell_findings
from hradiosity.space.check.spaces import space_findings
from hradiosity.space.check.spectra import spectral_findings
from hradiosity.space.check.subject import Subject
from hradiosity.space.lit_sides import LitSides, find_lit_sides

__all__ = ["SEVERITIES", "Finding", "Severity", "Subject", "all_findings", "check_scene", "ordered", "raise_faults"]


def check_scene(scene: Scene, bvh: Bvh, lit: LitSides | None = None, *, seed: int = 0) -> tuple[Finding, ...]:
    """Look at everything that a scene file can't show by itself; changes nothing.

    Parameters
    ----------
    scene : Scene
        With one patch or more.
    bvh : Bvh
        Built from the scene's patches.
    lit : LitSides, optional
        Found here if it isn't at hand.
    seed : int
        Of the random rays; findings about small leaks may depend on it.

    Returns
    -------
    tuple of Finding
        Gravest first; many of one kind are counted in the last of that kind.
    """
    return ordered(all_findings(Subject(scene, bvh, lit or find_lit_sides(scene, bvh, seed=seed), seed)))


def all_findings(subject: Subject) -> list[Finding]:
    """Every single finding, in no order."""
    seen = look_from_sensors(subject)
    return [
        *coincident_findings(subject),
        *shape_findings(subject),
        *shell_findings(subject),
        *sensor_findings(subject, seen),
        *camera_findings(subject),
        *lamp_findings(subject),
        *space_findings(subject, seen),
        *spectral_findings(subject.scene),
    ]

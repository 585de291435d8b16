"""Faults and doubts that only the whole scene shows."""

from typing import Final

import numpy as np

from hradiosity.io.scene.frame import Frame
from hradiosity.io.scene.lines import Location
from hradiosity.io.scene.report import Report
from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.scene import Scene
from hradiosity.model.solids import find_solids
from hradiosity.model.variants import with_variant

_LARGE: Final = {"m": 1000.0, "ft": 3000.0, "in": 40000.0, "cm": 100000.0}
"""Extent of a scene, in its unit, above which a smaller unit is likelier (1 km)."""
_SMALL: Final = 0.05
"""Extent of a scene [m] below which a larger unit is likelier."""
_CLOSE_TO_ONE: Final = 1e-12


def check_scene(scene: Scene, frame: Frame, report: Report) -> None:
    """Report a scene without light or surfaces, one without an answer, and a unit that looks wrong."""
    if len(scene.patches) == 0:
        report.fault((), "no surface", "at least one [[rectangle]], [[polygon]], [[box]] or [[mesh]]")
        return
    if len(scene.emitters) == 0 and scene.sky is None:
        report.fault((), "nothing gives light", "a `luminaire` on a surface, a [[point_source]] or a [sky]")
    _check_singular(scene, ("materials",), report)
    for number, variant in enumerate(scene.variants):
        _check_singular(with_variant(scene, variant), ("variant", number), report)
    _check_extent(scene.patches, frame, report)


def _check_singular(scene: Scene, location: Location, report: Report) -> None:
    """A closed space that absorbs nothing has no finite answer."""
    used = np.unique(scene.patches.material)
    if not all(scene.materials[i].two_sided for i in used):
        return
    is_white = scene.reflectance[used].min(axis=0) >= 1.0 - _CLOSE_TO_ONE
    if not is_white.any() or not _is_closed(scene.patches):
        return
    worst = float(scene.bands.centre[int(np.argmax(is_white))])
    report.fault(
        location,
        f"the surfaces enclose a space and all reflect everything at {worst:g} nm: light would grow without end",
        "a reflectance below 1 on some surface",
    )


def _is_closed(patches: Patches) -> bool:
    """Whether some closed shell faces inwards: within one object, or made of all of them."""
    corners = patches.corners()
    alone = find_solids(corners, patches.is_triangle, patches.object).inward
    together = find_solids(corners, patches.is_triangle, np.zeros(len(patches), dtype=np.int32)).inward
    return bool((alone != NONE).any() or (together != NONE).any())


def _check_extent(patches: Patches, frame: Frame, report: Report) -> None:
    """Warn about a scene that is too large or too small for its unit."""
    low, high = patches.bounds()
    metres = float((high - low).max())
    extent = metres / frame.length(1.0)
    if extent > _LARGE.get(frame.unit, np.inf):
        report.warn(("scene", "unit"), f"the scene is {extent:g} {frame.unit} large: that looks like mm")
    elif metres < _SMALL:
        report.warn(("scene", "unit"), f"the scene is only {1000 * metres:.3g} mm large: is the unit right?")

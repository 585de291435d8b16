"""Rooms that are boxes, with the exact light at points: bands take their reflectances from several solved rooms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.scene import Scene
from hradiosity.suites.coverage.writing import entry, points, scene_text
from hradiosity.suites.validation import data
from hradiosity.suites.validation.rooms import place
from hradiosity.suites.validation.scene_text import FACES, INWARD, wall_with_opening

FIRST, LAST, STEP = 380.0, 780.0, 5.0
"""Bands of the rooms [nm]."""
BOX_FACES = dict(zip(FACES, ("left", "right", "front", "back", "bottom", "top")))
POINT_LUMENS = 10000.0
PANELS = {"ceiling": 1000.0, "centre": 1000.0 * np.pi, "corner": 5000.0}
"""Luminous exitance of the lamps of the rooms [lm m⁻²]."""
OPENINGS = {"centre": ((1.5, 1.5), (2.5, 2.5)), "corner": ((0.4, 1.0), (1.0, 2.2))}
"""Where the panels lie in the ceiling [m]."""


def room_text(title: str, lamp: str, names: Sequence[str]) -> str:
    """A scene with the geometry and the points that the solved rooms `names` have in common.

    Parameters
    ----------
    lamp : str
        "point", or one of PANELS.
    names : sequence of str
        Of `data.box_rooms`. The first ones are met at short wavelengths, the last ones at long ones.
    """
    known = [data.box_rooms()[name] for name in names]
    edges = band_edges(len(names))
    materials = {
        face: {"steps": [[low, high, room["rho"][face]] for low, high, room in zip(edges, edges[1:], known)]}
        for face in FACES
    }
    amount = {"luminous_flux_lm": POINT_LUMENS} if lamp == "point" else {"luminous_exitance_lm_m2": PANELS[lamp]}
    luminaires = {"lamp": {"spectrum": {"illuminant": "LED-B3"}, **amount}}
    bands = {"first": FIRST, "last": LAST, "step": STEP}
    entries = [*_surfaces(lamp, known[0]["dims"]), *_sensors(known[0])]
    return scene_text(title, materials, luminaires, entries, bands)


def exact_spectra(scene: Scene, lamp: str, names: Sequence[str]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Irradiance at the points of `room_text`, and the standard error that stands for how exactly it is known.

    Returns
    -------
    irradiance, error : (n_points, n_bands) float64 [W m⁻² per band]
    """
    known = [data.box_rooms()[name] for name in names]
    source = scene.luminaires[0]
    per_lumen = source.intensity * 4.0 * np.pi / POINT_LUMENS if lamp == "point" else source.exitance / PANELS[lamp]
    of_band = np.searchsorted(band_edges(len(names)), scene.bands.centre) - 1
    ordered = [[point["E_total"] for _, group in _by_sensor(room) for point in group] for room in known]
    irradiance = np.array(ordered).T[:, of_band] * per_lumen
    uncertain = np.array([room["numerical_uncertainty_rel"] for room in known])
    return irradiance, 0.5 * uncertain[of_band] * irradiance


def band_edges(parts: int) -> list[float]:
    """Wavelengths that cut the bands into about equal parts, on edges of bands."""
    count = round((LAST - FIRST) / STEP) + 1
    return [FIRST - 0.5 * STEP + STEP * round(i * count / parts) for i in range(parts + 1)]


def _surfaces(lamp: str, size: Sequence[float]) -> list[str]:
    faces = {box: face for face, box in BOX_FACES.items() if face != "ceiling"}
    if lamp in OPENINGS:
        walls = entry("box", name="room", corner=(0, 0, 0), size=size, inside=True, omit=["top"], faces=faces)
        low, high = OPENINGS[lamp]
        ceiling = wall_with_opening("ceiling", size, low, high, "ceiling", ("ceiling", "lamp"))
        return [walls, *("\n".join([*piece.lines(), ""]) for piece in ceiling)]
    shining: dict[str, Any] = {"luminaires": {"top": "lamp"}} if lamp == "ceiling" else {}
    faces["top"] = "ceiling"
    walls = entry("box", name="room", corner=(0, 0, 0), size=size, inside=True, faces=faces, **shining)
    if lamp != "point":
        return [walls]
    return [walls, entry("point_source", position=[0.5 * edge for edge in size], luminaire="lamp")]


def _sensors(known: Mapping[str, Any]) -> list[str]:
    return [
        points(name, [place(point, known["dims"]) for point in group], [INWARD[point["face"]] for point in group])
        for name, group in _by_sensor(known)
    ]


def _by_sensor(known: Mapping[str, Any]) -> list[tuple[str, list[Mapping[str, Any]]]]:
    """Points of each sensor, in the order of the scene's sensors."""
    names = {"walls": FACES[:4], "floor": ("floor",), "ceiling": ("ceiling",)}
    return [(name, [point for point in known["points"] if point["face"] in faces]) for name, faces in names.items()]

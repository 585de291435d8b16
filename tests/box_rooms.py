"""Scenes made in a few lines: the box rooms whose continuous solutions come with the package, and helpers."""

import numpy as np

from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.geometry import NONE, Patches
from hradiosity.model.scene import Emitters, Luminaire, Material, Scene, Sensor, Sky
from hradiosity.model.spectrum import Bands
from hradiosity.suites.validation import data

FACES = ("x0", "x1", "y0", "y1", "floor", "ceiling")
INWARD = {
    "x0": (1, 0, 0),
    "x1": (-1, 0, 0),
    "y0": (0, 1, 0),
    "y1": (0, -1, 0),
    "floor": (0, 0, 1),
    "ceiling": (0, 0, -1),
}
SENSOR = "points"
CASES = data.box_rooms()


def box_faces(x, y, z):
    """(6, 3, 3) origin and edges of the faces of a room at the origin, normals inward, in the order of FACES."""
    faces = {
        "x0": ((0, 0, 0), (0, y, 0), (0, 0, z)),
        "x1": ((x, 0, 0), (0, 0, z), (0, y, 0)),
        "y0": ((0, 0, 0), (0, 0, z), (x, 0, 0)),
        "y1": ((0, y, 0), (x, 0, 0), (0, 0, z)),
        "floor": ((0, 0, 0), (x, 0, 0), (0, y, 0)),
        "ceiling": ((0, 0, z), (0, y, 0), (x, 0, 0)),
    }
    return np.array([faces[name] for name in FACES], float)


def solid_box(low, high):
    """(6, 3, 3) origin and edges of a box whose normals point outward."""
    size = np.subtract(high, low)
    faces = box_faces(*size)[:, [0, 2, 1]]
    faces[:, 0] += low
    return faces


def patches_of(parallelograms, material, solid=None):
    """Patches from (n, 3, 3) rows of origin, edge_u, edge_v; solid: (n,) numbers or None."""
    rows = np.asarray(parallelograms, float)
    n = len(rows)
    return Patches(
        rows[:, 0],
        rows[:, 1],
        rows[:, 2],
        np.zeros(n, bool),
        np.asarray(material, np.int32),
        np.zeros(n, np.int32),
        np.arange(n, dtype=np.int32),
        np.full(n, NONE, np.int32) if solid is None else np.asarray(solid, np.int32),
    )


def scene_of(patches, reflectance, lamps, position, normal, *, bands=None, sky=None, two_sided=True, name="test"):
    """Scene with one sensor.

    reflectance : (n_materials, n_bands)
    lamps : list of (patch number, exitance (n_bands,)), or of ((3,) position, intensity (n_bands,))
    """
    reflectance = np.asarray(reflectance, float)
    n_bands = reflectance.shape[1]
    luminaires, patch, places = [], [], []
    for i, (where, light) in enumerate(lamps):
        light, nothing = np.broadcast_to(np.asarray(light, float), (n_bands,)), np.zeros(0)
        is_patch = np.ndim(where) == 0
        luminaires.append(Luminaire(f"lamp{i}", light if is_patch else nothing, nothing if is_patch else light))
        patch.append(where if is_patch else NONE)
        places.append(patches.centroid[where] if is_patch else where)
    return Scene(
        name=name,
        path=None,
        bands=bands or Bands.uniform(550, 550 + 5 * (n_bands - 1), 5),
        patches=patches,
        materials=tuple(Material(f"paint{i}", row, two_sided) for i, row in enumerate(reflectance)),
        luminaires=tuple(luminaires),
        emitters=Emitters(
            np.array(patch, np.int32), np.array(places, float).reshape(-1, 3), np.arange(len(lamps), dtype=np.int32)
        ),
        sensors=(Sensor(SENSOR, np.asarray(position, float), np.asarray(normal, float)),),
        views=(),
        objects=("room",),
        sky=None if sky is None else Sky(np.broadcast_to(np.asarray(sky, float), (n_bands,))),
    )


def box_room(case):
    """Scene of one of CASES, with one band in which illuminances are those of the case; see `expected`."""
    bands = Bands.explicit([550.0, 560.0])
    efficacy = float(luminous_weights(bands)[0])
    x, y, z = case["dims"]
    rows, material = list(box_faces(x, y, z)), list(range(6))
    source = case["source"]
    if "isotropic" in source:
        place = (1.0, 1.5, 3.0) if "(1,1.5,3)" in source else (x / 2, y / 2, z / 2)
        lamps = [(np.array(place), 10000.0 / (4.0 * np.pi * efficacy))]
    elif "whole ceiling" in source:
        lamps = [(5, 1000.0 / efficacy)]
    else:
        offset = "0.6x1.2" in source
        low, high = ((0.4, 1.0), (1.0, 2.2)) if offset else ((x / 2 - 0.5, y / 2 - 0.5), (x / 2 + 0.5, y / 2 + 0.5))
        rows[5:] = list(_ceiling_with_panel(x, y, z, low, high))
        material = material[:5] + [5] * 5
        lamps = [(5, (5000.0 if offset else 1000.0 * np.pi) / efficacy)]
    position = [_place(point, case["dims"]) for point in case["points"]]
    normal = [INWARD[point["face"]] for point in case["points"]]
    reflectance = [[case["rho"][face]] for face in FACES]
    return scene_of(patches_of(rows, material), reflectance, lamps, position, normal, bands=bands, name=case["id"])


def expected(case, part="total"):
    """(n_points,) illuminances of a case [lx]: its "total", "direct" or "indirect" part."""
    return np.array([point[f"E_{part}"] for point in case["points"]])


def _ceiling_with_panel(x, y, z, low, high):
    """The panel and the four pieces of ceiling around it, facing down."""
    (x0, y0), (x1, y1) = low, high
    spans = [(x0, x1, y0, y1), (0, x0, 0, y), (x1, x, 0, y), (x0, x1, 0, y0), (x0, x1, y1, y)]
    return np.array([((a, c, z), (0, d - c, 0), (b - a, 0, 0)) for a, b, c, d in spans], float)


def _place(point, dims):
    """World position of a point that is given by its face and the two other coordinates."""
    axis = {"x": 0, "y": 1, "f": 2, "c": 2}[point["face"][0]]
    across = dims[axis] if point["face"] in ("x1", "y1", "ceiling") else 0.0
    return np.insert([point["a"], point["b"]], axis, across)

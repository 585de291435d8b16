"""Connected lit spaces: open or closed, cracks, whether light in them can settle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.geometry import NONE
from hradiosity.space.check.escapes import escapes, leaving_points
from hradiosity.space.check.finding import Finding, at
from hradiosity.space.check.probe import LIT, trace
from hradiosity.space.check.sensors import SensorViews
from hradiosity.space.check.subject import Subject

LEAK = 0.02
"""Share of escaping rays below which a space that is not closed looks as if it were meant to be."""
SLOW = 0.95
"""Mean reflectance above which light dies away slowly."""
_CLOSE_TO_ONE = 1e-12
_CLUSTER = 0.05


def space_findings(subject: Subject, seen: SensorViews) -> Iterator[Finding]:
    """Each lit space, its cracks, and reflectances that leave its light no way out."""
    n = len(subject.lit.open)
    if n == 0:
        return
    escaped, exits = escapes(subject)
    readings = _readings_in(subject, seen, n)
    lamps = _lamps_in(subject, n)
    sides = subject.lit.space.ravel()
    side_area = np.repeat(subject.area, 2)
    area = np.bincount(sides[sides >= 0], side_area[sides >= 0], minlength=n)
    for space in np.flatnonzero(area > 0.0):
        share = float(escaped[space])
        name, low, high = _extent(subject, int(space))
        kind = "open" if share >= LEAK or (share > 0.0 and subject.scene.sky is not None) else "closed"
        parts = [
            f"{area[space]:.3g} m² of lit surfaces",
            _count(lamps[space], "lamp"),
            _count(readings[space], "reading"),
        ]
        effect = "" if readings[space] or subject.scene.views else "nothing looks at it: its light is of no use"
        message = f"{kind} space around '{name}': {', '.join(parts)}; {100 * share:.3g} % of its rays leave"
        middle, size = 0.5 * (low + high), float(np.linalg.norm(high - low))
        yield Finding("space", "info", name, middle, size, message, effect, "")
        if kind == "closed":
            if share > 0.0:
                yield _leak(name, share, leaving_points(*exits[int(space)], low, high), size)
            else:
                yield from _settling(subject, int(space), name, middle, size)


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _extent(subject: Subject, space: int) -> tuple[str, NDArray[np.float64], NDArray[np.float64]]:
    """Object with the largest lit area of a space, and its bounds."""
    mine = (subject.lit.space == space).any(axis=1)
    owner = subject.scene.patches.object[mine]
    name = subject.scene.objects[int(np.bincount(owner, subject.area[mine]).argmax())]
    corners = subject.corners[mine].reshape(-1, 3)
    return name, corners.min(axis=0), corners.max(axis=0)


def _leak(name: str, share: float, exits: NDArray[np.float64], size: float) -> Finding:
    """A crack, at the place where most of the escaping rays pass."""
    from scipy.spatial import cKDTree

    tree = cKDTree(exits)
    around = tree.query_ball_point(exits, _CLUSTER * size)
    place = np.median(exits[max(around, key=len)], axis=0)
    return Finding(
        "leak",
        "warning",
        name,
        place,
        float(np.sqrt(share) * size),
        f"the space around '{name}' leaks {100 * share:.2g} % of its rays through a crack near {at(place)}",
        "light is lost there, and interreflection comes out too low",
        "close the gap, or open it wider if it is meant to be an opening",
    )


def _settling(subject: Subject, space: int, name: str, middle: NDArray[np.float64], size: float) -> Iterator[Finding]:
    """A closed space in which light can't die away, or only slowly."""
    black = len(subject.scene.materials)
    front = subject.scene.patches.material.astype(np.int64)
    material = np.stack([front, np.where(subject.reflects_behind, front, black)], axis=1)
    mine = subject.lit.space == space
    area = np.bincount(material[mine], np.repeat(subject.area[:, None], 2, axis=1)[mine], minlength=black + 1)
    rho = np.concatenate([subject.scene.reflectance, np.zeros((1, len(subject.scene.bands)))])
    centre = subject.scene.bands.centre
    lowest = rho[area > 0.0].min(axis=0)
    mean = np.einsum("m,mb->b", area / area.sum(), rho)
    if lowest.max() >= 1.0 - _CLOSE_TO_ONE:
        yield Finding(
            "no-absorption",
            "fault",
            name,
            middle,
            size,
            f"the closed space around '{name}' reflects everything at {centre[lowest.argmax()]:g} nm",
            "light would grow without end",
            "give some surface a reflectance below 1",
        )
    elif mean.max() > SLOW:
        yield Finding(
            "slow-convergence",
            "info",
            name,
            middle,
            size,
            f"the closed space around '{name}' reflects {mean.max():.4g} on average at {centre[mean.argmax()]:g} nm",
            f"light is reflected about {1.0 / (1.0 - mean.max()):.3g} times: small errors of reflectance and geometry "
            "count as many times",
            "",
        )


def _readings_in(subject: Subject, seen: SensorViews, n: int) -> NDArray[np.int64]:
    """(n_spaces,) readings that look into each space; one that sees none counts where the surface behind it is."""
    views = seen.views
    if len(seen.position) == 0:
        return np.zeros(n, np.int64)
    met = (views.outcome == LIT) & (views.patch != NONE)
    first = met.argmax(axis=1)
    row = np.flatnonzero(met.any(axis=1))
    space = np.full(len(met), NONE)
    space[row] = subject.lit.space[views.patch[row, first[row]], views.side[row, first[row]]]
    alone = np.flatnonzero(space == NONE)
    behind = trace(subject, (seen.position + subject.offset * seen.normal)[alone], -seen.normal[alone])
    below = subject.lit.space[np.maximum(behind.patch, 0), behind.side]
    space[alone] = np.where(behind.patch != NONE, below, NONE)
    return np.bincount(space[space >= 0], minlength=n)


def _lamps_in(subject: Subject, n: int) -> NDArray[np.int64]:
    """(n_spaces,) shining objects of each space; point sources count one each."""
    emitters, patches = subject.scene.emitters, subject.scene.patches
    area_lamp = emitters.patch[emitters.patch != NONE]
    space = subject.lit.space[area_lamp, 0]
    pairs = np.unique(np.column_stack([space, patches.object[area_lamp]]), axis=0)
    lamps = np.bincount(pairs[pairs[:, 0] >= 0, 0], minlength=n)
    point = emitters.position[emitters.patch == NONE]
    if len(point):
        hits = trace(subject, point, np.tile([0.0, 0.0, -1.0], (len(point), 1)))
        below = subject.lit.space[np.maximum(hits.patch, 0), hits.side]
        found = below[(hits.patch != NONE) & (below >= 0)]
        lamps += np.bincount(found, minlength=n)
    return lamps

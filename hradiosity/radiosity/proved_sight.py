"""What shafts prove about elements, readings and lamps before a run, so that no ray is spent on it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.scene import Scene
from hradiosity.plan import Calibration, Plan
from hradiosity.planning import sight_shares, with_sight
from hradiosity.space.bvh import Bvh
from hradiosity.space.hierarchy import Elements
from hradiosity.space.lit_sides import LitSides
from hradiosity.space.shafts import UNKNOWN, EmitterShapes, point_sight, row_sight
from hradiosity.transport.device_scene import DeviceScene


def proved_sight(
    on_device: DeviceScene, plan: Plan, scene: Scene, bvh: Bvh, elements: Elements, lit: LitSides
) -> NDArray[np.uint8] | None:
    """(n_rows, n_emitters) of rows and emitters; None where it was decided without shafts, or there are none.

    Parameters
    ----------
    scene : Scene
        With the emitters that are sampled.
    """
    if not on_device.shafts or not plan.occlusion or not len(elements) or not plan.n_emitters:
        return None
    return row_sight(bvh, scene.patches, elements, EmitterShapes.of(scene), lit)


def plan_with_sight(
    plan: Plan,
    scene: Scene,
    bvh: Bvh,
    elements: Elements,
    space: NDArray[np.int32],
    sight: NDArray[np.uint8],
    calibration: Calibration | None,
) -> Plan:
    """The plan with what was proved, parameters as above; `space` (n_rows,) is the one that each row looks into."""
    shapes = EmitterShapes.of(scene)
    readings = not (sight == UNKNOWN).any() and all(
        bool((point_sight(bvh, shapes, s.position, s.normal) != UNKNOWN).all()) for s in scene.sensors
    )
    shares = sight_shares(scene, elements, space, sight)
    return with_sight(plan, sight, shares, readings_proved=readings, calibration=calibration)

"""Where the window looks from: orbiting around a point, and walking."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.model.scene import View

STEEPEST: Final = np.radians(89.9)
NEAREST: Final = 1e-3
"""Of the point that is orbited, over the size of the scene."""
WHEEL: Final = 1.15
"""Nearer by so much with each notch of the wheel."""
STEP: Final = 0.02
"""Of a step on foot, over the size of the scene."""


@dataclass(frozen=True)
class Pose:
    """A camera; up is along z as far as that goes.

    position : (3,) float64 [m]
    yaw, pitch : direction of view [rad]: from x towards y, and above the horizon
    distance : of the point that is orbited [m]
    angle : of the view, from bottom to top [rad]
    """

    position: NDArray[np.float64]
    yaw: float
    pitch: float
    distance: float
    angle: float

    @property
    def forward(self) -> NDArray[np.float64]:
        """(3,) unit vector."""
        flat = np.cos(self.pitch)
        return np.array([flat * np.cos(self.yaw), flat * np.sin(self.yaw), np.sin(self.pitch)])

    @property
    def up(self) -> NDArray[np.float64]:
        """(3,) unit vector, upwards in the window."""
        steep = np.sin(self.pitch)
        return np.array([-steep * np.cos(self.yaw), -steep * np.sin(self.yaw), np.cos(self.pitch)])

    @property
    def right(self) -> NDArray[np.float64]:
        """(3,) unit vector, to the right in the window."""
        return np.array([np.sin(self.yaw), -np.cos(self.yaw), 0.0])

    @property
    def focus(self) -> NDArray[np.float64]:
        """(3,) point that is orbited [m]."""
        focus: NDArray[np.float64] = self.position + self.distance * self.forward
        return focus

    def turned(self, yaw: float, pitch: float) -> Pose:
        """Looking elsewhere from the same place."""
        return replace(self, yaw=self.yaw + yaw, pitch=float(np.clip(self.pitch + pitch, -STEEPEST, STEEPEST)))

    def orbited(self, yaw: float, pitch: float) -> Pose:
        """Looking at the same point from elsewhere."""
        turned = self.turned(yaw, pitch)
        return replace(turned, position=self.focus - self.distance * turned.forward)

    def panned(self, right: float, up: float) -> Pose:
        """Moved across the direction of view [m]."""
        return replace(self, position=self.position + right * self.right + up * self.up)

    def nearer(self, notches: float, size: float) -> Pose:
        """Nearer to the point that is orbited, by notches of the wheel."""
        distance = max(self.distance * WHEEL**-notches, NEAREST * size)
        return replace(self, position=self.focus - distance * self.forward, distance=distance)

    def walked(self, ahead: float, right: float, up: float) -> Pose:
        """Moved on foot [m]: ahead stays level."""
        level = np.array([np.cos(self.yaw), np.sin(self.yaw), 0.0])
        moved = self.position + ahead * level + right * self.right + np.array([0.0, 0.0, up])
        return replace(self, position=moved)

    def rays(self, x: NDArray[np.float64], y: NDArray[np.float64], width: int, height: int) -> NDArray[np.float64]:
        """(n, 3) directions through places of the window, in pixels from its lower left corner; not of unit length."""
        half = np.tan(0.5 * self.angle)
        across, upwards = half * width / height * (2.0 * x / width - 1.0), half * (2.0 * y / height - 1.0)
        rays: NDArray[np.float64] = self.forward + across[..., None] * self.right + upwards[..., None] * self.up
        return rays

    def project(self, points: NDArray[np.float64], width: int, height: int) -> NDArray[np.float64]:
        """(n, 2) places of points (n, 3) in the window, in pixels from its lower left corner; NaN behind the camera."""
        offset = points - self.position
        depth = np.einsum("nk,k->n", offset, self.forward)
        depth = np.where(depth > 0.0, depth, np.nan)
        half = np.tan(0.5 * self.angle)
        x = np.einsum("nk,k->n", offset, self.right) / (depth * half * width / height)
        y = np.einsum("nk,k->n", offset, self.up) / (depth * half)
        return np.stack([0.5 * (x + 1.0) * width, 0.5 * (y + 1.0) * height], axis=1)


def pose_of_view(view: View, aspect: float, distance: float) -> Pose:
    """The pose that shows at least what a view of the scene shows, in a window of a width over height."""
    across = np.tan(0.5 * np.radians(view.field_of_view))
    half = max(across * view.height / view.width, across / aspect)
    forward = view.direction / np.linalg.norm(view.direction)
    pitch = float(np.arcsin(np.clip(forward[2], -1.0, 1.0)))
    level = forward[:2] if abs(pitch) < STEEPEST else -np.sign(pitch) * view.up[:2]
    yaw = float(np.arctan2(level[1], level[0]))
    clipped = float(np.clip(pitch, -STEEPEST, STEEPEST))
    return Pose(view.position, yaw, clipped, distance, float(2.0 * np.arctan(half)))


def overview(low: NDArray[np.float64], high: NDArray[np.float64], aspect: float) -> Pose:
    """All of a box (3,) to (3,), from outside and above."""
    size = max(float(np.linalg.norm(high - low)), 1e-9)
    angle = np.radians(35.0)
    distance = 0.5 * size / np.sin(0.5 * angle * min(1.0, aspect))
    start = Pose(0.5 * (low + high), float(np.radians(60.0)), float(np.radians(-30.0)), distance, float(angle))
    return replace(start, position=start.position - distance * start.forward)

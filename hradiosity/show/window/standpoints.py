"""Where a subject is looked at from: its cameras, and from outside."""

from __future__ import annotations

from hradiosity.model.scene import View
from hradiosity.show.window.marks import scene_size
from hradiosity.show.window.navigation import Pose, overview, pose_of_view
from hradiosity.show.window.subject import Subject

_ORBIT = 0.35
"""Distance of the point that is orbited from a camera, over the size of the scene."""


def first_pose(subject: Subject, camera: str | None, size: tuple[int, int]) -> Pose:
    """Of the camera of that name, the first one if there is none, or from outside, in a window of a size [pixels]."""
    views = subject.drawn.views
    if not views:
        return outside_pose(subject, size)
    return camera_pose(subject, next((view for view in views if view.name == camera), views[0]), size)


def camera_pose(subject: Subject, view: View, size: tuple[int, int]) -> Pose:
    """That shows what a camera shows."""
    return pose_of_view(view, size[0] / size[1], _ORBIT * scene_size(subject.cells))


def outside_pose(subject: Subject, size: tuple[int, int]) -> Pose:
    """All of it from outside."""
    return overview(*subject.cells.bounds, size[0] / size[1])

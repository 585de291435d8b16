"""What an accuracy is expected to take, by what ``hradiosity cost`` measured of the scene."""

from __future__ import annotations

from hradiosity.io.learnt import accuracy_line, load_learnt
from hradiosity.model.scene import Scene
from hradiosity.options import Options
from hradiosity.suites.referee_cache import scene_digest


def accuracy_lines(scene: Scene, options: Options, device: str) -> list[str]:
    """One line when an accuracy is asked for; none otherwise.

    Parameters
    ----------
    scene : Scene
        As it was read.
    options : Options
    device : str
        Its description.
    """
    if options.accuracy is None:
        return []
    learnt = load_learnt(device, scene_digest(scene), options)
    return [accuracy_line(learnt, options.accuracy, options)]

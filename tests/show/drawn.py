"""Scenes with cameras for the tests of pictures."""

from dataclasses import replace

import numpy as np
from rooms import SceneBuilder, cube

from hradiosity.model.scene import View
from hradiosity.options import Options
from hradiosity.radiosity import solve
from hradiosity.show.pictures import PictureOptions, draw_pictures

QUICK = Options(rays_per_element=64, light_points=16, gather_samples=8, replicates=2, element_size=0.3)


def camera(position, target, name="v", field_of_view=70.0, width=64, height=48) -> View:
    position = np.asarray(position, float)
    direction = np.asarray(target, float) - position
    return View(
        name, position, direction / np.linalg.norm(direction), np.array([0.0, 0.0, 1.0]), field_of_view, width, height
    )


def draw(device, scene, *views, modes=("smooth",), options=QUICK, **choices):
    """Pictures by view and mode."""
    solution = solve(replace(scene, views=views), options, device)
    drawn = draw_pictures(solution, device, PictureOptions(modes=modes, **choices))
    return drawn, {(p.view, p.mode): p for p in drawn.pictures}


def furnace(rho=0.5, exitance=1.0):
    """Cube in which E = exitance / (1 - rho) everywhere."""
    room = cube(rho)
    room.lamp(range(6), exitance)
    return room.scene()


def furnished_room():
    """A closed room with a table, a block at the wall, a screen and a triangle, lit by one lamp under the ceiling."""
    b = SceneBuilder(3)
    white, red = b.material([0.7, 0.7, 0.7]), b.material([0.1, 0.3, 0.7])
    b.box((0, 0, 0), (3, 4, 2.5), white, inward=True)
    b.box((0.5, 0.5, 0), (1.2, 1.5, 0.7), red, solid=True)
    b.box((2.4, 1.0, 0), (3.0, 2.0, 1.9), red, solid=True)
    b.patch((1.5, 3.0, 1.4), (0.8, 0.3, 0.1), (0, 0.2, 0.6), red, triangle=True)
    b.lamp(b.patch((1.2, 1.8, 2.45), (0, 0.4, 0), (0.6, 0, 0), white), [10.0, 10.0, 10.0])
    return b.scene()

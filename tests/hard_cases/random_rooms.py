"""Random rooms with random blocks, in any place, position, size and order of their faces."""

from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st
from rooms import SceneBuilder, moved
from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Frame:
    """How a scene is put into the world: scaled, then turned, then shifted; its faces in another order."""

    scale: float
    turn: int
    shift: tuple[float, float, float]
    order: int

    def place(self, scene):
        """The scene in this frame."""
        turn = Rotation.random(random_state=self.turn).as_matrix() if self.turn else np.eye(3)
        return moved(shuffled(scene, self.order), rotation=turn, shift=np.array(self.shift), factor=self.scale)


_FAR = st.one_of(st.just(0.0), st.floats(-1e6, 1e6))
FRAMES = st.builds(
    Frame,
    scale=st.one_of(st.just(1.0), st.floats(-3.0, 3.0).map(lambda power: 10.0**power)),
    turn=st.integers(0, 2**31 - 1),
    shift=st.tuples(_FAR, _FAR, _FAR),
    order=st.integers(0, 2**31 - 1),
)


@dataclass(frozen=True)
class Room:
    """What a room is made from: its numbers come from `seed`, its blocks stand in the quarters of the floor.

    blocks : one for each quarter: "floor" stands flush on the floor, "stack" carries another, "corner" touches two
        walls as well, "hanging" is clear of everything, "" is nothing
    screen : a two-sided triangle hangs below the ceiling
    """

    seed: int
    blocks: tuple[str, ...]
    screen: bool

    def builder(self, bands, reflectance):
        """A closed room, its size between 2 m and 5 m, and the patches of its walls.

        reflectance : gives the reflectance (bands,) of a paint, from a random generator
        """
        rng = np.random.default_rng(self.seed)
        b = SceneBuilder(bands)
        size = rng.uniform((2.0, 2.0, 2.0), (5.0, 5.0, 3.5))
        b.box((0, 0, 0), size, [b.material(reflectance(rng)) for _ in range(6)], inward=True)
        for quarter, kind in enumerate(self.blocks):
            if kind:
                self._block(b, rng, size, quarter, kind, b.material(reflectance(rng)))
        if self.screen:
            corner = np.array([0.3, 0.4, 0.85]) * size
            b.patch(corner, (0.3 * size[0], 0.1, 0.05), (0, 0.2 * size[1], 0.1), b.material(reflectance(rng)), True)
        return b, size

    def _block(self, b, rng, size, quarter, kind, paint):
        """A block well inside its quarter and below 0.7 of the height; only those in a corner are not turned."""
        signs = 2.0 * np.array([quarter % 2, quarter // 2]) - 1.0
        reach = 0.22 * size[:2].min()
        slant = rng.uniform(0.3, 1.2)
        half = reach * np.array([np.cos(slant), np.sin(slant)])
        low = rng.uniform(0.02, 0.2) * size[2] if kind == "hanging" else 0.0
        high = low + rng.uniform(0.02, 0.5) * size[2]
        first = len(b.rows)
        b.box((-half[0], -half[1], low), (half[0], half[1], high), paint, solid=True)
        if kind == "stack":
            b.box((-half[0], -0.7 * half[1], high), (0.6 * half[0], half[1], 0.7 * size[2]), paint, solid=True)
        turn = np.eye(3) if kind == "corner" else Rotation.from_rotvec([0, 0, rng.uniform(0, 3)]).as_matrix()
        middle = np.where(signs > 0.0, size[:2] - half, half) if kind == "corner" else size[:2] * (0.5 + 0.25 * signs)
        for k in range(first, len(b.rows)):
            origin, u, v, *rest = b.rows[k]
            b.rows[k] = (turn @ origin + [*middle, 0.0], turn @ u, turn @ v, *rest)


ROOMS = st.builds(
    Room,
    seed=st.integers(0, 2**31 - 1),
    blocks=st.tuples(*[st.sampled_from(["", "floor", "stack", "corner", "hanging"])] * 4),
    screen=st.booleans(),
)


def places_in(size, seed, count):
    """(count, 3) places above all blocks and below the screen, and directions of any kind."""
    rng = np.random.default_rng(seed + 1)
    places = rng.uniform((0.02, 0.02, 0.72), (0.98, 0.98, 0.84), (count, 3)) * size
    normals = rng.normal(size=(count, 3))
    return places, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def shuffled(scene, seed):
    """Patches in another order, each from another of its corners; the scene as it is for seed 0."""
    if seed == 0:
        return scene
    rng = np.random.default_rng(seed)
    patches = scene.patches
    order = rng.permutation(len(patches))
    place = np.argsort(order)
    turns = rng.integers(0, 4, len(patches))
    origin, u, v = patches.origin.copy(), patches.edge_u.copy(), patches.edge_v.copy()
    for step in range(3):
        which = (turns > step)[:, None]
        far = np.where(patches.is_triangle[:, None], v - u, v)
        origin, u, v = np.where(which, origin + u, origin), np.where(which, far, u), np.where(which, -u, v)
    fields = {name: getattr(patches, name)[order] for name in patches.__dataclass_fields__}
    fields |= {"origin": origin[order], "edge_u": u[order], "edge_v": v[order]}
    patch = scene.emitters.patch
    return replace(
        scene,
        patches=replace(patches, **fields),
        emitters=replace(scene.emitters, patch=np.where(patch >= 0, place[patch], patch).astype(np.int32)),
    )

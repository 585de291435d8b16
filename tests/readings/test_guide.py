"""Directions that follow the light found before: the tables, the warp, and what they are good for."""

from dataclasses import replace

import numpy as np
import pytest
from device_call import device_call
from hypothesis import given, settings
from hypothesis import strategies as st
from rooms import SceneBuilder

from hradiosity.model.scene import Sky
from hradiosity.options import Options
from hradiosity.radiosity import RadiositySolver, solve
from hradiosity.readings.effort import Effort
from hradiosity.readings.guide import ACROSS, SIDE, Guides, guide_tables
from hradiosity.readings.guide_cuts import Blocks, Cuts
from hradiosity.readings.guide_pilot import EVEN_SHARE, guides_of, make_guides
from hradiosity.readings.paths import trace_referee
from hradiosity.space.bvh_build import build_bvh
from hradiosity.transport.device_scene import upload_scene


class MadeUpPilot:
    """Brightness light(point, u, v) at a random place of each part of the square."""

    def __init__(self, n, light, known=()):
        self.n, self.light, self.rng, self.known = n, light, np.random.default_rng(3), known

    def known_parts(self):
        return np.array(self.known, np.int64)

    def everywhere(self):
        point = np.arange(self.n)
        return self.in_blocks(point, np.zeros_like(point), SIDE, 1, 0)

    def in_blocks(self, point, number, across, side, step):
        u, v = self.rng.random((2, len(point), across, across))
        y, x = np.mgrid[:across, :across]
        u = ((number % side * across)[:, None, None] + x + u) / (side * across)
        v = ((number // side * across)[:, None, None] + y + v) / (side * across)
        return self.light(point[:, None, None], u, v)


def uncut(brightness):
    """Guides (n, SIDE²) of a brightness with nothing cut."""
    cuts = [Blocks.whole(len(brightness))]
    cuts += [Blocks.of_keys(side, np.zeros(0, np.int64)) for side in (SIDE, SIDE * ACROSS)]
    return guides_of(Cuts(cuts), brightness.ravel())


def slanting_gap(point, u, v):
    """A strip a thousand times as bright as the rest, a tenth of a part wide; not in the second hemisphere."""
    return np.where((np.abs(v - 0.3 - 0.37 * u) < 0.0016) & (u < 0.6) & (point != 1), 1000.0, 1.0)


def test_what_is_known_is_looked_at():
    """A spot that fills a sixth of a part, which the one ray to it misses, gets paths if that part is known."""
    at = 0.5 + 0.5 / SIDE

    def spot(point, u, v):
        return np.where(np.maximum(np.abs(u - at), np.abs(v - at)) < 0.2 / SIDE, 1e4, 1.0)

    part = SIDE // 2 * SIDE + SIDE // 2
    shares = [make_guides(MadeUpPilot(1, spot, known), np.zeros(1), 512).share[0, part] for known in ((), (part,))]
    assert shares[0] < 2.0 / SIDE**2 and shares[1] > 0.5


def gap_guides():
    return make_guides(MadeUpPilot(3, slanting_gap), np.zeros(3), 4096)


def warped(device, guides, u, v, kind=2):
    """(n, 3) of the warp of points by the first of some guides; `kind` as HR_GUIDED."""
    guides = guides.some(np.array([0]))
    key = np.append(guides.key, [0]).astype(np.uint32)
    n_keys, n = len(guides.key), len(u)
    block = np.append(guide_tables(guides.block, ACROSS).ravel(), [0.0]).astype(np.float32)
    call = "hr_guide(in_table, u, v)" if kind == 1 else f"hr_fine_guide(in_table, in_key, {n_keys}u, in_block, u, v)"
    table = guide_tables(guides.share, SIDE)[0]
    assert n >= max(len(table), len(key), len(block))
    return device_call(
        device, "hr_guide.h", call, "float3", table=np.resize(table, n), key=np.resize(key, n),
        block=np.resize(block, n), u=u.astype(np.float32), v=v.astype(np.float32),
    )  # fmt: skip


def even_points(n):
    """A grid of n × n points in the unit square."""
    at = (np.arange(n) + 0.5) / n
    return (part.ravel() for part in np.meshgrid(at, at))


def density(guides, u, v):
    """Of the first of some guides at points, in double precision, by looking up parts, blocks and blocks of blocks."""
    first = guides.some(np.array([0]))
    rows = dict(zip(first.key.tolist(), range(len(first.key))))
    found = np.empty(len(u))
    for i, (x, y) in enumerate(zip(u.tolist(), v.tolist())):
        side = SIDE
        number = int(y * side) * side + int(x * side)
        share, key = first.share[0, number], number
        while key in rows:
            block = first.block[rows[key]]
            side *= ACROSS
            column, row = int(x * side), int(y * side)
            share = block[row % ACROSS * ACROSS + column % ACROSS]
            key = SIDE**2 + row * side + column if side == SIDE * ACROSS else -1
        found[i] = float(share) * side**2
    return found


def test_tables_add_up_on_every_level():
    shares = uncut(np.random.default_rng(0).random((3, SIDE * SIDE)) ** 4).share
    tables = guide_tables(shares, SIDE)
    assert tables.shape == (3, 4 + 16 + 64 + 256 + 1024)
    for first, last in ((0, 4), (4, 20), (20, 84), (84, 340), (340, 1364)):
        np.testing.assert_allclose(tables[:, first:last].sum(axis=1), 1.0, rtol=1e-6)
    quarter = shares.reshape(3, SIDE, SIDE)[:, : SIDE // 2, SIDE // 2 :].sum(axis=(1, 2))
    np.testing.assert_allclose(tables[:, 1], quarter, rtol=1e-6)


def test_shares_are_bounded_below_and_even_without_light():
    """Next to the one bright part the mean squares are 1, 2 and 4 sixteenths of its own, so shares are 1, √2 and 2."""
    one = np.zeros((1, SIDE * SIDE))
    np.testing.assert_allclose(uncut(one).share, 1.0 / SIDE**2)
    one[0, 5 * SIDE + 7] = 3.0
    share = uncut(one).share.reshape(SIDE, SIDE)
    assert share.min() == pytest.approx(EVEN_SHARE / SIDE**2, rel=1e-6)
    expected = np.sqrt(np.outer([1, 2, 1], [1, 2, 1]))
    np.testing.assert_allclose(
        share[4:7, 6:9], EVEN_SHARE / SIDE**2 + (1 - EVEN_SHARE) * expected / expected.sum(), rtol=1e-6
    )


def test_the_warp_follows_the_shares(device):
    """Of 400 × 400 even points each part gets its share, up to those that lie at its rim."""
    guides = uncut(np.random.default_rng(1).random((1, SIDE * SIDE)) ** 3)
    found = warped(device, guides, *even_points(400), kind=1)
    part = np.floor(found[:, :2] * SIDE).astype(int)
    number = part[:, 1] * SIDE + part[:, 0]
    counted = np.bincount(number, minlength=SIDE * SIDE) / len(found)
    np.testing.assert_allclose(counted, guides.share[0], atol=2e-4)
    np.testing.assert_allclose(1.0 / (found[:, 2] * SIDE**2), guides.share[0][number], rtol=1e-5)


def test_weights_make_the_warp_even_again(device):
    """Means of weight times f are integrals over the square, here of polynomials."""
    guides = uncut(np.random.default_rng(2).random((1, SIDE * SIDE)) ** 6)
    for some, kind in ((guides, 1), (guides, 2), (gap_guides(), 2)):
        u, v, weight = warped(device, some, *even_points(1000), kind=kind).astype(np.float64).T
        for value, exact in ((u * 0 + 1, 1.0), (u, 0.5), (v * v, 1 / 3), (u * v, 0.25)):
            assert (weight * value).mean() == pytest.approx(exact, rel=2e-3)


def test_even_shares_change_nothing(device):
    u, v = even_points(50)
    found = warped(device, uncut(np.zeros((1, SIDE * SIDE))), u, v, kind=1)
    np.testing.assert_allclose(found, np.column_stack([u, v, np.ones(len(u))]), atol=2e-7)


def test_what_is_cut_keeps_its_share():
    """All shares add up to 1, the parts of a block to what it is cut from, and none is below the even one."""
    guides = gap_guides()
    np.testing.assert_allclose(guides.share.sum(axis=1), 1.0, rtol=1e-6)
    assert guides.blocks[1] == 0
    assert guides.blocks[0] > 60
    for reading in range(3):
        some = guides.some(np.array([reading]))
        coarse = some.key < SIDE**2
        np.testing.assert_allclose(some.block[coarse].sum(axis=1), some.share[0, some.key[coarse]], rtol=1e-6)
        y, x = np.divmod(some.key[~coarse].astype(int) - SIDE**2, SIDE * ACROSS)
        parent = np.searchsorted(some.key[coarse], y // ACROSS * SIDE + x // ACROSS)
        of_parent = some.block[coarse][parent, y % ACROSS * ACROSS + x % ACROSS]
        np.testing.assert_allclose(some.block[~coarse].sum(axis=1), of_parent, rtol=1e-6)
        assert (some.block[coarse] * (SIDE * ACROSS) ** 2 > 0.999 * EVEN_SHARE).all()
        assert (some.block[~coarse] * (SIDE * ACROSS**2) ** 2 > 0.999 * EVEN_SHARE).all()


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0005, 0.01), st.floats(0.0, 1.0), st.floats(-1.0, 1.0))
def test_the_warp_has_the_density_of_the_shares(device, seed, width, at, slope):
    """Weights are 1 over the density where the point ends, for strips of any width, place and slope."""
    pilot = MadeUpPilot(1, lambda point, u, v: np.where(np.abs(v - at - slope * (u - 0.5)) < width, 30.0, 0.1))
    guides = make_guides(pilot, np.zeros(1), 1024)
    u, v = np.random.default_rng(seed).random((2, 50_000), np.float32)
    found = warped(device, guides, u, v).astype(np.float64)
    some = slice(0, 400)
    inside = found[some, :2] * SIDE * ACROSS**2 % 1.0 > 1e-6
    sure = inside.all(axis=1)
    expected = density(guides, found[some, 0], found[some, 1])
    np.testing.assert_allclose(1.0 / found[some, 2][sure], expected[sure], rtol=1e-5)
    assert found[:, 2].mean() == pytest.approx(1.0, abs=6 * found[:, 2].std() / np.sqrt(len(found)))


def test_cuts_leave_little_of_the_noise(device):
    """Of a gap that is a tenth of each part: without bias, and with less than a seventh of the variance."""
    rng = np.random.default_rng(8)
    u, v = rng.random((2, 400_000))
    cut = gap_guides()
    variance, error = [], []
    at = (np.arange(4096) + 0.5) / 4096
    exact = slanting_gap(0, *np.meshgrid(at, at)).mean()
    for guides in (replace(cut, blocks=np.zeros(3, np.int64), key=cut.key[:0], block=cut.block[:0]), cut):
        found = warped(device, guides, u, v).astype(np.float64)
        value = found[:, 2] * slanting_gap(0, found[:, 0], found[:, 1])
        variance.append(value.var())
        error.append((value.mean() - exact) / (value.std() / np.sqrt(len(value))))
    assert 7 * variance[1] < variance[0]
    assert np.abs(error).max() < 4.0


def test_nothing_is_cut_without_contrasts():
    """Nor where they hardly matter, beside light that needs no paths."""
    even = MadeUpPilot(2, lambda point, u, v: 1.0 + u + 0 * point)
    assert len(make_guides(even, np.zeros(2), 256).key) == 0
    bright = make_guides(MadeUpPilot(3, slanting_gap), np.array([0.0, 0.0, 1e4]), 256)
    assert bright.blocks[0] > 0
    assert bright.blocks[2] == 0


def test_guides_of_some_readings_are_theirs():
    guides = gap_guides()
    chosen = np.array([2, 0, 2])
    some = guides.some(chosen)
    alone = Guides.joined([guides.some(np.array([i])) for i in chosen])
    for name, array in vars(some).items():
        np.testing.assert_array_equal(array, getattr(alone, name))
    np.testing.assert_array_equal(some.blocks, guides.blocks[chosen])
    assert guides.some(np.array([1])).key.size == 0


def test_efforts_are_made_of_their_arrays():
    effort = Effort(np.ones((3, 2)), np.eye(3, 2) > 0, np.arange(3), gap_guides(), np.full(3, 2))
    again = Effort.of_arrays(effort.arrays)
    for name, array in effort.arrays.items():
        np.testing.assert_array_equal(again.arrays[name], array)


def sky_window(width):
    """A black box with a square hole in its roof, under an even sky; a reading on the floor's middle."""
    b = SceneBuilder(1, sky=Sky(np.ones(1)))
    black, low, high = b.material(0.0), 0.5 - width / 2, 0.5 + width / 2
    for corner, eu, ev in (
        ((0, 0, 0), (0, 0, 1), (0, 1, 0)), ((1, 0, 0), (0, 1, 0), (0, 0, 1)), ((0, 0, 0), (1, 0, 0), (0, 0, 1)),
        ((0, 1, 0), (0, 0, 1), (1, 0, 0)), ((0, 0, 0), (0, 1, 0), (1, 0, 0)),
        ((0, 0, 1), (1, 0, 0), (0, low, 0)), ((0, high, 1), (1, 0, 0), (0, low, 0)),
        ((0, low, 1), (low, 0, 0), (0, width, 0)), ((high, low, 1), (low, 0, 0), (0, width, 0)),
    ):  # fmt: skip
        b.patch(corner, eu, ev, black)
    b.sensor((0.5, 0.5, 0.001), (0, 0, 1))
    return b.scene()


def test_sky_through_a_small_hole(device):
    """A hole of 0.6 % of the view; E = π F with F = (4 / π) (a / √(1 + a²)) atan(a / √(1 + a²)) at height 1.

    Even directions would leave a standard error of 20 % with these 4096 paths, and none of less than 4 % by luck.
    """
    a = 0.05 / 0.999
    side = a / np.sqrt(1 + a * a)
    exact = 4 * side * np.arctan(side)
    found = [
        next(iter(solve(sky_window(0.1), Options(gather_samples=4096, seed=seed), device).readings.values())).irradiance
        for seed in range(4)
    ]
    np.testing.assert_allclose(found, exact, rtol=0.04)


def test_a_room_that_is_lit_through_a_gap(device):
    """Two rooms and a slit of 10 cm in the wall between: within the intervals, and these below 25 %."""
    b = SceneBuilder(1)
    white = b.material(0.7)
    left = b.box((0, 0, 0), (2, 2, 2), white, inward=True)
    right = b.box((2, 0, 0), (4, 2, 2), white, inward=True)
    keep = [i for i in range(len(b.rows)) if i not in (left[1], right[0])]
    b.rows = [b.rows[i] for i in keep]
    for y, width in ((0.0, 0.95), (1.05, 0.95)):
        b.patch((2, y, 0), (0, width, 0), (0, 0, 2), white)
    b.lamp(b.patch((0.5, 0.5, 1.95), (0, 1, 0), (1, 0, 0), white), 100.0)
    b.sensor([(3.0, 1.0, 0.8), (3.5, 0.3, 0.5), (2.3, 1.7, 1.5)], [(0, 0, 1), (-1, 0, 0), (0, -1, 0)])
    scene = b.scene()
    solver = RadiositySolver(scene, Options(), device)
    for _ in solver.states():
        pass
    guides = "readings/effort/guide/"
    assert any(name.startswith(guides) and len(array) > 100 for name, array in solver.checkpoint().items())
    (readings,) = solver.solution().readings.values()
    on_device = upload_scene(device, scene, build_bvh(device, scene.patches), occlusion=True)
    sensor = scene.sensors[0]
    truth = trace_referee(on_device, scene, sensor.position, sensor.normal, paths=65536, seed=3)
    allowed = 1.5 * readings.half_width + 3 * truth.standard_error + 0.03 * truth.irradiance
    assert (np.abs(readings.irradiance - truth.irradiance) < allowed).all()
    assert (readings.half_width < 0.25 * readings.irradiance).all()

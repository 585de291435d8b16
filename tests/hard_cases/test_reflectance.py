"""Cases 34 to 39 and 55: reflectances of nothing, of nearly everything, of everything, and impossible ones."""

from dataclasses import replace

import numpy as np
import pytest
import scene_writing
from rooms import SceneBuilder, cube
from scipy.sparse import csr_array
from truths import QUICK, only, rectangle_factor, uploaded

from hradiosity.errors import SceneError
from hradiosity.radiosity import solve
from hradiosity.reference.radiosity import solve_dense
from hradiosity.space.hierarchy import build_elements
from hradiosity.space.lit_sides import find_lit_sides
from hradiosity.transport.device_scene import upload_elements
from hradiosity.transport.exchange import build_exchange, trace_rows


def test_case_34_nothing_reflects(device):
    """E is the direct light, by Lambert's formula, and nothing is iterated."""
    room = cube(0.0)
    room.lamp(5, 10.0)
    room.sensor([(0.5, 0.5, 0.0), (0.2, 0.9, 0.3)], (0, 0, 1))
    solution = solve(room.scene(), QUICK, device)
    exact = [10.0 * rectangle_factor(p, (0, 0, 1), (0, 0, 1), (1, 0, 0), (0, 1, 0)) for p in only(solution).position]
    np.testing.assert_allclose(only(solution).irradiance[:, 0], exact, rtol=1e-5)
    np.testing.assert_array_less(only(solution).half_width, 3e-5 * only(solution).irradiance)
    assert not solution.plan.interreflection and solution.record["solver"] == []
    np.testing.assert_array_equal(solution.surfaces.irradiance, solution.surfaces.direct)


@pytest.mark.parametrize("rho", [0.99, 0.999])
def test_case_35_bright_closed_room_with_even_emission(device, rho):
    """E = M / (1 − ρ) on every element and at every reading, in few products.

    Single precision holds ρ to 6e-8, which is 6e-8 / (1 − ρ) of the light.
    """
    room = cube(rho)
    room.lamp(range(6), 1.0 - rho)
    room.sensor([(0.5, 0.5, 0.5), (0.1, 0.2, 0.0)], (0, 0, 1))
    solution = solve(room.scene(), QUICK, device)
    tolerance = max(1e-5, 6e-8 / (1.0 - rho))
    np.testing.assert_allclose(solution.surfaces.irradiance, 1.0, rtol=tolerance)
    np.testing.assert_allclose(only(solution).irradiance, 1.0, rtol=tolerance)
    assert max(c["products"] for c in solution.record["solver"]) <= 12


@pytest.mark.parametrize("rho", [0.99, 0.999])
def test_case_35_bright_closed_room_with_one_lamp(device, rho):
    """Flux balance: (1 − ρ) Σ A E = A M over the elements, in few products."""
    room = cube(rho)
    room.lamp(5, 1.0)
    solution = solve(room.scene(), replace(QUICK, tolerance=1e-5, glow=False, light_points=256), device)
    area = solution.elements.area
    sent = area @ solution.surfaces.direct[:, 0]
    assert (1.0 - rho) * (area @ solution.surfaces.irradiance[:, 0]) == pytest.approx(sent, rel=2e-4)
    assert sent == pytest.approx(1.0, rel=5e-3)
    default = solve(room.scene(), QUICK, device)
    assert max(c["products"] for c in default.record["solver"]) <= 12


WHITE_BOX = """
[materials.white]
reflectance = { steps = [[380, 560, 0.5], [560, 740, 1.0]] }
[materials.grey]
reflectance = 0.5
[luminaires.lamp]
spectrum = { constant = 1.0 }
absolute = true
[[box]]
name = "room"
corner = [0.0, 0.0, 0.0]
size = [1.0, 1.0, 1.0]
inside = true
faces = { sides = "white", top = "white", bottom = "FLOOR" }
[[point_source]]
name = "bulb"
position = [0.5, 0.5, 0.5]
luminaire = "lamp"
[[sensor]]
name = "eye"
kind = "points"
positions = [[0.5, 0.5, 0.2]]
normal = [0.0, 0.0, 1.0]
"""
BANDS = '[scene]\nunit = "m"\nbands = { first = 400, last = 720, step = 40 }\n'
OUTBUILDING = """
[[rectangle]]
name = "field"
corner = [5.0, 0.0, 0.0]
edge_u = [1.0, 0.0, 0.0]
edge_v = [0.0, 1.0, 0.0]
material = "grey"
"""


def test_case_36_a_closed_white_room_is_refused(tmp_path):
    (fault,) = scene_writing.faults(tmp_path, BANDS + WHITE_BOX.replace("FLOOR", "white"))
    assert "reflect everything at 600 nm: light would grow without end" in fault


def test_case_36_so_is_one_beside_which_something_absorbs(device, tmp_path):
    """The rays tell that the grey field is in another space."""
    scene = scene_writing.load(tmp_path, BANDS + WHITE_BOX.replace("FLOOR", "white") + OUTBUILDING)
    with pytest.raises(SceneError, match="closed space around 'room' reflects everything at 600 nm"):
        solve(scene, QUICK, device)


def test_case_36_and_one_made_in_python(device):
    room = cube(1.0)
    room.lamp(5, 1.0)
    with pytest.raises(SceneError, match=r"reflects everything at 502\.5 nm"):
        solve(room.scene(), QUICK, device)


def test_case_37_white_walls_over_a_black_floor(device):
    """All that the ceiling sends ends on the floor: its mean irradiance is the ceiling's exitance."""
    room = cube([1.0, 1.0, 1.0, 1.0, 0.0, 1.0])
    room.lamp(5, 3.0)
    solution = solve(room.scene(), replace(QUICK, tolerance=1e-5, glow=False, light_points=256), device)
    floor = solution.elements.row_material == 4
    area = solution.elements.area
    sent = area @ solution.surfaces.direct[:, 0]
    absorbed = area[floor] @ solution.surfaces.irradiance[floor, 0]
    assert absorbed == pytest.approx(sent, rel=2e-4)
    assert absorbed == pytest.approx(3.0, rel=5e-3)


WRONG = {
    "above one": ("[[380, 560, 0.5], [560, 600, 1.2], [600, 740, 0.5]]", "reflectance 1.2 at 580 nm"),
    "below zero": ("[[380, 560, 0.5], [560, 600, -0.1], [600, 740, 0.5]]", "reflectance -0.1 at 580 nm"),
    "no number": ("[[380, 560, 0.5], [560, 600, nan], [600, 740, 0.5]]", "nan"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_case_38_impossible_reflectance_in_one_band(tmp_path, kind):
    steps, message = WRONG[kind]
    paint = f"[materials.paint]\nreflectance = {{ steps = {steps} }}\n"
    header = '[scene]\nunit = "m"\nbands = { first = 420, last = 700, step = 40 }\n'
    text = header + paint + scene_writing.LAMP + scene_writing.FLOOR + scene_writing.PANEL
    found = scene_writing.faults(tmp_path, text)
    assert len(found) == 1 and "materials.paint.reflectance" in found[0] and message in found[0], found


def test_case_38_no_number_in_a_measured_table(tmp_path):
    (tmp_path / "paint.csv").write_text("wavelength,reflectance\n400,0.5\n550,nan\n700,0.5\n")
    text = scene_writing.OPEN_ROOM.replace("reflectance = 0.5", 'reflectance = { file = "paint.csv" }')
    (fault,) = scene_writing.faults(tmp_path, text)
    assert "paint.csv" in fault and "nan" in fault and "550" in fault, fault


def three_bands(which):
    b = cube(bands=len(which))
    b.materials.clear()
    b.rows.clear()
    rng = np.random.default_rng(0)
    rho = rng.uniform(0.5, 0.9, (6, 3)) * [1.0, 0.0, 1.0]
    b.box((0, 0, 0), (1, 1, 1), [b.material(r[which]) for r in rho], inward=True)
    b.lamp(5, np.array([1.0, 2.0, 3.0])[which])
    b.sensor([(0.5, 0.5, 0.5), (0.2, 0.3, 0.1)], (0, 0, 1))
    return b.scene()


def test_case_39_one_band_black_and_the_others_bright(device):
    """Rows and direct light are those of each band alone, so light on the surfaces is, to the solver's tolerance."""
    options = replace(QUICK, reduced_basis=False, glow=False, tolerance=1e-6)
    together = solve(three_bands([0, 1, 2]), options, device)
    for k in range(3):
        alone = solve(three_bands([k]), options, device)
        np.testing.assert_array_equal(together.surfaces.direct[:, k], alone.surfaces.direct[:, 0])
        np.testing.assert_allclose(together.surfaces.irradiance[:, k], alone.surfaces.irradiance[:, 0], rtol=2e-6)
    np.testing.assert_array_equal(together.surfaces.irradiance[:, 1], together.surfaces.direct[:, 1])
    exact = [2.0 * rectangle_factor(p, (0, 0, 1), (0, 0, 1), (1, 0, 0), (0, 1, 0)) for p in only(together).position]
    np.testing.assert_allclose(only(together).irradiance[:, 1], exact, rtol=1e-5)


def test_case_55_rows_that_do_not_close_are_closed(device):
    """Few rays from elements of unlike sizes: made symmetric without closure, the even room of ρ = 0.99 is far off."""
    rho = 0.99
    b = SceneBuilder()
    paint = b.material(rho)
    b.box((0, 0, 0), (4, 4, 0.5), paint, inward=True)
    for k in range(3):
        b.box((k + 0.5, 0.5, 0.0), (k + 0.55, 3.5, 0.4), paint, solid=True)
    b.lamp(range(6), 1.0 - rho)
    scene = b.scene()
    on_device = uploaded(scene, device)
    lit = find_lit_sides(scene, on_device.bvh)
    elements = build_elements(scene.patches, lit.space, np.ones(1, bool), 0.4)
    hits = trace_rows(on_device, upload_elements(device, elements), 16, seed=1)
    exchange = build_exchange(hits, elements)
    n = len(elements)
    closed = csr_array((exchange.area, exchange.source, exchange.start), shape=(n, n)).toarray()
    area = exchange.element_area
    np.testing.assert_allclose(closed, closed.T, rtol=1e-12, atol=0)
    np.testing.assert_allclose(closed.sum(axis=1), area, rtol=1e-12)
    np.testing.assert_allclose(even_light(closed, area, rho), 1.0, rtol=1e-9)
    found = np.zeros((n, n))
    np.add.at(found, (np.repeat(np.arange(n), 16), np.minimum(hits.row, n - 1).ravel()), (hits.row < n).ravel() / 16.0)
    found *= elements.area[:, None]
    naive = even_light(0.5 * (found + found.T), area, rho)
    assert np.abs(naive - 1.0).max() > 0.3


def even_light(exchange, area, rho):
    """Irradiance where all surfaces emit 1 − ρ: 1 if rows close."""
    kept = area > 0.0
    direct = (1.0 - rho) * exchange[np.ix_(kept, kept)].sum(axis=1) / area[kept]
    n = int(kept.sum())
    return solve_dense(exchange[np.ix_(kept, kept)], area[kept], np.full((n, 1), rho), direct[:, None])[:, 0]

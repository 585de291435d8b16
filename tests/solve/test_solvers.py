"""Every solver against dense float64 solutions, and what each of them promises."""

import hashlib
import json
import os
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from box_rooms import CASES, box_room
from test_krylov import closed_space, exchange_of, two_spaces

from hradiosity.errors import SceneError
from hradiosity.options import Options
from hradiosity.radiosity import RadiositySolver
from hradiosity.radiosity.checkpoint import pack_record, unpack_record
from hradiosity.radiosity.record import Record
from hradiosity.reference.form_factors import parallel_rectangles, perpendicular_rectangles
from hradiosity.reference.radiosity import solve_dense
from hradiosity.solvers import dense
from hradiosity.solvers.choice import SolverChoice, solve_system
from hradiosity.solvers.deflation import deflation_vectors
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.stored_shooting import Shooter
from hradiosity.solvers.system import System
from hradiosity.suites.bench_solvers import Case, follow
from hradiosity.suites.solver_rooms import furnished, two_rooms

ITERATIVE = ["cg", "southwell", "overshooting", "jacobi", "gauss-seidel", "auto"]
DIRECT = ["gaussian-elimination", "block-inversion"]
SOLVERS = ITERATIVE + DIRECT


def box(x=4.0, y=3.0, z=2.5):
    """Exchange areas and areas of the six faces of a box, by closed forms."""
    area = np.array([y * z, y * z, x * z, x * z, x * y, x * y])
    length = {0: x, 1: y, 2: z}
    matrix = np.zeros((6, 6))
    for i in range(6):
        for j in range(6):
            a, b = i // 2, j // 2
            if i != j and a == b:
                matrix[i, j] = area[i] * parallel_rectangles(*(length[k] for k in range(3) if k != a), length[a])
            elif a != b:
                common = length[3 - a - b]
                matrix[i, j] = area[i] * perpendicular_rectangles(common, length[b], length[a])
    return matrix, area


def solved(device, name, matrix, area, reflectance, direct, dtype=np.float32, *, spaces=None, blocks=3, **options):
    columns = direct.shape[1]

    def padded(values):
        out = np.zeros((len(area), 8 * -(-columns // 8)), dtype)
        out[:, :columns] = values
        return out

    operator = ExchangeOperator(device, exchange_of(matrix, area), dtype)
    spaces = np.zeros(len(area), np.int32) if spaces is None else spaces
    found = solve_system(
        SolverChoice(name, blocks=blocks),
        operator,
        padded(reflectance),
        padded(direct),
        deflation=deflation_vectors(operator, spaces),
        **options,
    )
    assert found.irradiance.dtype == dtype and not found.irradiance[:, columns:].any()
    assert found.convergence.solver == name
    return found.irradiance[:, :columns], found.convergence


def test_the_box_is_closed_and_reciprocal():
    matrix, area = box()
    np.testing.assert_allclose(matrix.sum(axis=1), area, rtol=1e-12)
    np.testing.assert_allclose(matrix, matrix.T, rtol=1e-12)


@pytest.mark.parametrize("bands", [1, 81])
@pytest.mark.parametrize("name", SOLVERS)
def test_box_by_closed_form_factors(device, name, bands):
    """Reflectances from 0 to 0.95, another spectrum on each face, in single precision."""
    matrix, area = box()
    rng = np.random.default_rng(bands)
    reflectance = rng.uniform(0.0, 0.95, (6, bands))
    reflectance[:, -1] = 0.8 if bands == 1 else 0.95
    reflectance[:, 0] *= bands == 1
    direct = rng.random((6, bands)) ** 3
    found, convergence = solved(device, name, matrix, area, reflectance, direct, tolerance=2e-5)
    assert convergence.converged and convergence.seconds >= 0.0 and convergence.products > 0.0
    np.testing.assert_allclose(found, solve_dense(matrix, area, reflectance, direct), rtol=4e-4)
    if bands > 1:
        np.testing.assert_array_equal(found[:, 0], direct[:, 0].astype(np.float32))


@pytest.mark.parametrize("name", SOLVERS)
def test_white_room_in_double_precision(device, name):
    """Reflectance 0.999: a thousand reflections; those that can't hurry take thousands of products."""
    matrix, area = closed_space(np.random.default_rng(1), 40)
    direct = np.zeros((40, 1))
    direct[3] = 1.0
    reflectance = np.full((40, 1), 0.999)
    slow = {"jacobi": {"tolerance": 1e-2}, "gauss-seidel": {"tolerance": 1e-3}, "southwell": {"tolerance": 1e-3}}
    options = slow.get(name, {"tolerance": 1e-7})
    found, convergence = solved(device, name, matrix, area, reflectance, direct, np.float64, **options)
    exact = solve_dense(matrix, area, reflectance, direct)
    assert convergence.converged
    # A residual r may leave an error of r / (1 - ρ) of what arrives first, which is a thousandth of all.
    np.testing.assert_allclose(found, exact, rtol=3.0 * options["tolerance"])


@pytest.mark.parametrize("name", SOLVERS)
def test_spaces_that_are_not_connected(device, name):
    """A bright space, a dim one; in the second column only the dim one has light, and the other stays exactly dark."""
    matrix, area, spaces = two_spaces(np.random.default_rng(4))
    direct = np.zeros((150, 2))
    direct[:10, 0], direct[60:65] = 1.0, 1e-12
    reflectance = np.where(spaces[:, None] == 0, 0.05, 0.7) * np.ones((1, 2))
    found, convergence = solved(device, name, matrix, area, reflectance, direct, spaces=spaces, tolerance=1e-5)
    assert convergence.converged
    np.testing.assert_allclose(found, solve_dense(matrix, area, reflectance, direct), rtol=5e-4)
    assert not found[:60, 1].any() and found[60:, 1].all()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", SOLVERS)
def test_nothing_to_do(device, name):
    """No light, no reflectance, elements without area or links."""
    matrix, area = box()
    full, full_area = np.zeros((8, 8)), np.zeros(8)
    full[:6, :6], full_area[:6], full_area[7] = matrix, area, 1.0
    dark, _ = solved(device, name, full, full_area, np.full((8, 1), 0.5), np.zeros((8, 1)), tolerance=1e-4)
    assert not dark.any()
    direct = np.arange(8.0)[:, None]
    black, _ = solved(device, name, full, full_area, np.zeros((8, 1)), direct, tolerance=1e-4)
    np.testing.assert_array_equal(black, direct)
    found, _ = solved(device, name, full, full_area, np.full((8, 1), 0.5), direct, tolerance=1e-5)
    np.testing.assert_allclose(found, solve_dense(full, full_area, np.full((8, 1), 0.5), direct), rtol=1e-4)


@pytest.mark.parametrize("name", ITERATIVE)
def test_a_start_shortens_the_way(device, name):
    matrix, area = closed_space(np.random.default_rng(7), 60)
    reflectance, direct = np.full((60, 8), 0.8), np.random.default_rng(8).random((60, 8))
    exact = solve_dense(matrix, area, reflectance, direct)
    _, cold = solved(device, name, matrix, area, reflectance, direct, tolerance=1e-4)
    found, warm = solved(
        device, name, matrix, area, reflectance, direct, tolerance=1e-4, start=(exact - direct) * 1.001
    )
    assert warm.converged and warm.products < cold.products
    np.testing.assert_allclose(found, exact, rtol=2e-3)


def small_lamp_over_a_large_floor():
    """Six elements of areas from 0.01 m² to 400 m²; the lamp faces the floor, which sees little of it."""
    area = np.array([0.01, 400.0, 30.0, 30.0, 5.0, 1.0])
    weight = np.outer(area, area) / (area[:, None] + area) ** 1.2
    np.fill_diagonal(weight, 0.0)
    weight[1, 1] = 1.0
    for _ in range(3000):
        scale = np.sqrt(area / weight.sum(axis=1))
        weight *= scale[:, None] * scale
    assert np.abs(weight.sum(axis=1) / area - 1.0).max() < 1e-6
    return weight, area


@pytest.mark.parametrize("overshoot", [False, True])
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float32, 3e-6), (np.float64, 1e-14)])
def test_shooting_and_gathering_agree_after_every_shot(device, overshoot, dtype, tolerance):
    """x = d + S y, and what gathering still lacks, d + S ρ x − x, is S u: no link is counted twice or left out."""
    matrix, area = small_lamp_over_a_large_floor()
    reflectance = np.random.default_rng(2).uniform(0.1, 0.9, (6, 8)).astype(dtype)
    direct = np.zeros((6, 8), dtype)
    direct[1:5] = (matrix[1:5, 0] / area[1:5])[:, None] * 1e4
    operator = ExchangeOperator(device, exchange_of(matrix, area), dtype)
    system = System("southwell", operator, reflectance, direct, tolerance=1e-9)
    shooter = Shooter(system, np.ones(8), overshoot=overshoot)
    links = matrix / np.sqrt(area[:, None] * area)
    for _ in range(40):
        light, unshot = shooter.light.astype(float), shooter.unshot.astype(float)
        scale = light.max()
        shot = reflectance * light - unshot
        np.testing.assert_allclose(system.direct + links @ shot, light, atol=tolerance * scale)
        lacking = system.direct + links @ (reflectance * light) - light
        np.testing.assert_allclose(links @ unshot, lacking, atol=tolerance * scale)
        shooter.shoot(1)
    assert system.shots == pytest.approx(40 / 6)
    exact = solve_dense(matrix, area, reflectance.astype(float), direct.astype(float))
    for _ in range(400):
        shooter.shoot(1)
    np.testing.assert_allclose(system.irradiance(shooter.light), exact, rtol=1e-4)


def test_the_brightest_shoots_first(device):
    matrix, area = box()
    direct = np.zeros((6, 8))
    direct[4, 0], direct[5, 1] = 3.0, 1.0
    operator = ExchangeOperator(device, exchange_of(matrix, area), np.float64)
    system = System("southwell", operator, np.full((6, 8), 0.5), direct, tolerance=1e-9)
    shooter = Shooter(system, np.array([0.1, 1.0, 1, 1, 1, 1, 1, 1]), overshoot=False)
    shooter.shoot(1)
    assert not shooter.unshot[5, 1] and shooter.unshot[4, 0] > 0.0


@pytest.mark.parametrize("open_share", [0.0, 0.6])
def test_overshooting_converges_faster_and_where_most_light_leaves(device, open_share):
    matrix, area = closed_space(np.random.default_rng(3), 120)
    matrix *= 1.0 - open_share
    reflectance, direct = np.full((120, 8), 0.95), np.zeros((120, 8))
    direct[:5] = np.random.default_rng(4).random((5, 8))
    exact = solve_dense(matrix, area, reflectance, direct)
    plain, ahead = (
        solved(device, name, matrix, area, reflectance, direct, np.float64, tolerance=1e-6)
        for name in ("southwell", "overshooting")
    )
    for found, convergence in (plain, ahead):
        assert convergence.converged
        np.testing.assert_allclose(found, exact, rtol=1e-4)
    if open_share == 0.0:
        assert ahead[1].products < 0.5 * plain[1].products


TABLE = {
    ("jacobi", 0.5): (9, 19),
    ("jacobi", 0.8): (30, 61),
    ("jacobi", 0.95): (134, 269),
    ("gauss-seidel", 0.5): (6, 11),
    ("gauss-seidel", 0.8): (16, 32),
    ("gauss-seidel", 0.95): (68, 136),
    ("southwell", 0.5): (4.6, 10),
    ("southwell", 0.8): (15, 31),
    ("cg", 0.5): (6, 9),
    ("cg", 0.95): (8, 12),
    ("cg", 0.999): (8, 12),
    ("cg + deflation", 0.5): (5, 8),
    ("cg + deflation", 0.95): (5, 9),
}
"""Products to 1e-3 and 1e-6 in a furnished room, measured by another program."""
SET_UP = 1
"""Products that preparing a deflation vector takes, which the table leaves out."""


@pytest.fixture(scope="module")
def room(device):
    return furnished(device)


@pytest.mark.parametrize(("solver", "level"), TABLE)
def test_products_are_those_of_the_literature(device, room, solver, level):
    history = follow(device, Case("", room, np.full(len(room.direct), level)), solver)
    counts = np.array([history.products_to(accuracy) for accuracy in (1e-3, 1e-6)])
    counts -= SET_UP * (solver == "cg + deflation")
    within = 0.35 if solver.startswith("cg") else 0.3
    assert np.all(np.abs(counts / np.array(TABLE[solver, level]) - 1.0) < within), counts


def test_steps_of_deflated_gradients_next_to_no_absorption(device, room):
    """2 and 7 of the literature, where the right-hand side and the last reflection are no steps."""
    history = follow(device, Case("", room, np.full(len(room.direct), 0.999)), "cg + deflation")
    assert [history.products_to(accuracy) - SET_UP - 2 for accuracy in (1e-3, 1e-6)] == [2, pytest.approx(7, abs=1)]


def test_two_joined_rooms(device):
    pair = two_rooms(device)
    case = Case("", pair, np.full(len(pair.direct), 0.99))
    assert follow(device, case, "gauss-seidel").products_to(1e-3) == pytest.approx(345, rel=0.3)
    assert follow(device, case, "cg + deflation").products_to(1e-6) - SET_UP <= 13


def test_auto_shoots_first_and_says_who_did_what(device):
    matrix, area = closed_space(np.random.default_rng(5), 80)
    direct = np.random.default_rng(6).random((80, 8))
    seen = []
    bright, account = solved(
        device, "auto", matrix, area, np.full((80, 8), 0.9), direct, tolerance=1e-4, watch=seen.append
    )
    assert [stage.solver for stage in account.stages] == ["southwell", "cg"]
    assert sum(stage.products for stage in account.stages) == pytest.approx(account.products)
    assert [progress.solver for progress in seen] == sorted((p.solver for p in seen), reverse=True)
    assert seen[0].irradiance().shape == (80, 8)
    assert account.stages[0].products < 4.0
    unseen, _ = solved(device, "auto", matrix, area, np.full((80, 8), 0.9), direct, tolerance=1e-4)
    np.testing.assert_array_equal(bright, unseen)
    _, dim = solved(device, "auto", matrix, area, np.full((80, 8), 5e-4), direct, tolerance=1e-3)
    assert [stage.solver for stage in dim.stages] == ["southwell"]


def test_direct_solvers_state_their_errors(device):
    """A residual of rounding; the condition number of a grey closed room lies near (1 + ρ/2) / (1 − ρ)."""
    matrix, area = closed_space(np.random.default_rng(9), 100)
    direct = np.random.default_rng(10).random((100, 1))
    for name in DIRECT:
        _, account = solved(
            device, name, matrix, area, np.full((100, 1), 0.99), direct, np.float64, tolerance=1e-9, blocks=7
        )
        assert account.backward_error < 1e-14
        assert 50.0 < account.condition < 2000.0


@pytest.mark.parametrize("blocks", [1, 2, 7, 30])
def test_inverse_by_blocks(blocks):
    matrix, area = closed_space(np.random.default_rng(11), 30)
    system = np.eye(30) - 0.99 * matrix / area[:, None]
    inverse = dense.invert_by_blocks(system, blocks)
    np.testing.assert_allclose(inverse @ system, np.eye(30), atol=1e-11)


def test_direct_solvers_refuse_what_does_not_fit(device, monkeypatch):
    with pytest.raises(SceneError, match=r"100000 × 100000 elements, 3\.2e\+11 bytes"):
        dense.check_dense_size(100_000, "gaussian-elimination")
    monkeypatch.setattr(dense, "MOST_BYTES", 1000)
    options = Options(element_size=1.0, solver="block-inversion")
    with pytest.raises(SceneError, match="block-inversion would hold"):
        RadiositySolver(box_room(CASES["room443-panel-752"]), options, device).plan  # noqa: B018


@pytest.mark.parametrize("wrong", [{"solver": "magic"}, {"blocks": 0}, {"mode": "classic", "solver": "jacobi"}])
def test_senseless_solvers_are_refused(wrong):
    with pytest.raises(ValueError, match=r"solver|blocks"):
        Options(**wrong)


def test_a_run_by_each_solver_reads_the_same(device):
    """The same random numbers, so that what differs is the solvers' tolerance; plan and record name the solver."""
    scene = box_room(CASES["room443-panel-752"])
    found = {}
    for name in SOLVERS:
        solver = RadiositySolver(
            scene, Options.of_quality("draft", element_size=1.0, replicates=2, solver=name), device
        )
        assert any(line.startswith(f"solver: {name}") for line in solver.plan.lines())
        for _ in solver.states():
            pass
        solution = solver.solution()
        assert {account["solver"] for account in solution.record["solver"]} == {name}
        found[name] = solution.readings["points"].illuminance
        assert unpack_record(pack_record(solver.record))[0].convergence == solver.record.convergence
    for name in SOLVERS:
        np.testing.assert_allclose(found[name], found["gaussian-elimination"], rtol=2e-3)


def test_an_account_survives_a_checkpoint(device):
    matrix, area = box()
    _, account = solved(device, "auto", matrix, area, np.full((6, 1), 0.9), np.ones((6, 1)), tolerance=1e-4)
    record = Record(convergence=[account])
    assert unpack_record(pack_record(record))[0].convergence == [account]
    assert json.loads(json.dumps(asdict(account)))["stages"][0]["solver"] == "southwell"


def bits(device) -> str:
    """Of all solvers on one system, in one digest."""
    matrix, area = closed_space(np.random.default_rng(12), 90)
    rng = np.random.default_rng(13)
    reflectance, direct = rng.uniform(0.0, 0.9, (90, 20)), rng.random((90, 20))
    digest = hashlib.sha256()
    for name in SOLVERS:
        digest.update(solved(device, name, matrix, area, reflectance, direct, tolerance=1e-4)[0].tobytes())
    return digest.hexdigest()


def test_threads_change_no_bit(device):
    here = Path(__file__).parent
    program = "import test_solvers; from hradiosity.device import Device; print(test_solvers.bits(Device()))"
    found = set()
    for threads in ("1", "2"):
        paths = os.pathsep.join([str(here), str(here.parent), *filter(None, sys.path)])
        environment = os.environ | {"POCL_MAX_PTHREAD_COUNT": threads, "PYTHONPATH": paths}
        done = subprocess.run(
            [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True, timeout=300
        )
        found.add(done.stdout.split()[-1])
    assert len(found) == 1

"""Work and time of every solver: ``python -m hradiosity.suites.bench_solvers [--out FOLDER]``.

Counts are products with the exchange, or what is worth one: a sweep, or as many shots as there are elements. They are
taken in double precision at the first step after which no element is further from a dense solution than 1e-3 and 1e-6
of the largest indirect light; what a solver needs to find that out is not counted. Seconds are CPU seconds of the
process in single precision, from the light of the lamp to a residual of 1e-3, all 81 columns at once.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final, get_args

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.options import SolverName
from hradiosity.solvers.choice import SolverChoice, solve_system
from hradiosity.solvers.deflation import deflation_vectors
from hradiosity.solvers.dense import DIRECT_SOLVERS, backward_error, gaussian_elimination, invert_by_blocks
from hradiosity.solvers.operator import ExchangeOperator
from hradiosity.solvers.result import Convergence, Progress, Watch
from hradiosity.suites.bench.figure import CPU, PRODUCTS, Figure, exact_figure, figure_of
from hradiosity.suites.bench.session import Session
from hradiosity.suites.solver_rooms import SolverRoom, furnished, two_rooms

LEVELS: Final = (1e-3, 1e-6)
MOST_PRODUCTS: Final = 2000.0
DEFLATED: Final = "cg + deflation"
ITERATIVE: Final = ("jacobi", "gauss-seidel", "southwell", "overshooting", "cg", DEFLATED, "auto")
BLOCKS: Final = (1, 2, 4, 8, 16, 32, 64)
COLUMNS: Final = 81
SPREAD: Final = 0.1
"""Half width of the reflectances around their mean, for the seconds."""


class _Enough(Exception):
    """The accuracy, or the end of patience, was reached."""


@dataclass(frozen=True)
class Case:
    """One room with one reflectance for each element, (n_rows,)."""

    name: str
    room: SolverRoom
    reflectance: NDArray[np.float64]


@dataclass(frozen=True)
class History:
    """One solver on one case; (products, residual, error) a step."""

    case: str
    solver: str
    steps: tuple[tuple[float, float, float], ...]

    def products_to(self, level: float) -> float:
        """Products to an error, infinite if it was not reached."""
        return next((products for products, _, error in self.steps if error <= level), np.inf)


def cases(device: Device) -> list[Case]:
    """Those of the table."""
    room, pair = furnished(device), two_rooms(device)
    n = len(room.direct)
    grey = [Case(f"ρ {level:g}", room, np.full(n, level)) for level in (0.5, 0.8, 0.95, 0.99, 0.999)]
    mixed = np.random.Generator(np.random.Philox(key=1)).uniform(0.05, 0.9, n)
    return [*grey, Case("U(.05, .9)", room, mixed), Case("two rooms .99", pair, np.full(len(pair.direct), 0.99))]


def follow(device: Device, case: Case, solver: str) -> History:
    """A solver's steps until the error is below the smallest level."""
    operator = ExchangeOperator(device, case.room.exchange, np.float64)
    reflectance, direct = (_first_of_eight(values) for values in (case.reflectance, case.room.direct))
    exact = gaussian_elimination(operator, reflectance, direct, tolerance=1e-12).irradiance[:, 0]
    scale = float(np.abs(exact - direct[:, 0]).max())
    steps: list[tuple[float, float, float]] = []

    def watch(progress: Progress) -> None:
        error = float(np.abs(progress.irradiance()[:, 0] - exact).max()) / scale
        steps.append((progress.products, progress.residual, error))
        if error <= LEVELS[-1] or progress.products > MOST_PRODUCTS:
            raise _Enough

    with suppress(_Enough):
        _run(operator, solver, reflectance, direct, 1e-10, watch=watch)
    return History(case.name, solver, tuple(steps))


def seconds(device: Device, room: SolverRoom, mean: float, solver: str) -> tuple[float, float]:
    """CPU seconds and products for all columns to a residual of 1e-3, kernels being built."""
    operator = ExchangeOperator(device, room.exchange)
    rng = np.random.Generator(np.random.Philox(key=2))
    spread = min(SPREAD, 1.0 - mean)
    reflectance = np.zeros((operator.n_rows, 8 * -(-COLUMNS // 8)))
    reflectance[:, :COLUMNS] = np.clip(mean + spread * rng.uniform(-1.0, 1.0, (operator.n_rows, COLUMNS)), 0.0, 0.999)
    direct = np.zeros_like(reflectance)
    direct[:, :COLUMNS] = room.direct[:, None]
    _run(operator, solver, np.zeros_like(reflectance), direct, 1e-3)
    account = _run(operator, solver, reflectance, direct, 1e-3)
    return account.seconds if account.converged else np.inf, account.products


def measure(session: Session) -> list[Figure]:
    """Products to an error of 1e-3 in two rooms, and CPU seconds, each solver."""
    device = session.device
    room, pair = furnished(device), two_rooms(device)
    chosen = [Case("ρ 0.95", room, np.full(len(room.direct), 0.95))]
    if not session.quick:
        chosen.append(Case("two rooms 0.8", pair, np.full(len(pair.direct), 0.8)))
    figures = []
    for case in chosen:
        for solver in ITERATIVE:
            products = follow(device, case, solver).products_to(LEVELS[0])
            if np.isfinite(products):
                figures.append(exact_figure(f"solvers: {solver}, {case.name} to 1e-3", products, PRODUCTS))
    large = room if session.quick else furnished(device, 0.24)
    for solver in ITERATIVE if session.quick else (*ITERATIVE, *DIRECT_SOLVERS):
        used, turns = (room, 2) if solver in DIRECT_SOLVERS else (large, 3)
        spent = [seconds(device, used, 0.95, solver)[0] for _ in range(turns)]
        if np.isfinite(spent).all():
            figures.append(figure_of(f"solvers: {solver}, {len(used.direct)} elements, {COLUMNS} bands", spent, CPU))
    return figures


def inversion_errors(device: Device, room: SolverRoom, level: float) -> list[tuple[int, float, float]]:
    """Blocks, backward error, and largest difference from elimination over the largest light."""
    operator = ExchangeOperator(device, room.exchange, np.float64)
    matrix = np.eye(operator.n_rows) - level * operator.dense()
    right = operator.root_area.astype(np.float64) * room.direct
    reflectance, direct = _first_of_eight(np.full(operator.n_rows, level)), _first_of_eight(room.direct)
    exact = gaussian_elimination(operator, reflectance, direct, tolerance=1e-12).irradiance[:, 0] * operator.root_area
    found = []
    for blocks in (*BLOCKS, operator.n_rows):
        light = invert_by_blocks(matrix, blocks) @ right
        error = float(np.abs(light - exact).max() / np.abs(exact).max())
        found.append((blocks, backward_error(matrix, light, right), error))
    return found


def _run(
    operator: ExchangeOperator,
    solver: str,
    reflectance: NDArray[np.float64],
    direct: NDArray[np.float64],
    tolerance: float,
    watch: Watch | None = None,
) -> Convergence:
    """By the name in the table."""
    name: SolverName = next((n for n in get_args(SolverName) if n == solver), "cg")
    with_vectors = solver in (DEFLATED, "auto")
    vectors = deflation_vectors(operator, np.zeros(operator.n_rows, np.int32)) if with_vectors else None
    choice = SolverChoice(name)
    found = solve_system(choice, operator, reflectance, direct, tolerance=tolerance, deflation=vectors, watch=watch)
    return found.convergence


def _first_of_eight(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n_rows, 8) with the values in the first column."""
    columns = np.zeros((len(values), 8))
    columns[:, 0] = values
    return columns


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Markdown."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def products_table(histories: Sequence[History]) -> str:
    """Products to both levels, a solver a line."""
    names = list(dict.fromkeys(h.case for h in histories))
    by_key = {(h.case, h.solver): h for h in histories}
    rows = [
        [solver, *(" / ".join(_number(by_key[name, solver].products_to(level)) for level in LEVELS) for name in names)]
        for solver in dict.fromkeys(h.solver for h in histories)
    ]
    return table(["solver", *names], rows)


def write_histories(path: Path, histories: Sequence[History]) -> None:
    """Every step of every solver as CSV."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["case", "solver", "products", "residual", "error"])
        writer.writerows([h.case, h.solver, *step] for h in histories for step in h.steps)


def draw_histories(path: Path, histories: Sequence[History]) -> None:
    """Error against products, a diagram a case."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(h.case for h in histories))
    figure = Figure(figsize=(16.0, 8.0), layout="constrained")
    FigureCanvasAgg(figure)
    every = figure.subplots(2, -(-len(names) // 2), sharey=True).ravel()
    for unused in every[len(names) :]:
        unused.set_axis_off()
    for axes, name in zip(every, names):
        for history in (h for h in histories if h.case == name):
            steps = np.array(history.steps)
            axes.loglog(steps[:, 0], steps[:, 2], label=history.solver)
        axes.set(title=name, xlabel="products", ylabel="largest error / largest indirect light", ylim=(1e-7, 2.0))
    figure.axes[0].legend(fontsize="small")
    figure.savefig(path, dpi=100)


def _number(products: float) -> str:
    return (
        f">{MOST_PRODUCTS:.0f}"
        if not np.isfinite(products)
        else f"{products:.0f}"
        if products >= 10
        else f"{products:.2g}"
    )


def _seconds_table(device: Device, room: SolverRoom, solvers: Sequence[str]) -> str:
    means = (0.5, 0.8, 0.95)
    rows = []
    for solver in solvers:
        found = [seconds(device, room, mean, solver) for mean in means]
        rows.append([solver, *(f"{spent:.2f} s, {products:.0f}" for spent, products in found)])
    return table([f"{len(room.direct)} elements", *(f"ρ {mean:g} ± {SPREAD:g}" for mean in means)], rows)


def _inversion_table(device: Device, room: SolverRoom) -> str:
    levels = (0.5, 0.95, 0.999)
    found = [inversion_errors(device, room, level) for level in levels]
    rows = [
        [str(lines[0][0]), *(f"{backward:.1e}, {error:.1e}" for _, backward, error in lines)] for lines in zip(*found)
    ]
    return table(["blocks", *(f"ρ {level:g}" for level in levels)], rows)


def main() -> None:
    """Print the tables; write them, the histories and a picture if a folder is named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, help="folder for solvers.md, solvers.csv and solvers.png")
    options = parser.parse_args()
    device = Device()
    text = ""

    def say(*lines: str) -> None:
        nonlocal text
        text += "\n".join(("", *lines)) if text else "\n".join(lines)
        print(*lines, sep="\n", flush=True)

    say(device.description + "\n")
    histories = [follow(device, case, solver) for case in cases(device) for solver in ITERATIVE]
    say("Products to an error of 1e-3 / 1e-6:\n", products_table(histories))
    small, large = furnished(device), furnished(device, 0.24)
    say("Inversion by blocks: backward error, and difference from elimination over the largest light:\n")
    say(_inversion_table(device, small))
    say(f"CPU seconds and products, {COLUMNS} columns to a residual of 1e-3:\n")
    say(_seconds_table(device, small, (*ITERATIVE, *DIRECT_SOLVERS)))
    say(_seconds_table(device, large, ITERATIVE))
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        (options.out / "solvers.md").write_text(text, encoding="utf-8")
        write_histories(options.out / "solvers.csv", histories)
        draw_histories(options.out / "solvers.png", histories)


if __name__ == "__main__":
    main()

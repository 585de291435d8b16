"""Accuracy and cost of every form-factor method: ``python -m hradiosity.suites.bench_form_factors``.

Two tables are printed. The first one takes the pairs of polygons of the catalogue, whose factors are known to 18
digits: largest relative error by category, and CPU time of a pair. The second one is the empty box, a unit cube of 2400
squares: CPU seconds and error of the whole matrix, beside pyviewfactor where that is installed (extra ``bench``).
Seconds are of the whole call, all threads added, best of some turns, kernels built before.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.suites.bench.figure import CPU, ERROR, MICROSECONDS, Figure, exact_figure, figure_of
from hradiosity.suites.bench.session import Session, cpu_seconds
from hradiosity.suites.validation.data import form_factors
from hradiosity.transport.form_factor.interface import FormFactors, form_factor, form_factor_matrix
from hradiosity.transport.form_factor.methods import METHODS, Method

BOX_TOLERANCES: Final = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6)
_COPIES: Final = 64
"""The catalogue is computed so many times in one call, so that launches do not count."""
_SWIFT: Final = ("auto", "contour", "point", "point-disk")
"""Methods for which launches would count."""
_SLOW: Final = ("hemicube", "monte-carlo", "rays")
"""Methods that a quick run leaves out."""


@dataclass(frozen=True)
class CatalogueRow:
    """One method: largest relative error by category, share of pairs within the stated error, CPU µs a pair."""

    method: str
    worst: dict[str, float]
    within_error: float
    microseconds: float


@dataclass(frozen=True)
class BoxRow:
    """One way through the box: CPU seconds for all pairs, relative error of the matrix in the Frobenius norm."""

    name: str
    seconds: float
    error: float


def run_catalogue(device: Device, entries: Sequence[dict[str, Any]]) -> list[CatalogueRow]:
    """All methods, with what they take by default, on the pairs of the catalogue that see each other."""
    seen = [e for e in entries if e["kind"] == "polygon-polygon" and float(e["F12"]) > 0.0]
    a, b = ([np.array(e[key], np.float64) for e in seen] for key in ("poly1", "poly2"))
    exact = np.array([float(e["F12"]) for e in seen])
    category = np.array([e["category"] for e in seen])
    rows = []
    for method in METHODS:
        found = form_factor(a, b, method=method, device=device)
        error = np.abs(found.value - exact)
        worst = {name: float((error / exact)[category == name].max()) for name in sorted(set(category.tolist()))}
        within = float((error <= found.error + 4e-16).mean())
        rows.append(CatalogueRow(method, worst, within, _pair_cost(device, a, b, method)))
    return rows


def _pair_cost(device: Device, a: list[NDArray[np.float64]], b: list[NDArray[np.float64]], method: Method) -> float:
    copies = _COPIES if method in _SWIFT else 1
    seconds = _best_seconds(lambda: form_factor(a * copies, b * copies, method=method, device=device), 2)
    return seconds / (copies * len(a)) * 1e6


def box_squares(cells: int) -> NDArray[np.float64]:
    """Inside of the unit cube, each face in cells × cells squares: (6 cells², 4, 3)."""
    x, y, z = np.eye(3)
    nowhere = np.zeros(3)
    i, j = (grid.reshape(-1, 1, 1) / cells for grid in np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij"))
    u = np.array([0.0, 1.0, 1.0, 0.0]).reshape(1, 4, 1) / cells
    v = np.array([0.0, 0.0, 1.0, 1.0]).reshape(1, 4, 1) / cells
    faces = [(nowhere, x, y), (z, y, x), (nowhere, y, z), (x, z, y), (nowhere, z, x), (y, x, z)]
    return np.concatenate([corner + (i + u) * one + (j + v) * other for corner, one, other in faces])


def run_box(device: Device, cells: int, turns: int) -> list[BoxRow]:
    """`auto` at several tolerances; the contour integral of all pairs is what it is compared with."""
    squares = box_squares(cells)
    exact = form_factor_matrix(squares, method="contour", tolerance=1e-10, device=device).value
    rows = []
    for tolerance in BOX_TOLERANCES:

        def solve(tolerance: float = tolerance) -> FormFactors:
            return form_factor_matrix(squares, tolerance=tolerance, device=device)

        error = np.linalg.norm(solve().value - exact) / np.linalg.norm(exact)
        rows.append(BoxRow(f"auto, tolerance {tolerance:g}", _best_seconds(solve, turns), float(error)))
    if find_spec("pyviewfactor") is not None:
        rows.append(run_peer(squares, exact))
    return rows


def run_peer(squares: NDArray[np.float64], exact: NDArray[np.float64]) -> BoxRow:
    """The matrix call of pyviewfactor, told that nothing hides anything; once, after a small box that compiles it."""
    import pyviewfactor
    import pyvista

    def mesh(polygons: NDArray[np.float64]) -> Any:
        faces = np.insert(np.arange(4 * len(polygons)).reshape(-1, 4), 0, 4, axis=1)
        return pyvista.PolyData(polygons.reshape(-1, 3), faces=faces.ravel())

    pyviewfactor.compute_viewfactor_matrix(mesh(box_squares(2)), skip_obstruction=True)
    whole = mesh(squares)
    start = time.process_time()
    found = pyviewfactor.compute_viewfactor_matrix(whole, skip_obstruction=True)
    seconds = time.process_time() - start
    # Its result is [to, from]; here all areas are equal, so that both readings agree.
    error = float(np.linalg.norm(found - exact) / np.linalg.norm(exact))
    return BoxRow(f"pyviewfactor {pyviewfactor.__version__}", seconds, error)


def _best_seconds(work: Callable[[], object], turns: int) -> float:
    return min(cpu_seconds([work], turns)[0])


def measure(session: Session) -> list[Figure]:
    """Each method on the catalogue, and the empty box beside pyviewfactor where that is installed."""
    return _measured_methods(session) + _measured_box(session)


def _measured_methods(session: Session) -> list[Figure]:
    """CPU time of a pair, and the largest relative error of the catalogue but for its near-singular entries."""
    seen = [e for e in form_factors() if e["kind"] == "polygon-polygon" and float(e["F12"]) > 0.0]
    a, b = ([np.array(e[key], np.float64) for e in seen] for key in ("poly1", "poly2"))
    exact = np.array([float(e["F12"]) for e in seen])
    regular = np.array([e["category"] != "near-singular" for e in seen])
    figures = []
    for method in (m for m in METHODS if m not in _SLOW or not session.quick):
        copies = _COPIES if method in _SWIFT else 1

        def work(method: Method = method, copies: int = copies) -> object:
            return form_factor(a * copies, b * copies, method=method, device=session.device)

        spent = cpu_seconds([work], 3 if method in _SWIFT else 2)[0]
        pairs = copies * len(a)
        figures.append(figure_of(f"form factors: {method}, a pair", [t / pairs * 1e6 for t in spent], MICROSECONDS))
        found = form_factor(a, b, method=method, device=session.device).value
        worst = float((np.abs(found - exact) / exact)[regular].max())
        figures.append(exact_figure(f"form factors: {method}, worst of the catalogue", worst, ERROR))
    return figures


def _measured_box(session: Session) -> list[Figure]:
    """The empty box at two tolerances; the peer once only, since it takes long."""
    squares = box_squares(10 if session.quick else 20)
    exact = form_factor_matrix(squares, method="contour", tolerance=1e-10, device=session.device).value
    figures = []
    for tolerance in (1e-3, 1e-6):

        def solve(tolerance: float = tolerance) -> FormFactors:
            return form_factor_matrix(squares, tolerance=tolerance, device=session.device)

        name = f"form factors: box of {len(squares)} squares, auto {tolerance:g}"
        error = float(np.linalg.norm(solve().value - exact) / np.linalg.norm(exact))
        figures.append(figure_of(name, cpu_seconds([solve], session.turns)[0], CPU))
        figures.append(exact_figure(f"{name}, Frobenius", error, ERROR))
    if session.has_peer("pyviewfactor"):
        peer = run_peer(squares, exact)
        name = f"form factors: box of {len(squares)} squares, pyviewfactor"
        figures += [figure_of(name, [peer.seconds], CPU), exact_figure(f"{name}, Frobenius", peer.error, ERROR)]
    return figures


def _print_catalogue(rows: Sequence[CatalogueRow]) -> None:
    categories = sorted(rows[0].worst)
    print("largest relative error, share of pairs within the stated error, CPU µs a pair")
    print(f"{'':17}" + "".join(f"{name[:13]:>15}" for name in categories) + f"{'within':>9}{'µs':>10}")
    for row in rows:
        worst = "".join(f"{row.worst[name]:15.1e}" for name in categories)
        print(f"{row.method:17}{worst}{row.within_error:9.2f}{row.microseconds:10.2f}")


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--cells", type=int, default=20, help="squares along an edge of the box")
    parser.add_argument("--turns", type=int, default=5, help="the best of so many counts")
    parser.add_argument("--json", type=Path, help="write the figures there as well")
    options = parser.parse_args()
    device = Device()
    print(device.description)
    catalogue = run_catalogue(device, form_factors())
    _print_catalogue(catalogue)
    box = run_box(device, options.cells, options.turns)
    print(f"\nempty box of {6 * options.cells**2} squares{'':20}CPU s   relative error (Frobenius)")
    for row in box:
        print(f"  {row.name:44}{row.seconds:7.2f}   {row.error:.1e}")
    if options.json:
        figures = {"catalogue": [asdict(r) for r in catalogue], "box": [asdict(r) for r in box]}
        options.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

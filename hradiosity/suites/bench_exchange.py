"""What each method of form factors costs and gives in a whole run: ``python -m hradiosity.suites.bench_exchange``."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, get_args

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.estimate import student_quantile
from hradiosity.io.scene_toml import load_scene
from hradiosity.model.scene import Scene
from hradiosity.options import FormFactorName, Options
from hradiosity.radiosity import RadiositySolver, make_solver
from hradiosity.readings.paths import SCRAMBLES
from hradiosity.solution import Readings, Solution
from hradiosity.suites.compare import compare
from hradiosity.suites.referee_cache import referee_readings

METHODS: Final[tuple[FormFactorName, ...]] = get_args(FormFactorName)
MANY_PATHS: Final = 65536
"""From each reading, so that their noise does not hide that of the elements."""
MANY_RAYS: Final = 16384
"""From each element, for the light on the same elements that all methods should come to."""
HEADER: Final = (
    f"| form factors | CPU s | readings | with {MANY_PATHS} paths | light on elements | row sums |\n"
    "|---|---|---|---|---|---|"
)


@dataclass(frozen=True)
class Outcome:
    """What one method gave.

    cpu_seconds : of a run with the paths of the options
    spectral_rms, spectral_rms_many : error of the readings with those paths, and with `MANY_PATHS`
    element_rms : of the reflected light on the elements, against `MANY_RAYS` from each of the same elements
    row_sum_rms : defect of the rows before they were closed
    """

    method: FormFactorName
    cpu_seconds: float
    spectral_rms: float
    spectral_rms_many: float
    element_rms: float
    row_sum_rms: float

    def line(self) -> str:
        """A row of the table."""
        return (
            f"| `{self.method}` | {self.cpu_seconds:.1f} "
            f"| {100 * self.spectral_rms:.2f} % | {100 * self.spectral_rms_many:.2f} % "
            f"| {100 * self.element_rms:.2f} % | {100 * self.row_sum_rms:.2g} % |"
        )


def run(scene: Scene, device: Device, options: Options) -> RadiositySolver:
    """A whole run."""
    solver = make_solver(scene, options, device)
    for _ in solver.states():
        pass
    return solver


def reflected(solution: Solution) -> NDArray[np.float64]:
    """(n_rows,) irradiance of the elements less what comes straight from lamps, all bands together [W m⁻²]."""
    light: NDArray[np.float64] = (solution.surfaces.irradiance - solution.surfaces.direct).sum(axis=1)
    return light


def element_error(solution: Solution, best: Solution) -> float:
    """Rms over the area that light reaches of `reflected` over that of another solution of the same mesh, − 1.

    One that traced more rays may have found more sides to be lit.
    """
    elements, others = solution.elements, best.elements
    cell = elements.row_cell[elements.row_start[:-1]]
    side = elements.cell_side[cell]
    same = others.first_cell.ravel()[side] + cell - elements.first_cell.ravel()[side]
    known = reflected(best)[others.cell_row[same]]
    area = elements.area * solution.surfaces.exposed
    seen = (known > 0.0) & (area > 0.0)
    error = reflected(solution)[seen] / known[seen] - 1.0
    return float(np.sqrt(np.average(error**2, weights=area[seen])))


def measure(
    scene: Scene,
    device: Device,
    options: Options,
    reference: Mapping[str, Readings],
    best: Solution,
) -> Outcome:
    """Run with `options` twice, first with many paths: so kernels are built when the other one is timed.

    Parameters
    ----------
    reference : mapping of sensor name to Readings
    best : Solution
        Of the same elements, by many rays.
    """
    errors = []
    for chosen in (replace(options, gather_samples=MANY_PATHS), options):
        solver = run(scene, device, chosen)
        solution = solver.solution()
        found = compare(solution.readings, reference, quantile=student_quantile(0.95, SCRAMBLES - 1))
        errors.append(found.spectral_rms)
    return Outcome(
        method=options.form_factors,
        cpu_seconds=solver.cpu_seconds,
        spectral_rms=errors[1],
        spectral_rms_many=errors[0],
        element_rms=element_error(solution, best),
        row_sum_rms=float(solution.record["defects_before_closure"][0]["row_sum_rms"]),
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("scene", type=Path, help="a scene folder or file")
    parser.add_argument("--elements", type=int, default=1000)
    parser.add_argument("--methods", type=lambda text: text.split(","), default=list(METHODS))
    parser.add_argument("--paths", type=int, default=262144, help="of the referee, from each reading")
    parser.add_argument("--cache", type=Path, help=".npz file that keeps the referee's readings")
    chosen = parser.parse_args()
    scene, device = load_scene(chosen.scene), Device()
    reference = referee_readings(scene, device, chosen.paths, cache=chosen.cache)
    noise = compare(reference, reference, quantile=student_quantile(0.95, SCRAMBLES - 1)).reference_spectral_rms
    options = Options(elements=chosen.elements)
    best = run(
        scene, device, replace(options, rays_per_element=MANY_RAYS, light_points=256, gather_samples=16)
    ).solution()
    print(f"{scene.name}: {len(best.elements)} elements; noise of the reference {100 * noise:.2f} %; errors are rms\n")
    print(HEADER, flush=True)
    for method in chosen.methods:
        outcome = measure(scene, device, replace(options, form_factors=method), reference, best)
        print(outcome.line(), flush=True)


if __name__ == "__main__":
    main()

"""The whole computation: replicates of transport, solution and readings, one after the other."""

from hradiosity.device import Device
from hradiosity.model.scene import Scene
from hradiosity.options import Options
from hradiosity.plan import Calibration, ClassicCalibration
from hradiosity.radiosity.solver import RadiositySolver
from hradiosity.radiosity.state import State
from hradiosity.solution import Solution

__all__ = ["RadiositySolver", "State", "make_solver", "solve"]


def make_solver(
    scene: Scene,
    options: Options,
    device: Device,
    calibration: Calibration | ClassicCalibration | None = None,
) -> RadiositySolver:
    """The solver that the mode, the links and the form factors of the options name; all are used alike."""
    if options.mode == "classic":
        from hradiosity.radiosity.classic import ClassicSolver

        return ClassicSolver(scene, options, device, calibration)
    if options.form_factors != "rays":
        from hradiosity.radiosity.paired import PairedSolver

        return PairedSolver(scene, options, device, calibration)
    if options.links == "hierarchical":
        from hradiosity.radiosity.linked import LinkedSolver

        return LinkedSolver(scene, options, device, calibration)
    return RadiositySolver(scene, options, device, calibration)


def solve(scene: Scene, options: Options | None = None, device: Device | None = None) -> Solution:
    """Light everywhere in the scene; see `make_solver` to follow the run or to read further points."""
    chosen, on = options or Options(), device or Device()
    solver = make_solver(scene, chosen, on)
    for _ in solver.states():
        pass
    solution = solver.solution()
    if chosen.audit:
        from hradiosity.radiosity.auditing import audit

        solution = audit(solution, on, scene=scene)
    return solution

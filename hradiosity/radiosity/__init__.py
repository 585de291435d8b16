"""The whole computation: replicates of transport, solution and readings, one after the other."""

from hradiosity.device import Device
from hradiosity.model.scene import Scene
from hradiosity.options import Options
from hradiosity.plan import Calibration, ClassicCalibration
from hradiosity.radiosity.classic import ClassicSolver
from hradiosity.radiosity.solver import RadiositySolver, solve
from hradiosity.radiosity.state import State

__all__ = ["ClassicSolver", "RadiositySolver", "State", "make_solver", "solve"]


def make_solver(
    scene: Scene,
    options: Options,
    device: Device,
    calibration: Calibration | ClassicCalibration | None = None,
) -> RadiositySolver:
    """The solver that ``options.mode`` (``--mode`` of the command line) names; both are used alike."""
    kind = ClassicSolver if options.mode == "classic" else RadiositySolver
    return kind(scene, options, device, calibration)

"""The whole computation: replicates of transport, solution and readings, one after the other."""

from collections.abc import Sequence
from dataclasses import replace

from hradiosity.device import Device
from hradiosity.errors import Fault, SceneError
from hradiosity.model.scene import Scene, Variant
from hradiosity.model.variants import variant_from
from hradiosity.options import Options
from hradiosity.plan import Calibration, ClassicCalibration
from hradiosity.radiosity.solver import RadiositySolver
from hradiosity.radiosity.state import State
from hradiosity.solution import Solution
from hradiosity.space.parted import part_back_to_back

__all__ = ["RadiositySolver", "State", "compare", "make_solver", "solve"]


def make_solver(
    scene: Scene,
    options: Options,
    device: Device,
    calibration: Calibration | ClassicCalibration | None = None,
) -> RadiositySolver:
    """The solver that the mode, the links and the form factors of the options name; all are used alike."""
    scene = part_back_to_back(scene)
    if options.mode == "classic":
        _refuse_variants(scene)
        _refuse_responses(scene)
        from hradiosity.radiosity.classic import ClassicSolver

        return ClassicSolver(scene, options, device, calibration)
    if options.form_factors != "rays":
        from hradiosity.radiosity.paired import PairedSolver

        return PairedSolver(scene, options, device, calibration)
    if options.links == "hierarchical":
        from hradiosity.radiosity.linked import LinkedSolver

        return LinkedSolver(scene, options, device, calibration)
    return RadiositySolver(scene, options, device, calibration)


def _refuse_variants(scene: Scene) -> None:
    """The classic mode chooses what shoots, and what is subdivided, by the light of one scene."""
    if scene.variants:
        names = ", ".join(variant.name for variant in scene.variants)
        found = f"the classic mode for a scene with variants: {names}"
        raise SceneError(
            [Fault("command line", "--mode", found, "rays; or a scene without variants and maintenance factors")]
        )


def _refuse_responses(scene: Scene) -> None:
    """Raise ``SceneError`` for readings that weigh directions, which the pixels of their hemicubes do not know of."""
    curved = [s.name for s in scene.sensors if s.parts is not None and s.parts.response is not None]
    if curved:
        found = f"the classic mode for sensors that are no planes: {', '.join(curved)}"
        raise SceneError([Fault("command line", "--mode", found, "rays; or sensors with plane readings")])


def compare(
    scene: Scene, variants: Sequence[Variant | Scene], options: Options | None = None, device: Device | None = None
) -> Solution:
    """Solve a scene and its variants together, with the same rays.

    What the variants have in common with the scene cancels in the differences, random errors above all.

    Parameters
    ----------
    scene : Scene
    variants : sequence of Variant or Scene
        See `hradiosity.make_variant`; a scene that differs in nothing but reflectances and emitted light is one too.
    options : Options, optional
    device : Device, optional

    Returns
    -------
    Solution
        Of the scene, with readings of the variants and their differences from it in ``variants``.

    Raises
    ------
    ValueError
        When a scene is no variant, or several variants have one name.
    """
    known = tuple(v if isinstance(v, Variant) else variant_from(scene, v) for v in variants)
    return solve(replace(scene, variants=known), options, device)


def solve(scene: Scene, options: Options | None = None, device: Device | None = None) -> Solution:
    """Light everywhere in the scene; see `make_solver` to follow the run or to read further points."""
    chosen, on = options or Options(), device or Device()
    solver = make_solver(scene, chosen, on)
    for _ in solver.states():
        pass
    if not chosen.audit:
        return solver.solution()
    from hradiosity.radiosity.auditing import MOST_AUDITS, accuracy_before_factor, audit

    for _ in range(MOST_AUDITS):
        solution = audit(solver.solution(), on, scene=scene)
        accuracy = accuracy_before_factor(solution)
        if accuracy is None:
            break
        solver.ask_for(accuracy)
        for _ in solver.states():
            pass
    return solution

"""Pictures of a solution: ``write_pictures`` is what the command line calls."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.errors import OutputError
from hradiosity.model.scene import Note, View
from hradiosity.show.drawing import Drawing, Picture, draw_view, prepare_drawing
from hradiosity.show.exposure import white_luminance
from hradiosity.show.files import png_bytes, write_bytes, write_exr
from hradiosity.show.scale_bar import Scale, automatic_scale
from hradiosity.show.white import WHITES, WhiteName, white_of
from hradiosity.solution import Solution
from hradiosity.space.bvh_build import build_bvh
from hradiosity.space.hierarchy import NONE
from hradiosity.space.viewpoints import automatic_view
from hradiosity.transport.device_scene import DeviceScene, upload_scene
from hradiosity.transport.glow import sampled_scene
from hradiosity.transport.refine import RefinementOptions

Mode = Literal["flat", "smooth", "wireframe", "unshaded", "false-color"]
MODES: Final[tuple[Mode, ...]] = ("flat", "smooth", "wireframe", "unshaded", "false-color")


@dataclass(frozen=True, kw_only=True)
class PictureOptions:
    """What pictures show.

    modes : any of `MODES`
    white_luminance : luminance shown as white [cd m⁻²]; None: one in a hundred pixels of what does not shine is
        brighter, over all views together
    white : what is shown as white: the display's own white, or the light of the lamps; EXR files stay as measured
    quantity : what false colours stand for
    logarithmic : whether equal ratios are equal steps of the false colours
    scale_range : lowest and highest number of the false colours, in lx or cd m⁻²; None: from the pictures
    refinement : how finely shadows are resolved
    """

    modes: tuple[Mode, ...] = MODES
    white_luminance: float | None = None
    white: WhiteName = "as-measured"
    quantity: Literal["illuminance", "luminance"] = "illuminance"
    logarithmic: bool = False
    scale_range: tuple[float, float] | None = None
    refinement: RefinementOptions = field(default_factory=RefinementOptions)

    def __post_init__(self) -> None:
        unknown = [mode for mode in self.modes if mode not in MODES]
        if unknown or not self.modes:
            raise ValueError(f"modes must be some of {', '.join(MODES)}, are {self.modes}")
        if self.white not in WHITES:
            raise ValueError(f"white must be one of {', '.join(WHITES)}, is {self.white!r}")
        if self.white_luminance is not None and not (0.0 < self.white_luminance < np.inf):
            raise ValueError(f"white_luminance must be > 0 cd/m², is {self.white_luminance}")
        if self.scale_range is not None:
            low, high = self.scale_range
            Scale(low, high, self.logarithmic, self.quantity, "")


@dataclass(frozen=True)
class PictureSet:
    """What was drawn.

    pictures : one a view and mode
    record : what ``pictures.json`` holds
    notes : what was assumed
    """

    pictures: tuple[Picture, ...]
    record: dict[str, Any]
    notes: tuple[Note, ...]


def write_pictures(
    solution: Solution,
    folder: Path,
    device: Device,
    options: PictureOptions | None = None,
    on_device: DeviceScene | None = None,
) -> PictureSet:
    """Draw each view of the scene in each mode, into ``folder``.

    For each view and mode there are ``<view>_<mode>.png`` and, but for the wireframe, ``<view>_<mode>.exr`` with X, Y
    and Z as float (luminance Y in cd m⁻²), or the illuminance in lx. ``pictures.json`` states exposure, scale, units
    and the shares of pixels that the display could not show. The same solution gives the same bytes.

    The command line calls ``write_pictures(solver.solution(), folder, device, PictureOptions(modes=…))`` once the run
    is over; during the run see ``hradiosity.show.preview``.

    Parameters
    ----------
    solution : Solution
    folder : Path
        Made if there is none.
    device : Device
    options : PictureOptions, optional
    on_device : DeviceScene, optional
        The scene's ray structure, where it is at hand already.

    Raises
    ------
    OutputError
        When a file can't be written.
    """
    drawn = draw_pictures(solution, device, options or PictureOptions(), on_device)
    make_folder(folder)
    for picture in drawn.pictures:
        texts = {"Title": f"{solution.scene.name}: {picture.view}, {picture.mode}", **picture.texts}
        write_bytes(folder / f"{picture.stem}.png", png_bytes(picture.pixels, texts))
        if picture.channels:
            write_exr(folder / f"{picture.stem}.exr", picture.channels, picture.texts)
    write_record(folder, drawn.record)
    return drawn


def make_folder(folder: Path) -> None:
    """Make a folder for pictures, if there is none.

    Raises
    ------
    OutputError
        When it can't be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder} can't be made: {error.strerror or error}") from error


def write_record(folder: Path, record: dict[str, Any]) -> None:
    """Write ``pictures.json``."""
    write_bytes(folder / "pictures.json", (json.dumps(record, indent=2, ensure_ascii=False) + "\n").encode())


def draw_pictures(
    solution: Solution, device: Device, options: PictureOptions, on_device: DeviceScene | None = None
) -> PictureSet:
    """As `write_pictures`, without files."""
    scene = solution.scene
    if not len(scene.patches):
        return PictureSet((), {"pictures": []}, ())
    if on_device is None:
        bvh = build_bvh(device, scene.patches)
        sampled = sampled_scene(scene, solution.plan.weak_emitters)
        on_device = upload_scene(device, sampled, bvh, occlusion=solution.plan.occlusion)
    views, notes = views_of(solution, on_device)
    drawings = prepare_drawing(solution, on_device, views, options.refinement, white_of(scene, options.white))
    white = options.white_luminance or white_luminance([d.shown(d.dull_radiance()) for d in drawings])
    scale = scale_of(options, [_seen_values(drawing, options.quantity) for drawing in drawings])
    pictures = tuple(
        draw_view(drawing, mode, white=white, scale=scale) for drawing in drawings for mode in options.modes
    )
    return PictureSet(pictures, _record(options, drawings, pictures, white, scale, notes), notes)


def views_of(solution: Solution, on_device: DeviceScene) -> tuple[Sequence[View], tuple[Note, ...]]:
    """Views of the scene, or one that is chosen here, which is noted."""
    scene = solution.scene
    if scene.views:
        return scene.views, ()
    view = automatic_view(scene, on_device.bvh, solution.elements.first_cell != NONE)
    place = ", ".join(f"{x:.2f}" for x in view.position)
    aim = ", ".join(f"{x:.3f}" for x in view.direction)
    message = f"the scene names no [[view]]; pictures are from ({place}) m towards ({aim})"
    return (view,), (Note("info", "view", message),)


def scale_of(options: PictureOptions, seen: Sequence[NDArray[np.floating]]) -> Scale:
    """One scale of false colours for all views, whose values are `seen`."""
    unit = "lx" if options.quantity == "illuminance" else "cd/m²"
    if options.scale_range is not None:
        return Scale(*options.scale_range, options.logarithmic, options.quantity, unit)
    values = np.concatenate([np.zeros(0), *seen])
    return automatic_scale(values, logarithmic=options.logarithmic, quantity=options.quantity, unit=unit)


def _seen_values(drawing: Drawing, quantity: str) -> NDArray[np.float32]:
    return drawing.dull_illuminance() if quantity == "illuminance" else drawing.dull_radiance()[:, 1]


def _record(
    options: PictureOptions,
    drawings: Sequence[Drawing],
    pictures: Sequence[Picture],
    white: float,
    scale: Scale,
    notes: Sequence[Note],
) -> dict[str, Any]:
    asked = options.white_luminance is not None
    leaves = drawings[0].shadow.leaves
    return {
        "exposure": {
            "white_luminance_cd_m2": white,
            "white": options.white,
            "rule": "as asked for" if asked else "1 in 100 points that do not shine is brighter, all views together",
            "colours": f"{drawings[0].white.words}; clipped, no tone curve",
        },
        "false_color": scale.record(),
        "shadow_refinement": {
            "leaves": int(leaves.is_leaf.sum()),
            "vertices": len(drawings[0].shadow.covered),
            "highest_level": int(leaves.level.max(initial=0)),
            "tolerance": options.refinement.tolerance,
        },
        "pictures": [picture.record() for picture in pictures],
        "notes": [str(note) for note in notes],
    }

"""Images against path-traced ones: ``python -m hradiosity.suites.images SCENE --out FOLDER [--size 320 180]``.

Writes the image, the reference, both side by side, the map of their colour differences, and ``images.json``.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.device import Device
from hradiosity.io.scene_toml import load_scene
from hradiosity.metrics.colorimetric import encode_srgb, xyz_to_linear_srgb
from hradiosity.model.scene import Scene, View
from hradiosity.options import Options
from hradiosity.radiosity import RadiositySolver
from hradiosity.show.drawing import file_name
from hradiosity.show.exposure import to_bytes, white_luminance
from hradiosity.show.files import png_bytes, write_bytes, write_exr
from hradiosity.show.image import gather_image
from hradiosity.show.pictures import make_folder
from hradiosity.show.scale_bar import Scale, false_colours, with_scale_bar
from hradiosity.suites.images.comparison import ImageComparison, compare_images, difference_map
from hradiosity.suites.images.reference import PathTracer

HIGHEST_DIFFERENCE = 5.0
"""End of the scale of the maps, CIEDE2000."""


def main() -> None:
    """Compare, and print what came out."""
    asked = _arguments()
    scene, device = load_scene(asked.scene), Device()
    make_folder(asked.out)
    solver = RadiositySolver(replace(scene, sensors=()), Options(pictures=True, seed=asked.seed), device)
    for _ in solver.states():
        pass
    solution, tracer = solver.solution(), PathTracer(scene, device)
    entries = []
    for view in scene.views:
        sized = replace(view, width=asked.size[0], height=asked.size[1]) if asked.size else view
        start = time.process_time()
        halves = [
            gather_image(solution, device, sized, samples=asked.samples, seed=seed, on_device=solver.on_device)
            for seed in (2 * asked.seed, 2 * asked.seed + 1)
        ]
        gathered = time.process_time() - start
        reference = [
            tracer.image(sized, points=asked.points, paths=asked.paths, seed=2 * asked.seed + half) for half in (0, 1)
        ]
        traced = time.process_time() - start - gathered
        dull = halves[0].dull[halves[0].shining == 0.0]
        white = white_luminance([dull.astype(np.float32)])
        image = np.stack([half.xyz for half in halves])
        found = compare_images(image, np.stack(reference), white)
        _write(asked.out, scene, sized, image.mean(axis=0), np.mean(reference, axis=0), white)
        entries.append({"view": view.name, "cpu_s": gathered, "reference_cpu_s": traced, **asdict(found)})
        print(_line(scene.name, view, found, gathered, traced), flush=True)
    settings = {"samples": 2 * asked.samples, "points": asked.points**2 * 2, "paths": asked.paths, "seed": asked.seed}
    record = {"scene": scene.name, **settings, "views": entries}
    write_bytes(asked.out / "images.json", (json.dumps(record, indent=2) + "\n").encode())


def _write(
    folder: Path, scene: Scene, view: View, image: NDArray[np.float64], reference: NDArray[np.float64], white: float
) -> None:
    """Pictures of one view."""
    stem = file_name(view.name)
    shown = [to_bytes(encode_srgb(xyz_to_linear_srgb(light, white))) for light in (image, reference)]
    apart = difference_map(image, reference, white)
    scale = Scale(0.0, HIGHEST_DIFFERENCE, False, "CIEDE2000", "1")
    pictures = {
        "image": shown[0],
        "reference": shown[1],
        "side_by_side": np.concatenate(shown, axis=1),
        "difference": with_scale_bar(false_colours(apart, np.ones(apart.shape, np.bool_), scale), scale),
    }
    for name, pixels in pictures.items():
        texts: dict[str, Any] = {"Title": f"{scene.name}: {view.name}, {name}"}
        write_bytes(folder / f"{stem}_{name}.png", png_bytes(pixels, texts))
    channels = {f"{name}.{c}": light[..., i] for name, light in (("image", image), ("reference", reference))
                for i, c in enumerate("XYZ")}  # fmt: skip
    write_exr(folder / f"{stem}.exr", {**channels, "difference": apart}, {"units": "X, Y, Z with Y in cd/m²"})


def _line(scene: str, view: View, found: ImageComparison, gathered: float, traced: float) -> str:
    return (
        f"{scene}, {view.name}: CIEDE2000 {found.delta_e_mean:.2f} mean, {found.delta_e_95:.2f} 95 %, of which noise "
        f"{found.noise_delta_e_mean:.2f}; blocks of 8 x 8 pixels {found.block_delta_e_mean:.2f} mean, "
        f"{found.block_delta_e_95:.2f} 95 %, noise {found.block_noise_mean:.2f}; luminance "
        f"{100 * found.luminance_bias:+.2f} ± {100 * found.luminance_bias_error:.2f} %; "
        f"{gathered:.0f} and {traced:.0f} CPU s"
    )


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("scene", type=Path, help="a scene folder or file")
    parser.add_argument("--out", type=Path, required=True, help="folder for pictures and figures")
    parser.add_argument("--size", type=int, nargs=2, help="width and height, in place of those of the views")
    parser.add_argument("--samples", type=int, default=64, help="points in each pixel of each half of the image")
    parser.add_argument("--points", type=int, default=4, help="across and down in each pixel of half the reference")
    parser.add_argument("--paths", type=int, default=16, help="from each point of the reference")
    parser.add_argument("--seed", type=int, default=0)
    return parser.parse_args()


if __name__ == "__main__":
    main()

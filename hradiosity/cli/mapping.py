"""Illuminance maps of a render."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from hradiosity.cli.interrupts import let_through
from hradiosity.cli.text import aligned, percent

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hradiosity.cli.outputs import Outputs
    from hradiosity.cli.request import Run
    from hradiosity.radiosity import RadiositySolver
    from hradiosity.solution import Solution


def map_plan_lines(names: Sequence[str], error: float) -> list[str]:
    """What a plan says of maps."""
    return [
        f"map of {name}: cut and read until the rms error is {percent(error)} of the mean illuminance" for name in names
    ]


def write_maps(run: Run, solver: RadiositySolver, solution: Solution) -> bool:
    """Draw the maps that were asked for into ``maps``; returns whether that was interrupted."""
    from hradiosity.show.map_files import MapScale, write_map
    from hradiosity.show.pictures import make_folder
    from hradiosity.show.surface_map import lit_sides_of, map_surfaces

    wanted, start, cpu = run.request.outputs, time.perf_counter(), time.process_time()
    folder, entries = run.partial / "maps", {}
    scale = MapScale(logarithmic=wanted.false_color_scale == "log", ends=_ends(wanted))
    try:
        with let_through():
            for name in wanted.mapped:
                run.display.stage(f"map of {name!r}")
                sides = lit_sides_of(solution, [name])
                if not solver.keeps_light:
                    entries[name] = {"none": "a map needs light computed in this run: start without --resume"}
                elif not len(sides):
                    entries[name] = {"none": "no light reaches it"}
                else:
                    found = map_surfaces(solution, solver.on_device, sides, wanted.map_error)
                    make_folder(folder)
                    entries[name] = write_map(folder, file_stem(name), found, wanted.map_error, scale)
    except KeyboardInterrupt:
        return True
    finally:
        run.seconds["maps"] = time.perf_counter() - start
        run.more["maps"] = entries
    title = "Illuminance maps, in the folder maps"
    run.closing.append((title, map_lines(entries, time.process_time() - cpu)))
    return False


def file_stem(name: str) -> str:
    """Of the files of a map: the name, without what file systems can't have."""
    return "".join("_" if letter in '/\\:*?"<>|' or not letter.isprintable() else letter for letter in name)


def map_lines(entries: dict[str, dict[str, Any]], cpu_seconds: float) -> list[str]:
    """What came out."""
    rows = [("object", "mean", "lowest", "highest", "95 % (rms)", "cells")]
    for name, entry in entries.items():
        if "none" in entry:
            continue
        rows.append(
            (
                name,
                f"{entry['mean_lx']:.4g} lx",
                f"{entry['lowest_lx']:.3g} lx",
                f"{entry['highest_lx']:.4g} lx",
                f"± {entry['half_width_rms_lx']:.2g} lx",
                str(entry["cells"]),
            )
        )
    missing = [f"warning: no map of {name!r}: {entry['none']}" for name, entry in entries.items() if "none" in entry]
    told = [*aligned(rows), f"  {cpu_seconds:.1f} CPU s"] if len(rows) > 1 else []
    return [*told, *missing]


def _ends(wanted: Outputs) -> tuple[float, float] | None:
    """Of the scale, where false colours are asked for in lux."""
    return wanted.false_color_range if wanted.false_color == "illuminance" else None

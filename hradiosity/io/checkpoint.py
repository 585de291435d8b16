"""Checkpoints on disk: what a run needs to go on, and proof that it is the same run."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.sources import source_digest
from hradiosity.errors import OutputError
from hradiosity.io.output_folder import CHECKPOINT_FILE, write_file
from hradiosity.io.results_mesh import CHECKPOINT, write_checkpoint
from hradiosity.model.scene import Scene
from hradiosity.options import Options
from hradiosity.plan import Plan

MESH_FILE = "solution.vtkhdf"
_LAYOUT = 5
"""One more whenever a checkpoint keeps something else, so that none of an earlier program is taken up."""
_PLAN_FIELDS = (
    *("element_size", "rays_per_element", "light_points", "light_samples", "gather_samples"),
    *("occlusion", "interreflection"),
)
"""Entries of the plan that a replicate depends on."""
_OTHER_OPTIONS = frozenset({*_PLAN_FIELDS, "replicates", "accuracy", "time", "pictures", "audit"})
"""Options that the plan has taken up, that only say when to stop, or that no replicate depends on."""


def run_digest(scene: Scene, plan: Plan, options: Options, device: str) -> str:
    """32 hex digits over everything that the bits of a replicate depend on, views and names of files aside."""
    digest = hashlib.sha256()
    described = [getattr(scene, f.name) for f in fields(scene) if f.name not in ("name", "path", "views", "notes")]
    settings = [getattr(plan, name) for name in _PLAN_FIELDS]
    choices = [[f.name, getattr(options, f.name)] for f in fields(options) if f.name not in _OTHER_OPTIONS]
    _feed(digest, [described, settings, choices, device, source_digest(), _LAYOUT])
    return digest.hexdigest()[:32]


def save_checkpoint(folder: Path, checkpoint: Mapping[str, NDArray[Any]], digest: str) -> None:
    """Write ``checkpoint.h5`` in place of an earlier one.

    Raises
    ------
    OutputError
        When it can't be written; an earlier one is still there.
    """
    import h5py

    memory = io.BytesIO()
    with h5py.File(memory, "w") as file:
        write_checkpoint(file, checkpoint, digest)
    write_file(folder / CHECKPOINT_FILE, memory.getvalue())


def load_checkpoint(out: Path, partial: Path) -> tuple[dict[str, NDArray[Any]], str, Path]:
    """The checkpoint of a run that was broken off, or else of the result in ``OUT``.

    Returns
    -------
    arrays, digest, path
        What was kept, of what, and the file it came from.

    Raises
    ------
    OutputError
        When there is none or it can't be read.
    """
    for path in (partial / CHECKPOINT_FILE, out / MESH_FILE):
        if path.is_file():
            return *_read(path), path
    raise OutputError(f"there is nothing to resume in {out} or {partial}; start without --resume")


def _read(path: Path) -> tuple[dict[str, NDArray[Any]], str]:
    import h5py

    arrays: dict[str, NDArray[Any]] = {}

    def keep(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset):
            arrays[name] = item[()]

    try:
        with h5py.File(path, "r") as file:
            group = file[CHECKPOINT]
            group.visititems(keep)
            digest = str(group.attrs["digest"])
    except (OSError, KeyError) as error:
        raise OutputError(f"{path} is damaged and can't be resumed from; start without --resume") from error
    return {name: np.asarray(array) for name, array in arrays.items()}, digest


def _feed(digest: hashlib._Hash, value: object) -> None:
    """Add a value made of dataclasses, arrays, sequences and plain values, with types and shapes."""
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
    elif is_dataclass(value) and not isinstance(value, type):
        digest.update(type(value).__name__.encode())
        for entry in fields(value):
            _feed(digest, getattr(value, entry.name))
    elif isinstance(value, list | tuple):
        digest.update(f"[{len(value)}]".encode())
        for item in value:
            _feed(digest, item)
    else:
        digest.update(f"{type(value).__name__}:{value!r};".encode())

"""Reads files on request, in a process that may crash: paths come in a line each, answers go out as JSON, a line each.

An answer is ``{"faults": [...]}``, empty if the file could be read, or ``{"escaped": traceback}`` for an exception that
is no `SceneError`.
"""

import json
import sys
import traceback
import warnings
from pathlib import Path

from hradiosity.errors import Fault, SceneError
from hradiosity.io.mesh.raw import Texture
from hradiosity.io.mesh.texture import mean_colour
from hradiosity.io.mesh.worker import limit_memory, load
from hradiosity.io.scene_toml import load_scene
from hradiosity.io.spectra import read_spectrum_csv

PICTURES = (".png", ".jpg", ".bmp", ".gif", ".tif", ".webp")


def read(path):
    """Whatever the program would do with a file of this kind."""
    if path.suffix == ".toml":
        load_scene(path)
    elif path.suffix == ".csv":
        read_spectrum_csv(path, kind="power")
    elif path.suffix in PICTURES:
        read_picture(Texture(path.name, path))
    elif path.suffix == ".mtl":
        for label in load(path.with_suffix(".obj")).labels:
            read_picture(label.texture)
    else:
        load(path)


def read_picture(texture):
    """The mean colour; a `ValueError` is what a picture that can't be read gives by its contract."""
    try:
        if texture is not None:
            mean_colour(texture)
    except ValueError as error:
        raise SceneError([Fault(texture.name, "", str(error), "")]) from error


def answer(path):
    """What reading one file leads to."""
    try:
        read(path)
    except SceneError as error:
        return {"faults": [str(fault) for fault in error.faults]}
    except Exception:  # an exception of any other kind is what is looked for
        return {"escaped": traceback.format_exc()}
    return {"faults": []}


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    limit_memory(Path(__file__))
    for line in sys.stdin:
        print("\n" + json.dumps(answer(Path(line.rstrip("\n")))), flush=True)

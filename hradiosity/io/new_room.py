"""Starts a user off: a commented scene folder to edit."""

import shutil
from importlib.resources import as_file, files
from pathlib import Path

from hradiosity.errors import OutputError


def write_new_room(folder: str | Path) -> Path:
    """Write a small room with paints, lamps, sensors and a view, every key with a remark.

    Parameters
    ----------
    folder : path
        Made if it does not exist; an empty one is filled.

    Returns
    -------
    Path
        The scene file in it.

    Raises
    ------
    OutputError
        When there is something at that place already, which is left as it is, or the folder can't be written.
    """
    target = Path(folder)
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        raise OutputError(f"{target} exists already and is left as it is; name a new folder")
    with as_file(files("hradiosity.io") / "templates" / "room") as template:
        try:
            shutil.copytree(template, target, dirs_exist_ok=True)
        except (OSError, shutil.Error) as error:
            raise OutputError(f"{target} can't be written: {error}") from error
    return target / "scene.toml"

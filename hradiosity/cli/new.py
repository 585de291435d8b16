"""``hradiosity new``."""

from __future__ import annotations

import shlex
from pathlib import Path

from cyclopts import App

app = App(name="new", help="Start a new scene.", help_format="plaintext")


@app.command
def room(folder: Path = Path("room"), /) -> int:
    """Write a small room to edit: a commented scene.toml with paints, lamps, sensors and a view.

    Parameters
    ----------
    folder
        A new or empty folder.
    """
    from hradiosity.io.new_room import write_new_room

    file = write_new_room(folder)
    word = shlex.quote(str(folder))
    print(f"wrote {file}\nnext: edit it, then\n  hradiosity plan {word}\n  hradiosity render {word}")
    return 0

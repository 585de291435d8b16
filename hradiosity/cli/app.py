"""All verbs together."""

from __future__ import annotations

from cyclopts import App

from hradiosity import __version__
from hradiosity.cli import check, cost, devices, new, plan, render, schema, validate, view

HELP = """Spectral radiosity for lighting research: the spectrum of light at each place of a room, with its error.

Start with `hradiosity new room my_room`, edit my_room/scene.toml, then `hradiosity render my_room`.
With any verb, --debug shows where in the program a mistake in the input was noticed.
"""


def make_app() -> App:
    """The program as cyclopts sees it."""
    app = App(
        name="hradiosity",
        help=HELP,
        version=f"hradiosity {__version__}",
        help_format="plaintext",
        suppress_keyboard_interrupt=False,
    )
    app.command(render.render)
    app.command(plan.plan)
    app.command(check.check)
    app.command(cost.cost)
    app.command(devices.devices)
    app.command(view.view)
    app.command(validate.validate)
    app.command(schema.schema)
    app.command(new.app)
    return app

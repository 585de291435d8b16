"""The command line: one file a verb; arguments become calls of the layers below."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Final

GOOD: Final = 0
FAILED: Final = 1
BAD_INPUT: Final = 2
INACCURATE: Final = 3
INTERRUPTED: Final = 130
DEBUG: Final = "--debug"
"""With any verb: show where in the program a mistake of the user was noticed."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb.

    Parameters
    ----------
    arguments : sequence of str, optional
        Without the program's name; those of the process if left out.

    Returns
    -------
    int
        0 good, 1 outside the bars of a validation, 2 bad input, 3 accuracy not reached (results written),
        130 interrupted (what was known is written).
    """
    from cyclopts import CycloptsError

    from hradiosity.cli.app import make_app
    from hradiosity.errors import HradiosityError

    given = list(sys.argv[1:] if arguments is None else arguments)
    tokens = [token for token in given if token != DEBUG]
    try:
        code = make_app()(tokens, exit_on_error=False, result_action="return_value")
    except CycloptsError:
        return BAD_INPUT
    except HradiosityError as error:
        if DEBUG in given:
            raise
        _print_faults(error)
        return BAD_INPUT
    except MemoryError as error:
        if DEBUG in given:
            raise
        print(f"not enough memory: {error}; fewer or larger elements need less", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("interrupted; nothing was known yet, and nothing was written", file=sys.stderr)
        return INTERRUPTED
    return code if isinstance(code, int) else GOOD


def _print_faults(error: Exception) -> None:
    """On standard error; a caller's own output stays clean."""
    faults = getattr(error, "faults", ())
    if len(faults) > 1:
        print(f"{len(faults)} faults:", file=sys.stderr)
    print(error, file=sys.stderr)

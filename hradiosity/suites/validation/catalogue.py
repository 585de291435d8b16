"""All cases by name, cheap ones first."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from fnmatch import fnmatchcase

from hradiosity.errors import Fault, SceneError
from hradiosity.suites.validation import cie171, closed_forms, daylight, polygons, rooms
from hradiosity.suites.validation.values import Case, NotRun


def all_cases() -> list[Case]:
    """What is run when nothing is chosen."""
    return [*polygons.cases(), *cie171.cases(), *closed_forms.cases(), *rooms.cases(), *daylight.cases()]


def all_not_run() -> list[NotRun]:
    """What cannot be run, and why."""
    return [*polygons.not_run(), *closed_forms.not_run(), *daylight.not_run()]


def chosen(wanted: Sequence[str]) -> tuple[list[Case], list[NotRun]]:
    """Cases whose name is wanted, begins with it and a hyphen, or fits it as a pattern with * and ?.

    Raises
    ------
    SceneError
        For each wanted name that fits no case, with the names that are like it.
    """
    cases, not_run = all_cases(), all_not_run()
    if not wanted:
        return cases, not_run
    names = [case.name for case in cases] + [case.name for case in not_run]
    unknown = [word for word in wanted if not any(_fits(name, word) for name in names)]
    if unknown:
        raise SceneError([Fault("command line", "--case", f"no case {word!r}", _like(word, names)) for word in unknown])

    def keep(name: str) -> bool:
        return any(_fits(name, word) for word in wanted)

    return [case for case in cases if keep(case.name)], [case for case in not_run if keep(case.name)]


def _fits(name: str, word: str) -> bool:
    return name == word or name.startswith(f"{word}-") or fnmatchcase(name, word)


def _like(word: str, names: Sequence[str]) -> str:
    near = [name for name in names if word.lower() in name.lower()]
    near += [name for name in difflib.get_close_matches(word, names, n=3, cutoff=0.4) if name not in near]
    return f"did you mean {', '.join(near[:3])}?" if near else "hradiosity validate --list names all"

"""The reference values that come with the package; ``hradiosity/suites/data/README.md`` tells where they are from."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import Any


@cache
def _load(name: str) -> Any:
    return json.loads((files("hradiosity.suites") / "data" / name).read_text(encoding="utf-8"))


def cie171() -> dict[str, dict[str, Any]]:
    """Analytical cases of CIE 171:2006, by name."""
    return {case["id"]: case for case in _load("cie171.json")["cases"]}


def form_factors() -> list[dict[str, Any]]:
    """Entries of the form-factor catalogue."""
    entries: list[dict[str, Any]] = _load("form_factors.json")["entries"]
    return entries


def box_rooms() -> dict[str, dict[str, Any]]:
    """Continuous solutions of rooms that are boxes, by name."""
    return {case["id"]: case for case in _load("scenes.json")["box"]}


def closed_forms() -> dict[str, dict[str, Any]]:
    """Whole scenes with closed-form solutions, by name."""
    return {case["id"]: case for case in _load("scenes.json")["closed_form"]}


def colour_values() -> dict[str, Any]:
    """What other programs say of the colour of illuminants and analytic spectra, and of what they do to the eye."""
    found: dict[str, Any] = _load("colour.json")
    return found

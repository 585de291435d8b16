"""Text of scene files: boxes as TOML tables, spectra as CSV."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import numpy as np
from furniture import Box
from numpy.typing import NDArray

Curve = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Reflectance 0 … 1 at wavelengths [nm]."""


def number(value: float) -> str:
    """Shortest decimal within a micrometre (or a millionth of a degree)."""
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0.0" if text == "-0" else text if "." in text else f"{text}.0"


def _vector(values: Iterable[float]) -> str:
    return "[" + ", ".join(number(value) for value in values) + "]"


def box_table(box: Box) -> str:
    """One ``[[box]]`` table."""
    lines = ["[[box]]", f'name = "{box.name}"', f"centre = {_vector(box.centre)}", f"size = {_vector(box.size)}"]
    turn = (box.turn + 180.0) % 360.0 - 180.0
    if abs(turn) > 1e-9:
        lines.append(f"rotation_deg = {number(turn)}")
    lines.append(f'material = "{box.material}"')
    if box.faces:
        lines.append("faces = { " + ", ".join(f'{face} = "{material}"' for face, material in box.faces) + " }")
    if box.lamp is not None:
        lines.append(f'luminaires = {{ bottom = "{box.lamp}" }}')
    return "\n".join(lines) + "\n"


def write_spectra(folder: Path, curves: Mapping[str, tuple[str, Curve]]) -> None:
    """One CSV file a curve, 380 to 780 nm in 5 nm, with a first line that says what it is.

    curves : by file name without suffix: what the paint is, and its reflectance
    """
    folder.mkdir(parents=True, exist_ok=True)
    wavelength = np.arange(380.0, 781.0, 5.0)
    for name, (what, curve) in curves.items():
        rows = "".join(f"{w:.0f},{r:.4f}\n" for w, r in zip(wavelength, curve(wavelength), strict=True))
        head = f"# {what}: a smooth curve made for this example, not a measurement\nwavelength_nm,reflectance\n"
        (folder / f"{name}.csv").write_text(head + rows, encoding="utf-8")


def sigmoid(wavelength: NDArray[np.float64], middle: float, width: float) -> NDArray[np.float64]:
    """Step from 0 to 1 at ``middle``, about 4 ``width`` wide [nm]."""
    return 1.0 / (1.0 + np.exp((middle - wavelength) / width))


def bump(wavelength: NDArray[np.float64], middle: float, width: float) -> NDArray[np.float64]:
    """Bell of height 1 at ``middle`` with standard deviation ``width`` [nm]."""
    return np.exp(-0.5 * ((wavelength - middle) / width) ** 2)

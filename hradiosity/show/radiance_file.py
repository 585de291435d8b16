"""Radiance pictures: four bytes a pixel, red, green and blue with one exponent, run-length encoded (Ward 1991)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hradiosity.metrics.colorimetric import linear_rgb_matrix

PRIMARIES: Final = np.array([[0.640, 0.330], [0.290, 0.600], [0.150, 0.060]])
"""Chromaticities of Radiance's own red, green and blue; its white has equal energy."""
WHITE: Final = np.array([1.0 / 3.0, 1.0 / 3.0])
EFFICACY: Final = 179.0
"""Luminous efficacy by which Radiance turns its watts into lumens [lm W⁻¹]."""
_LONGEST_RUN, _SHORTEST_RUN, _LONGEST_LITERAL = 127, 4, 128


def radiance_picture(xyz: NDArray[np.floating], texts: Mapping[str, str]) -> bytes:
    """A Radiance picture whose luminances, as Radiance's tools read them, are in cd m⁻².

    Parameters
    ----------
    xyz : (height, width, 3) float
        X, Y, Z with Y in cd m⁻². What lies outside of Radiance's primaries is clipped there.
    texts : mapping
        Lines of the header.
    """
    height, width = xyz.shape[:2]
    rgb = np.einsum("hwc,rc->hwr", xyz.astype(np.float64), linear_rgb_matrix(PRIMARIES, WHITE)) / EFFICACY
    coded = shared_exponent(np.maximum(rgb, 0.0))
    lines = ["#?RADIANCE", *(f"{name}={text}" for name, text in texts.items()), "FORMAT=32-bit_rle_rgbe"]
    header = "\n".join(lines) + f"\n\n-Y {height} +X {width}\n"
    body = b"".join(scan_line(row) for row in coded) if 8 <= width < 32768 else coded.tobytes()
    return header.encode("utf-8") + body


def shared_exponent(rgb: NDArray[np.float64]) -> NDArray[np.uint8]:
    """(…, 4) bytes of values (…, 3) >= 0: mantissas over 256 times 2 to the power of the last byte less 128."""
    largest = rgb.max(axis=-1)
    exponent = np.frexp(largest)[1]
    coded = np.zeros((*rgb.shape[:-1], 4), np.uint8)
    seen = largest > 1e-32
    mantissa = np.ldexp(rgb, 8 - exponent[..., None])
    coded[..., :3] = np.where(seen[..., None], mantissa, 0.0).astype(np.uint8)
    coded[..., 3] = np.where(seen, exponent + 128, 0)
    return coded


def scan_line(pixels: NDArray[np.uint8]) -> bytes:
    """One row (width, 4), each byte of the pixels run-length encoded on its own; 8 to 32767 wide."""
    width = len(pixels)
    parts = [bytes([2, 2, width >> 8, width & 255])]
    parts += [_runs(pixels[:, byte]) for byte in range(4)]
    return b"".join(parts)


def _runs(values: NDArray[np.uint8]) -> bytes:
    """Runs of equal values as 128 + length and the value; all between as their number and themselves."""
    edges = np.flatnonzero(np.diff(values)) + 1
    starts = np.concatenate([[0], edges])
    lengths = np.diff(np.concatenate([starts, [len(values)]]))
    long = lengths >= _SHORTEST_RUN
    out, literal_from = bytearray(), 0
    raw = values.tobytes()
    for start, length in zip(starts[long].tolist(), lengths[long].tolist(), strict=True):
        _put_literals(out, raw[literal_from:start])
        for done in range(0, length, _LONGEST_RUN):
            out += bytes([128 + min(_LONGEST_RUN, length - done), raw[start]])
        literal_from = start + length
    _put_literals(out, raw[literal_from:])
    return bytes(out)


def _put_literals(out: bytearray, raw: bytes) -> None:
    for first in range(0, len(raw), _LONGEST_LITERAL):
        some = raw[first : first + _LONGEST_LITERAL]
        out.append(len(some))
        out += some

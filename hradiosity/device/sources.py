"""Kernel sources: where they are, and how their includes are put in."""

import hashlib
import re
from functools import cache
from importlib.resources import files
from pathlib import Path

_INCLUDE = re.compile(r'^\s*#include\s+"([^"]+)"\s*$')
_PREAMBLE = (
    # PoCL contracts x*y - u*v to a fused form otherwise; rays aimed at a shared edge then miss both triangles.
    "#pragma OPENCL FP_CONTRACT OFF\n"
)


@cache
def kernel_root() -> Path:
    """Folder with ``include/`` and ``kernels/``: inside the package when installed, beside it in a checkout.

    Raises
    ------
    FileNotFoundError
        When neither is there: a broken installation.
    """
    packaged = Path(str(files("hradiosity") / "cl"))
    checkout = Path(__file__).resolve().parents[2] / "cl"
    for root in (packaged, checkout):
        if (root / "include").is_dir() and (root / "kernels").is_dir():
            return root
    raise FileNotFoundError(f"no kernel sources at {packaged} or {checkout}")


def load_source(names: tuple[str, ...], root: Path | None = None) -> str:
    """Text of one program: the named files with every include inlined once, each line traceable by ``#line``.

    Includes are written from the root of ``cl/``, as in ``#include "include/hr_ray.h"``. They are inlined here since
    an include path with a space in it can't be handed to an OpenCL compiler.

    Parameters
    ----------
    names : tuple of str
        Files relative to the root, for example ``("kernels/rays.cl",)``.

    Raises
    ------
    FileNotFoundError
        When a file is missing; the message names the line that asked for it.
    """
    base = root or kernel_root()
    seen: set[str] = set()
    return _PREAMBLE + "".join(_inline(base, name, seen, asked_by="the caller") for name in names)


@cache
def source_digest() -> str:
    """16 hex digits over all files of ``cl/``: an option of every build, so that no driver serves stale binaries."""
    digest = hashlib.sha256()
    for path in sorted(kernel_root().rglob("*.*")):
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _inline(root: Path, name: str, seen: set[str], asked_by: str) -> str:
    if name in seen:
        return ""
    seen.add(name)
    path = root / name
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no such kernel source (asked for by {asked_by})")
    parts = [f'#line 1 "{name}"\n']
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        include = _INCLUDE.match(line)
        if include:
            parts.append(_inline(root, include.group(1), seen, asked_by=f"{name}:{number}"))
            parts.append(f'#line {number + 1} "{name}"\n')
        else:
            parts.append(line + "\n")
    return "".join(parts)

"""Rules that every file of the repository keeps."""

import re
import shutil
from pathlib import Path

import pytest
from fresh_environment import OWN_SUITE, tracked_files

KERNELS = sorted((OWN_SUITE / "cl").rglob("*.*"))
FORBIDDEN_IN_KERNELS = {
    "vectors that the packaged driver is slow or wrong with": r"\b(?:real|float|u?int|u?long|double)16\b|\bdouble8\b",
    "contraction by hand": r"\b(?:fma|mad|mad24|mad_hi|mad_sat)\s*\(",
    "the unstable form of Lambert's formula": r"\ba(?:cos|cospi)\s*\(",
    "inexact functions": r"\b(?:native|half)_[a-z]+\d*\s*\(",
    "atomics on floats": r"\batom(?:ic)?_(?:xchg|cmpxchg)\s*\([^;]*(?:as_u?int|float)|\batomic_fetch_add|atomic_float",
    "fast mathematics": r"-cl-(?:fast-relaxed-math|unsafe-math|mad-enable|finite-math|no-signed-zeros)",
    "contraction by pragma": r"FP_CONTRACT\s+ON",
}
INCLUDE_UNSEEN = re.compile(r'^[ \t]*#[ \t]*include\b(?! "include/[a-z_]+\.h"$).*', re.MULTILINE)
"""The loader takes lines with nothing but the include, written from the root of ``cl/``."""
MACHINE_PATHS = re.compile(r"(?<![\w.~)])/(?:work|opt|root|home|Users)/\w")
REGISTRY_HOSTS = re.compile(
    r"\b(?:test\.)?pypi\.(?:org|python\.org)|pythonhosted\.org|conda\.anaconda\.org", re.IGNORECASE
)
IN_A_CHECKOUT = pytest.mark.skipif(
    shutil.which("git") is None or not (OWN_SUITE / ".git").exists(), reason="looks at the files that git knows"
)


def without_comments(source: str) -> str:
    """The same lines without block comments; the sources have no others."""
    return re.sub(r"/\*.*?\*/", lambda found: "\n" * found[0].count("\n"), source, flags=re.DOTALL)


def offences(source: str) -> list[str]:
    """What in a kernel source is forbidden, with line numbers."""
    code = without_comments(source)
    rules = {why: re.compile(pattern) for why, pattern in FORBIDDEN_IN_KERNELS.items()}
    rules["an include that the loader does not see"] = INCLUDE_UNSEEN
    return [
        f"line {code.count(chr(10), 0, found.start()) + 1}: {found[0].strip()} ({why})"
        for why, rule in rules.items()
        for found in rule.finditer(code)
    ]


@pytest.mark.parametrize("path", KERNELS, ids=lambda path: path.name)
def test_kernels_keep_the_rules(path):
    assert offences(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    "line",
    [
        "float16 v;",
        "double8 v;",
        "y = fma(a, b, c);",
        "y = mad (a, b, c);",
        "y = acos(x);",
        "y = native_sin(x);",
        "y = half_sqrt(x);",
        "y = native_rsqrt(x);",
        "atomic_xchg(&sum, as_uint(x));",
        "#pragma OPENCL FP_CONTRACT ON",
        '#include "include/hr_types.h"  // why',
        '#include "hr_types.h"',
    ],
)
def test_an_offence_is_found(line):
    assert offences(f"/* a\nremark */\n{line}\n")[0].startswith("line 3")


@pytest.mark.parametrize(
    "line", ["hr_half_area(b)", "/* no float16, fma(), acos() */", 'p = "x"; int4 q;', "uint64(x)"]
)
def test_no_offence_is_invented(line):
    assert offences(line) == []


def test_kernels_stand_apart_from_device_functions():
    """Kernels in kernels/, device functions in include/."""
    for path in KERNELS:
        has_kernel = "__kernel" in without_comments(path.read_text(encoding="utf-8"))
        assert has_kernel == (path.parent.name == "kernels"), path


def test_kernels_take_the_number_of_items():
    """The device launches each kernel with no items first, so that compiling is not taken for work."""
    for path in KERNELS:
        text = without_comments(path.read_text(encoding="utf-8"))
        for kernel in text.split("__kernel")[1:]:
            assert re.search(r"\bconst uint n_items\s*\)\s*{", kernel), path


def test_headers_are_guarded():
    for path in sorted((OWN_SUITE / "cl" / "include").glob("*.h")):
        guard = path.stem.upper() + "_H"
        assert re.search(rf"#ifndef {guard}\n#define {guard}\n", path.read_text(encoding="utf-8")), path


@IN_A_CHECKOUT
def test_no_file_speaks_of_a_machine():
    """Paths and hosts that only exist where somebody works make a repository fail elsewhere."""
    here = Path(__file__).relative_to(OWN_SUITE).as_posix()
    found = []
    for name in tracked_files():
        content = (OWN_SUITE / name).read_bytes()
        if name == here or b"\0" in content:
            continue
        text = content.decode("utf-8")
        found += [f"{name}: {match[0]}" for rule in (MACHINE_PATHS, REGISTRY_HOSTS) for match in rule.finditer(text)]
    assert found == []


@IN_A_CHECKOUT
def test_no_file_is_large():
    """Results and caches slip in easily."""
    large = [name for name in tracked_files() if (OWN_SUITE / name).stat().st_size > 500_000]
    assert large == []

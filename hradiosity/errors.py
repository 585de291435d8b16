"""Exceptions that reach a user; everything else is a programming error."""

from collections.abc import Sequence
from dataclasses import dataclass

LONGEST_FOUND, LONGEST_EXPECTED = 300, 1200
"""Letters of a fault that are shown; paths are long, and what is expected may be a list of names."""


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong in what the user wrote.

    file : the file it stands in, as the user named it
    entry : dotted path of the entry inside the file, for example ``materials.wall.reflectance``
    found : what stands there
    expected : what would be right, or what to do
    """

    file: str
    entry: str
    found: str
    expected: str

    def __str__(self) -> str:
        entry, found = (_shortened(text, LONGEST_FOUND) for text in (self.entry, self.found))
        file, expected = (_shortened(text, LONGEST_EXPECTED) for text in (self.file, self.expected))
        place = f"{file}: {entry}" if entry else file
        return f"{place}: {found}; {expected}" if expected else f"{place}: {found}"


def _shortened(text: str, longest: int) -> str:
    """Both ends of what is too long to be read: a damaged file may hold words of thousands of letters."""
    if len(text) <= longest:
        return text
    half = longest // 2 - 20
    return f"{text[:half]} [… {len(text)} characters …] {text[-half:]}"


class HradiosityError(Exception):
    """Base of all errors that this package raises on purpose."""


class SceneError(HradiosityError):
    """The input can't be used; carries every fault found, not only the first.

    Parameters
    ----------
    faults : sequence of Fault
        At least one.
    """

    def __init__(self, faults: Sequence[Fault]) -> None:
        if not faults:
            raise ValueError("a SceneError needs at least one fault")
        self.faults: tuple[Fault, ...] = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))


class DeviceError(HradiosityError):
    """No OpenCL device, a kernel that does not build (with the build log), or a device that failed."""


class OutputError(HradiosityError):
    """A result can't be written: names the path and the cause."""

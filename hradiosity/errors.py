"""Exceptions that reach a user; everything else is a programming error."""

from collections.abc import Sequence
from dataclasses import dataclass


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
        place = f"{self.file}: {self.entry}" if self.entry else self.file
        return f"{place}: {self.found}; {self.expected}" if self.expected else f"{place}: {self.found}"


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

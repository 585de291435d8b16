"""Which OpenCL device to take, and why."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hradiosity.errors import DeviceError

if TYPE_CHECKING:
    import pyopencl as cl

ENVIRONMENT_VARIABLE = "HRADIOSITY_DEVICE"
_INSTALL_HINT = (
    "no OpenCL driver was found; on Linux x86-64 `pip install pocl-binary-distribution` brings a CPU driver, "
    "elsewhere install the graphics driver or PoCL from conda-forge"
)


@dataclass(frozen=True)
class DeviceInfo:
    """One OpenCL device as the user sees it.

    index : position in `list_devices`, which ``--device`` takes
    rank : the lower, the sooner it is taken by default
    """

    index: int
    name: str
    platform: str
    version: str
    kind: str
    compute_units: int
    global_memory_bytes: int
    has_double: bool
    rank: int
    reason: str


def list_devices() -> tuple[DeviceInfo, ...]:
    """All OpenCL devices, in the order that their drivers give.

    Raises
    ------
    DeviceError
        When no driver is installed.
    """
    return tuple(_describe(i, device) for i, device in enumerate(_devices()))


def choose_device(spec: str | None = None) -> tuple[cl.Device, DeviceInfo]:
    """Take the device that `spec` names, else the one in ``HRADIOSITY_DEVICE``, else the best ranked.

    Parameters
    ----------
    spec : str, optional
        An index of `list_devices`, or a part of a device's name, platform or version (case does not matter).

    Raises
    ------
    DeviceError
        When there is no device, or none fits `spec`.
    """
    devices = _devices()
    infos = [_describe(i, device) for i, device in enumerate(devices)]
    wanted = spec or os.environ.get(ENVIRONMENT_VARIABLE)
    if wanted:
        fitting = [i for i in infos if _fits(i, wanted)]
        if not fitting:
            known = "; ".join(f"{i.index}: {i.name} ({i.version})" for i in infos)
            raise DeviceError(f"no OpenCL device fits {wanted!r}; there are {known}")
        infos = fitting
    best = min(infos, key=lambda i: (i.rank, i.index))
    return devices[best.index], best


def _devices() -> list[cl.Device]:
    import pyopencl as cl

    try:
        platforms = cl.get_platforms()
    except cl.LogicError as error:
        raise DeviceError(_INSTALL_HINT) from error
    devices = [device for platform in platforms for device in platform.get_devices()]
    if not devices:
        raise DeviceError(_INSTALL_HINT)
    return devices


def _fits(info: DeviceInfo, wanted: str) -> bool:
    if wanted.isdigit():
        return info.index == int(wanted)
    text = f"{info.name} {info.platform} {info.version}".lower()
    return wanted.lower() in text


def _describe(index: int, device: cl.Device) -> DeviceInfo:
    import pyopencl as cl

    platform = device.platform
    kind = "GPU" if device.type & cl.device_type.GPU else "CPU" if device.type & cl.device_type.CPU else "other"
    rank, reason = _rank(platform.name, platform.version, kind)
    return DeviceInfo(
        index=index,
        name=device.name.strip(),
        platform=platform.name.strip(),
        version=platform.version.strip(),
        kind=kind,
        compute_units=device.max_compute_units,
        global_memory_bytes=device.global_mem_size,
        has_double="cl_khr_fp64" in device.extensions,
        rank=rank,
        reason=reason,
    )


def _rank(platform: str, version: str, kind: str) -> tuple[int, str]:
    """Preference: the packaged PoCL (what the tests run on), another PoCL, another CPU, a GPU; a checker never."""
    if "oclgrind" in platform.lower():
        return 9, "memory checker, only when asked for"
    if "pocl" in version.lower() or "portable computing language" in platform.lower():
        if "debian" in version.lower():
            return 1, "system PoCL"
        return 0, "packaged PoCL, the tested default"
    return (2, "other CPU driver") if kind == "CPU" else (3, "only when asked for with --device")

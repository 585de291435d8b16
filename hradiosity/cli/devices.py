"""``hradiosity devices``."""

from __future__ import annotations


def devices(*, device: str | None = None) -> int:
    """List the OpenCL devices, and say which one is taken and why.

    Parameters
    ----------
    device
        Show which one this would take: a number from the list, or a part of a name.
    """
    from hradiosity.device import Device
    from hradiosity.device.choice import ENVIRONMENT_VARIABLE, choose_device, list_devices

    _, chosen = choose_device(device)
    for info in list_devices():
        mark = "*" if info.index == chosen.index else " "
        print(f"{mark} {info.index}: {info.name}")
        print(f"     {info.platform}, {info.version}")
        print(
            f"     {info.kind}, {info.compute_units} compute units, {info.global_memory_bytes / 2**30:.1f} GiB, "
            f"{'with' if info.has_double else 'without'} double precision; {info.reason}"
        )
    seconds = Device(device).prove()
    print(f"\nA kernel was built and gave the right numbers there, in {seconds:.2f} s.")
    print(f"* is taken; choose another with --device or {ENVIRONMENT_VARIABLE}, by number or a part of its name.")
    return 0

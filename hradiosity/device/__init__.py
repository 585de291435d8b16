"""OpenCL devices, programs, kernels and arrays; the only place that imports pyopencl."""

from hradiosity.device.choice import DeviceInfo, list_devices
from hradiosity.device.device import Device
from hradiosity.device.kernel import Kernel
from hradiosity.device.sources import kernel_root, load_source

__all__ = ["Device", "DeviceInfo", "Kernel", "kernel_root", "list_devices", "load_source"]

"""Kernels that are called with named arguments."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from hradiosity.device.build_time import BuildTime
from hradiosity.errors import DeviceError

if TYPE_CHECKING:
    import pyopencl as cl

LOCAL_SIZE = 64
"""Work-items a group; one size only, since PoCL compiles a kernel anew for each."""
WIDE_GRID = 65535
"""PoCL compiles a kernel once for launches narrower than this, and once for others."""

_SCALARS: dict[str, type[np.generic]] = {
    "int": np.int32,
    "uint": np.uint32,
    "float": np.float32,
    "double": np.float64,
    "ulong": np.uint64,
    "long": np.int64,
}
_POINTERS = {f"{name}*": dtype for name, dtype in _SCALARS.items()} | {
    "uchar*": np.uint8,
    "char*": np.int8,
    "ushort*": np.uint16,
}


class Kernel:
    """One ``__kernel``, called with the names of its arguments.

    ``kernel(n, name=value, …)`` runs `n` work-items in groups of 64; the kernel itself returns for ids beyond `n`,
    which it gets as its argument ``n_items`` if it declares one. Drivers may leave compiling to the first launch;
    that is done with no items beforehand, so that its time is told from the time of the work.
    """

    def __init__(
        self,
        kernel: cl.Kernel,
        queue: cl.CommandQueue,
        record: Callable[[str, int, cl.Event], None],
        build_time: BuildTime,
        local_size: int,
    ) -> None:
        import pyopencl as cl

        self._kernel = kernel
        self._queue = queue
        self._record = record
        self._build_time = build_time
        self._compiled: set[bool] = set()
        self._local_size = local_size
        self.name: str = kernel.function_name
        info = cl.kernel_arg_info
        self._arguments: dict[str, str] = {
            str(kernel.get_arg_info(i, info.NAME)): str(kernel.get_arg_info(i, info.TYPE_NAME)).replace("const ", "")
            for i in range(kernel.num_args)
        }

    def __call__(self, n_items: int, **arguments: Any) -> None:
        """Enqueue `n_items` work-items.

        Raises
        ------
        TypeError
            When an argument is missing, unknown or of another type than the kernel declares.
        DeviceError
            When the driver refuses the launch.
        """
        import pyopencl as cl

        if n_items <= 0:
            return
        if "n_items" in self._arguments:
            arguments["n_items"] = n_items
        if arguments.keys() != self._arguments.keys():
            missing = sorted(self._arguments.keys() - arguments.keys())
            unknown = sorted(arguments.keys() - self._arguments.keys())
            raise TypeError(f"kernel {self.name}: missing {missing}, unknown {unknown}")
        for position, (name, kind) in enumerate(self._arguments.items()):
            self._kernel.set_arg(position, self._convert(name, kind, arguments[name]))
        size = -(-n_items // self._local_size) * self._local_size
        try:
            self._compile(size, n_items)
            event = cl.enqueue_nd_range_kernel(self._queue, self._kernel, (size,), (self._local_size,))
        except cl.Error as error:
            raise DeviceError(f"kernel {self.name} with {n_items} work-items: {error}") from error
        self._record(self.name, n_items, event)

    def _compile(self, size: int, n_items: int) -> None:
        """Launch without items, once for each of the ways in which a driver may compile the kernel."""
        import pyopencl as cl

        is_wide = size >= WIDE_GRID
        if is_wide in self._compiled or "n_items" not in self._arguments:
            return
        self._compiled.add(is_wide)
        position = list(self._arguments).index("n_items")
        kind = self._arguments["n_items"]
        self._queue.finish()
        with self._build_time.counted():
            self._kernel.set_arg(position, _SCALARS[kind](0))
            cl.enqueue_nd_range_kernel(self._queue, self._kernel, (size,), (self._local_size,))
            self._queue.finish()
        self._kernel.set_arg(position, _SCALARS[kind](n_items))

    def _convert(self, name: str, kind: str, value: Any) -> Any:
        if kind in _SCALARS:
            if not isinstance(value, int | float | np.number):
                raise TypeError(f"kernel {self.name}: {name} must be a number ({kind}), is {type(value).__name__}")
            return _SCALARS[kind](value)
        expected = _POINTERS.get(kind)
        if expected is None:
            raise TypeError(f"kernel {self.name}: {name} has the type {kind}, which can't be passed")
        if not hasattr(value, "base_data"):
            raise TypeError(f"kernel {self.name}: {name} must be a device array, is {type(value).__name__}")
        if value.dtype != np.dtype(expected):
            raise TypeError(f"kernel {self.name}: {name} must be {np.dtype(expected)} ({kind}), is {value.dtype}")
        return value.base_data

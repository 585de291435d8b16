"""An opened device: context, queue, programs and arrays."""

from __future__ import annotations

import time
import warnings
from collections import defaultdict
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hradiosity.device.build_time import BuildTime
from hradiosity.device.choice import DeviceInfo, choose_device
from hradiosity.device.kernel import LOCAL_SIZE, Kernel
from hradiosity.device.sources import load_source, source_digest
from hradiosity.device.watchdog import Watchdog
from hradiosity.errors import DeviceError

if TYPE_CHECKING:
    import pyopencl as cl

DeviceArray: TypeAlias = Any
"""A ``pyopencl.array.Array``; other layers only hold it, pass it to kernels and fetch it."""

BuildKey: TypeAlias = tuple[tuple[str, ...], tuple[tuple[str, str], ...]]


class Device:
    """One OpenCL device with everything that lives on it.

    Parameters
    ----------
    spec : str, optional
        See `hradiosity.device.choice.choose_device`.
    profile : bool
        Record the time of each launch; `profile_table` sums it up.
    """

    def __init__(self, spec: str | None = None, *, profile: bool = False) -> None:
        import pyopencl as cl

        device, self.info = choose_device(spec)
        self._context = cl.Context([device])
        profiling = cl.command_queue_properties.PROFILING_ENABLE
        self._queue = (
            cl.CommandQueue(self._context, properties=profiling) if profile else cl.CommandQueue(self._context)
        )
        self._profile = profile
        self._events: list[tuple[str, cl.Event]] = []
        self._programs: dict[BuildKey, cl.Program] = {}
        self._kernels: dict[tuple[BuildKey, str], Kernel] = {}
        self.build_time = BuildTime()
        self.watchdog = Watchdog(self.info.name)
        self.builds: list[str] = []
        """Kernels taken into use so far, each with its definitions and the digest of all sources."""
        self.on_build: Callable[[str], None] | None = None
        """Called with an entry of `builds` before the driver builds it or takes it from its cache."""

    @property
    def description(self) -> str:
        """Name, driver and size in one line."""
        info: DeviceInfo = self.info
        return f"{info.name} ({info.version}, {info.compute_units} compute units)"

    def work_cpu_seconds(self) -> float:
        """CPU seconds of this process so far, less those that building and loading kernels took."""
        return time.process_time() - self.build_time.cpu

    def kernel(self, source: str, name: str, **definitions: int | str) -> Kernel:
        """Kernel `name` of ``cl/kernels/<source>.cl``, built once for each set of definitions.

        Parameters
        ----------
        source : str
            File name without suffix.
        name : str
            The ``__kernel``'s name.
        **definitions
            Passed as ``-DNAME=value``.

        Raises
        ------
        DeviceError
            When the program does not build; carries the log with true file names and lines.
        """
        key: BuildKey = ((f"kernels/{source}.cl",), _sorted_definitions(definitions))
        held = self._kernels.get((key, name))
        if held is None:
            import pyopencl as cl

            self._announce(f"{source}.{name} {' '.join(f'{k}={v}' for k, v in key[1])} {source_digest()}")
            with self.build_time.counted():
                program = self._program(key)
                try:
                    held = self._kernel(program, name)
                except cl.Error as error:
                    raise DeviceError(f"kernels/{source}.cl has no kernel {name!r}") from error
            self._kernels[key, name] = held
        return held

    def kernel_from_text(self, text: str, name: str, **definitions: int | str) -> Kernel:
        """Kernel `name` of a source text (with includes already inlined); tests call device functions through it."""
        with self.build_time.counted():
            return self._kernel(self._build(text, _sorted_definitions(definitions), "a source text"), name)

    def upload(self, array: NDArray[Any], dtype: Any = None) -> DeviceArray:
        """Copy of a host array on the device, C-contiguous; an empty one gets room for one item.

        Raises
        ------
        DeviceError
            When the device has no room for it.
        """
        import pyopencl as cl
        import pyopencl.array as cl_array

        host = np.ascontiguousarray(array, dtype=dtype)
        if host.size == 0:
            return self.zeros((1,), host.dtype)
        try:
            return cl_array.to_device(self._queue, host)
        except cl.Error as error:
            raise self._no_room(host.nbytes, error) from error

    def zeros(self, shape: tuple[int, ...], dtype: Any) -> DeviceArray:
        """New device array filled with 0."""
        return self.upload(np.zeros(shape, dtype))

    def empty(self, shape: tuple[int, ...], dtype: Any) -> DeviceArray:
        """New device array, not filled; at least one item long.

        Raises
        ------
        DeviceError
            When the device has no room for it.
        """
        import pyopencl as cl
        import pyopencl.array as cl_array

        roomy = shape if all(n > 0 for n in shape) else (1,)
        try:
            return cl_array.empty(self._queue, roomy, np.dtype(dtype))
        except cl.Error as error:
            size = int(np.prod(roomy, dtype=np.int64)) * np.dtype(dtype).itemsize
            raise self._no_room(size, error) from error

    def _no_room(self, size: int, error: cl.Error) -> DeviceError:
        return DeviceError(f"no room for {size / 2**20:.0f} MiB on {self.info.name}: {error}")

    def fetch(self, array: DeviceArray) -> NDArray[Any]:
        """Host copy of a device array; waits for the work that fills it.

        Raises
        ------
        DeviceError
            When the work failed, for lack of memory for example, which some drivers only tell now.
        """
        import pyopencl as cl

        try:
            host: NDArray[Any] = array.get(self._queue)
        except cl.Error as error:
            raise DeviceError(f"{self.info.name} failed: {error}") from error
        return host

    def copy(self, to: DeviceArray, array: DeviceArray) -> None:
        """Make one device array equal to another of the same size."""
        import pyopencl as cl

        cl.enqueue_copy(self._queue, to.data, array.data)

    def finish(self) -> None:
        """Wait for everything that was enqueued."""
        self._queue.finish()

    def prove(self) -> float:
        """Build a small kernel, run it and compare; returns the seconds that took.

        Raises
        ------
        DeviceError
            When the device does not build it, or gives wrong numbers.
        """
        start = time.perf_counter()
        values = np.arange(1000, dtype=np.float32)
        scaled = self.empty(values.shape, np.float32)
        self.kernel("probe", "scale_values")(len(values), x=self.upload(values), y=scaled, factor=3.0)
        if not np.array_equal(self.fetch(scaled), 3.0 * values):
            raise DeviceError(f"{self.info.name} gives wrong numbers for a product")
        return time.perf_counter() - start

    def profile_table(self) -> dict[str, tuple[int, float]]:
        """Launches and seconds of each kernel so far; empty unless opened with ``profile=True``."""
        self._queue.finish()
        table: defaultdict[str, list[float]] = defaultdict(list)
        for name, event in self._events:
            table[name].append((event.profile.end - event.profile.start) * 1e-9)
        return {name: (len(times), sum(times)) for name, times in sorted(table.items())}

    def _announce(self, build: str) -> None:
        self.builds.append(build)
        if self.on_build is not None:
            self.on_build(build)

    def _record(self, name: str, n_items: int, event: cl.Event) -> None:
        self.watchdog.note(name, n_items, event)
        if self._profile:
            self._events.append((name, event))

    def _program(self, key: BuildKey) -> cl.Program:
        program = self._programs.get(key)
        if program is None:
            names, definitions = key
            program = self._build(load_source(names), definitions, ", ".join(names))
            self._programs[key] = program
        return program

    def _build(self, text: str, definitions: tuple[tuple[str, str], ...], label: str) -> cl.Program:
        import pyopencl as cl

        options = ["-cl-std=CL1.2", "-cl-kernel-arg-info", f"-DHR_SOURCE_DIGEST=0x{source_digest()}UL"]
        options += [f"-D{name}={value}" for name, value in definitions]
        try:
            with warnings.catch_warnings():
                # Drivers report "N warnings generated" for harmless remarks; the tests turn this into an error.
                warnings.simplefilter("ignore", cl.CompilerWarning)
                program: cl.Program = cl.Program(self._context, text).build(options)
        except cl.Error as error:
            raise DeviceError(f"{label} does not build on {self.info.name}:\n{error}") from error
        return program

    def _kernel(self, program: cl.Program, name: str) -> Kernel:
        import pyopencl as cl

        return Kernel(cl.Kernel(program, name), self._queue, self._record, self.build_time, LOCAL_SIZE)


def _sorted_definitions(definitions: dict[str, int | str]) -> tuple[tuple[str, str], ...]:
    return tuple(sorted((name, str(value)) for name, value in definitions.items()))

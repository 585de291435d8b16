"""Runs one expression of device functions over arrays."""

from weakref import WeakKeyDictionary

import numpy as np

from hradiosity.device import Device, load_source

_TYPES = {"float32": "float", "float64": "double", "uint32": "uint", "int32": "int"}
_NUMPY = {name: np.dtype(dtype) for dtype, name in _TYPES.items()}
_built = WeakKeyDictionary()


def device_call(device: Device, header: str, expression: str, result: str = "float", /, *, definitions=None, **arrays):
    """Value of `expression` for each row of `arrays`, whose names stand in it.

    Parameters
    ----------
    header : file in ``cl/include``
    expression : OpenCL C
    result : its type: ``"float"``, ``"uint"``, ``"float3"``, …, up to 8 wide
    definitions : dict of str to int or str, passed as ``-DNAME=value``
    **arrays : (n,) as scalars, (n, w) as vectors w wide, of float32, float64, uint32 or int32; Python's own float64
        rows are passed as double, so convert where the function takes float; the expression may also use the whole
        array, as the pointer ``in_`` + name, and the row number ``i``

    Returns
    -------
    (n,) or (n, w)
    """
    arrays = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    (n,) = {len(array) for array in arrays.values()}
    base = result.rstrip("0123456789")
    width = int(result[len(base) :] or 1)
    text = load_source((f"include/{header}",)) + _kernel_text(expression, base, width, arrays)
    output = device.empty((n, width) if width > 1 else (n,), _NUMPY[base])
    inputs = {f"in_{name}": device.upload(array) for name, array in arrays.items()}
    kernels, key = _built.setdefault(device, {}), (text, *sorted((definitions or {}).items()))
    if key not in kernels:
        kernels[key] = device.kernel_from_text(text, "call_expression", **(definitions or {}))
    kernels[key](n, out=output, **inputs)
    return device.fetch(output)


def _kernel_text(expression: str, base: str, width: int, arrays: dict[str, np.ndarray]) -> str:
    parameters, loads = [], []
    for name, array in arrays.items():
        kind = _TYPES[array.dtype.name]
        lanes = array.shape[1] if array.ndim == 2 else 1
        parameters.append(f"__global const {kind} *in_{name}")
        if lanes == 1:
            loads.append(f"const {kind} {name} = in_{name}[i];")
        else:
            loads.append(f"const {kind}{lanes} {name} = vload{lanes}(i, in_{name});")
    store = f"out[i] = {expression};" if width == 1 else f"vstore{width}({expression}, i, out);"
    body = "\n    ".join(["const uint i = get_global_id(0);", "if (i >= n_items)", "    return;", *loads, store])
    signature = ", ".join([*parameters, f"__global {base} *out", "const uint n_items"])
    return f"\n__kernel void call_expression({signature})\n{{\n    {body}\n}}\n"

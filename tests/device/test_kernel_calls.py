"""Kernels refuse arguments that they don't declare, before the driver sees them; sources that don't build are told."""

import numpy as np
import pytest

from hradiosity.errors import DeviceError


@pytest.fixture
def scale(device):
    return device.kernel("probe", "scale_values")


@pytest.fixture
def x(device):
    return device.upload(np.ones(8, np.float32))


def test_missing_and_unknown_names(scale, x):
    with pytest.raises(TypeError, match=r"missing \['factor'\], unknown \['facter'\]"):
        scale(8, x=x, y=x, facter=2.0)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"factor": "2"}, "factor must be a number"),
        ({"x": np.ones(8, np.float32)}, "x must be a device array, is ndarray"),
    ],
)
def test_wrong_kinds(scale, x, wrong, said):
    with pytest.raises(TypeError, match=said):
        scale(8, **({"x": x, "y": x, "factor": 2.0} | wrong))


def test_wrong_precision(device, scale, x):
    with pytest.raises(TypeError, match=r"y must be float32 .* is float64"):
        scale(8, x=x, y=device.zeros((8,), np.float64), factor=2.0)


def test_unknown_kernel(device):
    with pytest.raises(DeviceError, match=r"probe\.cl has no kernel 'shrink_values'"):
        device.kernel("probe", "shrink_values")


def test_source_that_does_not_build(device):
    with pytest.raises(DeviceError, match="does not build on"):
        device.kernel_from_text("__kernel void broken(const uint n_items) { undeclared = 1; }", "broken")


def test_nothing_to_do_launches_nothing(scale):
    scale(0)

"""Figures of the suite about maps."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hradiosity.suites.maps.measure import MapOutcome, elements_ratio


def outcomes(kind, exponent, factor):
    some = MapOutcome(kind, 0.1, 1, 1, 0.1, 0.1, 0.1, 0.1, 1.0, 1.0)
    return [replace(some, leaves=n, direct=factor * n**-exponent) for n in (100, 1000, 10000)]


def test_ratio_is_that_of_leaves_at_one_error():
    """0.3 / n and 1 / sqrt(n) meet an error of 0.001 at 300 and a million leaves, 0.01 at 30 and 10 000."""
    assert math.isnan(elements_ratio(outcomes("a", 1.0, 3.0), outcomes("u", 0.5, 1.0), 0.001, "direct"))
    ratio = elements_ratio(outcomes("a", 1.0, 3.0), outcomes("u", 0.5, 1.0), 0.02, "direct")
    assert ratio == pytest.approx((1 / 0.02) ** 2 / (3.0 / 0.02))
    assert np.isnan(elements_ratio([], outcomes("u", 0.5, 1.0), 0.02, "direct"))

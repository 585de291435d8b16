"""What every test may ask for."""

import os

import pytest

from hradiosity.device import Device
from hradiosity.device.choice import ENVIRONMENT_VARIABLE


@pytest.fixture(scope="session")
def device():
    """The packaged PoCL; another device only when the environment names it, so that no result is of unknown origin."""
    opened = Device()
    if opened.info.rank != 0 and not os.environ.get(ENVIRONMENT_VARIABLE):
        pytest.fail(f"the tests would run on {opened.description}; name it in {ENVIRONMENT_VARIABLE} if that is wanted")
    return opened

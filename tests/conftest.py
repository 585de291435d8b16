"""What every test may ask for."""

import os
import subprocess

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


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 24 KiB, where the system lets us make one."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=24k", "tmpfs", str(disk)], capture_output=True, check=False
    )
    if mount.returncode:
        pytest.skip("no right to mount a small file system")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)

"""Kernels and data are found from an editable install, a wheel and an sdist, wherever one stands."""

import importlib.util
import json
import shutil
import subprocess
import sys
import tarfile
import zipfile

import pytest
from fresh_environment import BUILD_TOOLS, OWN_SUITE, Environment, copy_checkout

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        shutil.which("git") is None or not (OWN_SUITE / ".git").exists(), reason="copies the files that git knows"
    ),
    pytest.mark.skipif(
        any(importlib.util.find_spec(tool) is None for tool in BUILD_TOOLS), reason=f"needs {', '.join(BUILD_TOOLS)}"
    ),
]

RUN_A_KERNEL = """
import json
import numpy as np
import pyopencl
import hradiosity
from hradiosity.device import Device, kernel_root
from hradiosity.model.photometry import luminous_efficiency

device = Device()
values = device.upload(np.arange(100, dtype=np.float32))
scaled = device.empty((100,), np.float32)
device.kernel("probe", "scale_values")(100, x=values, y=scaled, factor=3.0)
print(json.dumps({
    "package": hradiosity.__file__,
    "kernels": str(kernel_root()),
    "driver": pyopencl.__file__,
    "right": bool((device.fetch(scaled) == 3.0 * np.arange(100)).all()),
    "photometry": float(luminous_efficiency().value.max()),
}))
"""


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    return copy_checkout(tmp_path_factory.mktemp("checkout") / "source")


@pytest.fixture(scope="module")
def built(checkout, tmp_path_factory):
    """The sdist and the wheel, in one folder."""
    folder = tmp_path_factory.mktemp("built")
    subprocess.run([sys.executable, "-m", "hatchling", "build", "-d", str(folder)], cwd=checkout, check=True)
    return folder


def only(folder, pattern):
    (found,) = folder.glob(pattern)
    return found


def prove(environment, tmp_path, monkeypatch):
    """Run a kernel, plan a new room and read its spectra, all from a folder that holds nothing of ours."""
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path / "kernel cache"))
    monkeypatch.setenv("HRADIOSITY_CACHE", str(tmp_path / "speeds"))
    elsewhere = tmp_path / "some other place"
    elsewhere.mkdir()
    found = json.loads(environment.python("-c", RUN_A_KERNEL, cwd=elsewhere))
    assert found["right"]
    assert 0.99 < found["photometry"] <= 1.0
    assert str(environment.folder) in found["driver"]
    environment.call("hradiosity", "new", "room", "my room", cwd=elsewhere)
    assert "elements" in environment.call("hradiosity", "plan", "my room", cwd=elsewhere)
    assert environment.python("-m", "hradiosity", "--version", cwd=elsewhere).startswith("hradiosity ")
    return found


@pytest.mark.parametrize("name", ["plain", "with spaces in it"])
def test_wheel(built, tmp_path, monkeypatch, name):
    environment = Environment(tmp_path / name)
    environment.install(str(only(built, "*.whl")), cwd=tmp_path)
    found = prove(environment, tmp_path, monkeypatch)
    assert found["kernels"].startswith(str(environment.libraries))


def test_sdist(built, tmp_path, monkeypatch):
    environment = Environment(tmp_path / "from source")
    environment.install(str(only(built, "*.tar.gz")), cwd=tmp_path)
    found = prove(environment, tmp_path, monkeypatch)
    assert found["kernels"].startswith(str(environment.libraries))


def test_editable(tmp_path, monkeypatch):
    source = copy_checkout(tmp_path / "work in progress")
    environment = Environment(tmp_path / "editable environment")
    environment.install("-e", str(source), cwd=tmp_path)
    found = prove(environment, tmp_path, monkeypatch)
    assert found["kernels"] == str(source / "cl")
    assert found["package"].startswith(str(source))


def test_everything_is_packed(built, checkout):
    """All that the program reads at run time is in the wheel; whoever has the sdist can run the tests."""
    wheel = set(zipfile.ZipFile(only(built, "*.whl")).namelist())
    package = {path.relative_to(checkout).as_posix() for path in (checkout / "hradiosity").rglob("*") if path.is_file()}
    kernels = {f"hradiosity/{path.relative_to(checkout).as_posix()}" for path in (checkout / "cl").rglob("*.*")}
    assert package <= wheel
    assert kernels <= wheel
    with tarfile.open(only(built, "*.tar.gz")) as archive:
        names = {member.name.split("/", 1)[1] for member in archive.getmembers() if member.isfile()}
    wanted = ("hradiosity", "cl", "tests", "scenes", "examples")
    source = {path.relative_to(checkout).as_posix() for top in wanted for path in (checkout / top).rglob("*.*")}
    assert {name for name in source if (checkout / name).is_file()} <= names
    assert {"README.md", "LICENSE", "pyproject.toml", "ARCHITECTURE.md", "CHANGELOG.md"} <= names

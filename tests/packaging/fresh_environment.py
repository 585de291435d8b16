"""New virtual environments in which everything is installed but the package itself, without a network."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

OWN_SUITE = Path(__file__).parents[2]
BUILD_TOOLS = ("hatchling", "editables", "pip")


def is_own(entry: str) -> bool:
    """Whether an entry of site-packages is what an installation of the package left there."""
    return "hradiosity" in entry or entry == "__pycache__"


class Environment:
    """A virtual environment whose libraries are links to those of the running one.

    A link keeps its own path, so that libraries find themselves in a folder whose name may hold spaces.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
        scheme = {"base": str(folder), "platbase": str(folder)}
        libraries = Path(sysconfig.get_path("purelib", "venv", vars=scheme))
        for entry in Path(sysconfig.get_path("purelib")).iterdir():
            if not is_own(entry.name):
                (libraries / entry.name).symlink_to(entry)
        self.scripts = Path(sysconfig.get_path("scripts", "venv", vars=scheme))
        self.libraries = libraries

    def python(self, *arguments: str, cwd: Path) -> str:
        """What the environment's interpreter prints; fails with its complaints."""
        return self.call("python", *arguments, cwd=cwd)

    def call(self, program: str, *arguments: str, cwd: Path) -> str:
        """What a program of the environment prints; fails with its complaints."""
        variables = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        done = subprocess.run(
            [str(self.scripts / program), *arguments],
            cwd=cwd,
            env=variables,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"{program} {arguments} ended with {done.returncode}\n{done.stdout}\n{done.stderr}"
        return done.stdout

    def install(self, *what: str, cwd: Path) -> None:
        """With pip, nothing but what is named."""
        self.python("-m", "pip", "install", "-q", "--no-deps", "--no-index", "--no-build-isolation", *what, cwd=cwd)


def tracked_files() -> list[str]:
    """Files that belong to the checkout: those known to git and those it would not ignore."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=OWN_SUITE,
        capture_output=True,
        text=True,
        check=True,
    )
    return [name for name in sorted(set(listed.stdout.splitlines())) if (OWN_SUITE / name).is_file()]


def copy_checkout(to: Path) -> Path:
    """A copy of the checkout's files."""
    for name in tracked_files():
        target = to / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes((OWN_SUITE / name).read_bytes())
    return to

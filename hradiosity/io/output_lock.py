"""One run at a time writes to a folder of results.

The lock is the operating system's on ``OUT.lock``, which goes with the process however that ends: what a killed run
leaves is a file that nobody holds, and the next run takes it over.
"""

from __future__ import annotations

import errno
import json
import os
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hradiosity.errors import OutputError
from hradiosity.io.output_folder import reason

_HELD = (errno.EACCES, errno.EAGAIN, errno.EDEADLK)
"""What the system says when another process holds the lock."""
_NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)
"""What file systems without locks say: there two runs can't be kept apart, which is no reason to do none."""

if sys.platform == "win32":
    import msvcrt

    _BEYOND = 2**20
    """Byte that is locked: locked ones can't be read there, and the text of the file should be."""

    def _take(descriptor: int) -> None:
        os.lseek(descriptor, _BEYOND, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        os.lseek(descriptor, 0, os.SEEK_SET)

else:
    import fcntl

    def _take(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def lock_of(out: Path) -> Path:
    """The file that is locked while a run writes to a folder."""
    return out.with_name(f"{out.name}.lock")


@contextmanager
def locked(out: Path) -> Iterator[None]:
    """Keep other runs away from a folder of results.

    Raises
    ------
    OutputError
        When another run is writing there, or the lock can't be made; nothing was changed then.
    """
    path = lock_of(out)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = _open_and_take(path)
    except OSError as error:
        if error.errno in _HELD:
            holder = f"another run ({_holder(path)}) is writing to {out}"
            raise OutputError(f"{holder}; wait until it has ended, or name another folder") from error
        raise OutputError(f"{path} can't be made: {reason(error)}") from error
    try:
        _sign(descriptor)
        yield
    finally:
        _release(path, descriptor)


def _open_and_take(path: Path) -> int:
    """Descriptor of the locked file; again if its holder removed it between opening and locking."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            _take(descriptor)
            if os.path.samestat(os.fstat(descriptor), path.stat()):
                return descriptor
        except FileNotFoundError:
            pass
        except OSError as error:
            if error.errno in _NO_LOCKS:
                return descriptor
            os.close(descriptor)
            raise
        os.close(descriptor)


def _sign(descriptor: int) -> None:
    """Say in the file who holds it; a full disk leaves it empty and the lock as good."""
    holder = {"pid": os.getpid(), "host": socket.gethostname(), "since": time.strftime("%Y-%m-%d %H:%M:%S")}
    with suppress(OSError):
        os.truncate(descriptor, 0)
        os.write(descriptor, json.dumps(holder).encode())


def _release(path: Path, descriptor: int) -> None:
    """Remove the file while it is still held, so that no other run can have taken it; then let go."""
    if sys.platform == "win32":  # where an open file can't be removed
        os.close(descriptor)
    try:
        path.unlink(missing_ok=True)
    except OSError:
        return
    finally:
        if sys.platform != "win32":
            os.close(descriptor)


def _holder(path: Path) -> str:
    """Who holds the lock, as far as the file tells."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        return f"process {found['pid']} on {found['host']} since {found['since']}"
    except (OSError, ValueError, LookupError, TypeError):
        return "just started"

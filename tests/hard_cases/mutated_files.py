"""Files that were damaged at random, and a reader of them that may crash without ending the tests."""

import json
import re
import selectors
import subprocess
import sys
from pathlib import Path

from hypothesis import strategies as st

NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_]\w+")
NASTY_NUMBERS = (
    *(b"nan", b"-inf", b"1e999", b"-1", b"0", b"-0.0", b"1e-320", b"1e300", b"2147483648", b"4294967295", b"1e10"),
    *(b"9" * 30, b"9" * 5000, b"", b"0x10", b"1,5", b"\xef\xbc\x91", b"1_000", b"true", b"null", b'"3"', b"[]", b"{}"),
)
NASTY_BYTES = (b"\0", b"\xff\xfe", b"\r", b"\n\n", b'"', b"\\", b"/", b"[" * 3000, b"(", b"#", b"a" * 5000, b"\xe2\x80")
SECONDS = 10.0
"""After which a reader counts as hanging; the program gives up then, or soon."""


@st.composite
def mutated(draw, content):
    """The bytes after one to four damages of different kinds."""
    for _ in range(draw(st.integers(1, 4))):
        if content:
            content = draw(st.sampled_from(DAMAGES))(draw, content)
    return content


def _place(draw, content):
    return draw(st.integers(0, len(content) - 1))


def _slice(draw, content):
    start = _place(draw, content)
    return start, min(len(content), start + draw(st.sampled_from((1, 2, 4, 7, 12, 30, 100))))


def cut(draw, content):
    return content[: _place(draw, content)]


def overwrite(draw, content):
    at = _place(draw, content)
    return content[:at] + draw(st.binary(min_size=1, max_size=4)) + content[at + 1 :]


def flip(draw, content):
    at = _place(draw, content)
    return content[:at] + bytes([content[at] ^ (1 << draw(st.integers(0, 7)))]) + content[at + 1 :]


def insert(draw, content):
    at = _place(draw, content)
    return content[:at] + draw(st.sampled_from(NASTY_BYTES) | st.binary(max_size=8)) + content[at:]


def delete(draw, content):
    start, end = _slice(draw, content)
    return content[:start] + content[end:]


def repeat(draw, content):
    start, end = _slice(draw, content)
    return content[:end] + content[start:end] * draw(st.sampled_from((1, 2, 50))) + content[end:]


def number(draw, content):
    return _replaced(draw, content, NUMBER, st.sampled_from(NASTY_NUMBERS))


def word(draw, content):
    others = sorted(set(WORD.findall(content))) or [b"x"]
    return _replaced(draw, content, WORD, st.sampled_from(others))


def _replaced(draw, content, pattern, replacement):
    found = list(pattern.finditer(content[:20000]))
    if not found:
        return content
    match = draw(st.sampled_from(found))
    return content[: match.start()] + draw(replacement) + content[match.end() :]


DAMAGES = (cut, overwrite, flip, insert, delete, repeat, number, number, word)


class ReadingProcess:
    """Reads files one after the other; `read` says what came of each.

    ends : how often it died, or hung and was ended, and was started again
    """

    def __init__(self):
        self.ends = 0
        self._child = None

    def read(self, path):
        """Faults of the file; ``None`` if the reader died of it or took too long.

        Raises
        ------
        AssertionError
            For an exception that is no `SceneError`.
        """
        if self._child is None:
            self._start()
        self._child.stdin.write(f"{path}\n".encode())
        self._child.stdin.flush()
        while True:
            line = self._child.stdout.readline() if self._waiting.select(SECONDS) else b""
            if not line:
                self.close()
                self.ends += 1
                return None
            if line.startswith(b'{"'):
                break
        answer = json.loads(line)
        assert "escaped" not in answer, answer.get("escaped")
        return answer["faults"]

    def close(self):
        """End the process."""
        if self._child is not None:
            self._child.kill()
            self._child.communicate()
            self._child = None

    def _start(self):
        program = Path(__file__).with_name("reading_child.py")
        self._child = subprocess.Popen(
            [sys.executable, str(program)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            bufsize=0,
        )
        self._waiting = selectors.DefaultSelector()
        self._waiting.register(self._child.stdout, selectors.EVENT_READ)

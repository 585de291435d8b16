"""The real window, under Xvfb with synthetic mouse and keys."""

import os
import shutil
import subprocess
import sys
import time

import numpy as np
import pytest
from PIL import Image

MISSING = [name for name in ("Xvfb", "xdotool") if shutil.which(name) is None]
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(MISSING), reason=f"needs {' and '.join(MISSING)}"),
]
PATIENCE = 60.0


@pytest.fixture(scope="module")
def display():
    """A screen of our own."""
    reading, writing = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1000x800x24", "-nolisten", "tcp"],
        pass_fds=[writing],
        stderr=subprocess.DEVNULL,
    )
    os.close(writing)
    with os.fdopen(reading) as stream:
        number = stream.readline().strip()
    if not number:
        pytest.skip("Xvfb does not start")
    yield f":{number}"
    server.terminate()
    server.wait(timeout=20)


class Hand:
    """Opens a window and uses mouse and keys in it."""

    def __init__(self, display, folder, *arguments):
        self.folder, self.environment = folder, {**os.environ, "DISPLAY": display}
        self.environment.pop("VTK_DEFAULT_OPENGL_WINDOW", None)
        command = [sys.executable, "-m", "hradiosity", *map(str, arguments)]
        self.process = subprocess.Popen(command, cwd=folder, env=self.environment)
        self.window = self.wait(self._find)
        self.do("windowfocus", "--sync", self.window)

    def _find(self):
        found = subprocess.run(
            ["xdotool", "search", "--name", "hradiosity"],
            env=self.environment,
            capture_output=True,
            text=True,
            check=False,
        )
        return found.stdout.split()[0] if found.stdout.split() else None

    def wait(self, condition):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            found = condition()
            if found:
                return found
            time.sleep(0.1)
        pytest.fail("waited too long")

    def do(self, *words):
        subprocess.run(["xdotool", *map(str, words)], env=self.environment, check=True, capture_output=True)

    def shot(self):
        """What the screenshot key writes."""
        before = set(self.folder.glob("*.png"))
        self.do("key", "p")
        path = self.wait(lambda: set(self.folder.glob("*.png")) - before).pop()

        def whole():
            try:
                return np.asarray(Image.open(path).convert("RGB"))[60:-60]
            except OSError:
                return None

        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            pixels = whole()
            if pixels is not None:
                return pixels
            time.sleep(0.1)
        return pytest.fail("the screenshot stays unfinished")


def test_mouse_and_keys_do_what_they_say(display, solved, tmp_path):
    hand = Hand(display, tmp_path, "view", solved[1], "--size", 640, 480)
    flat = hand.shot()
    hand.do("key", "5")
    coloured = hand.shot()
    assert not np.array_equal(flat, coloured)
    hand.do("key", "1")
    hand.do("mousemove", "--window", hand.window, 500, 240, "click", 1)
    picked = hand.shot()
    panel = (slice(100, 300), slice(20, 380))
    assert picked[panel].mean() < 0.7 * flat[panel].mean(), "a dark panel tells what was picked"
    np.testing.assert_array_equal(picked[:80, 420:], flat[:80, 420:])
    hand.do("key", "Escape")
    np.testing.assert_array_equal(hand.shot(), flat)
    hand.do("mousemove", "--window", hand.window, 400, 240, "mousedown", 1)
    for _ in range(3):
        hand.do("mousemove_relative", "--", 20, 5)
    hand.do("mouseup", 1)
    turned = hand.shot()
    assert not np.array_equal(turned, flat)
    hand.do("click", 4)
    assert not np.array_equal(hand.shot(), turned)
    hand.do("key", "c", "key", "c")
    np.testing.assert_array_equal(hand.shot(), flat)
    hand.do("mousemove", "--window", hand.window, 90, 20, "click", 1)
    assert not np.array_equal(hand.shot(), flat), "the button of the smooth mode"
    hand.do("key", "Escape")
    assert hand.process.wait(timeout=PATIENCE) == 0


def test_closing_the_window_leaves_the_run_alone(display, room_file, tmp_path):
    hand = Hand(
        display,
        tmp_path,
        *("render", room_file, "-o", tmp_path / "out", "--view", "--no-audit", "--quiet", "--quality", "fine"),
        *("--solver", "southwell", "--element-size", "0.06", "--replicates", "2"),
    )
    live = tmp_path / "out.partial" / "live" / "light.h5"
    hand.wait(lambda: live.exists() or hand.process.poll() is not None)
    assert live.exists(), "the run shows its light while it goes on"
    hand.do("key", "Escape")
    hand.wait(lambda: hand._find() is None)
    assert hand.process.wait(timeout=300) == 0
    assert (tmp_path / "out" / "solution.vtkhdf").exists()
    assert not (tmp_path / "out" / "live").exists()

"""The live page of a recording, in a process of its own: the training does not wait for it."""

import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import IO

from harness.text import print_visible

CHILD = """
import os, runpy, sys, threading
def end_with_parent():
    sys.stdin.buffer.read()
    os._exit(0)
threading.Thread(target=end_with_parent, daemon=True).start()
getattr(os, "nice", int)(10)
runpy.run_module("harness", run_name="__main__", alter_sys=True)
"""
"""``python -m harness``, until its standard input ends: whoever held it was killed, or has closed the recording."""


LONGEST = 30.0
"""Seconds that a training waits for the address, so that it is said before the first step."""


def start_watching(folder: Path) -> "subprocess.Popen[bytes]":
    """Start ``harness watch`` of a recording, and wait until its address is said on standard error, or why it has none.

    A browser opens where a person sits at a desktop. End it by closing its standard input.
    """
    has_desktop = sys.platform in {"darwin", "win32"} or bool(os.environ.keys() & {"DISPLAY", "WAYLAND_DISPLAY"})
    browser = "--browser" if sys.stdout.isatty() and has_desktop else "--no-browser"
    call = [sys.executable, "-c", CHILD, "watch", str(folder.absolute()), browser]
    page = subprocess.Popen(call, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    has_told = threading.Event()
    threading.Thread(target=_pass_on, args=(page.stderr, has_told), daemon=True).start()
    has_told.wait(LONGEST)
    return page


def _pass_on(lines: IO[bytes], has_told: threading.Event) -> None:
    """Write what the page's process says to standard error, until it ends."""
    with lines:
        for line in lines:
            print_visible(line.decode(errors="replace").rstrip("\n"), err=True)
            has_told.set()
    has_told.set()

"""The live page of a recording, in a process of its own: the training does not wait for it."""

import os
import subprocess
import sys
from pathlib import Path

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


def start_watching(folder: Path) -> "subprocess.Popen[bytes]":
    """Start ``harness watch`` of a recording. It says its address on standard error, or in a line why it cannot.

    A browser opens where a person sits at a desktop. End it by closing its standard input.
    """
    browser = "--browser" if sys.stdout.isatty() and _has_desktop() else "--no-browser"
    call = [sys.executable, "-c", CHILD, "watch", str(folder.absolute()), browser]
    return subprocess.Popen(call, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)


def _has_desktop() -> bool:
    return sys.platform in {"darwin", "win32"} or bool(os.environ.keys() & {"DISPLAY", "WAYLAND_DISPLAY"})

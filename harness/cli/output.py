"""Lines for the terminal: no name in a file sends it a command, nor does what libraries say by themselves."""

import logging
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

from harness.errors import one_line
from harness.text import one_line_of, print_visible, visible


def say(line: str, err: bool = False) -> None:
    """Print a line that may hold names of strangers, whole, on standard output or on standard error."""
    print_visible(line, err)


def complain(message: str) -> None:
    """Say on standard error, in one line that is not long, what went wrong."""
    print_visible(f"harness: {one_line_of(message)}", err=True)


def say_json(data: Any) -> None:
    """Print plain data as JSON on standard output.

    Raises:
        ValueError: It holds a number that JSON has not, NaN or infinity.
    """
    import json

    print_visible(json.dumps(data, indent=1, allow_nan=False))


@contextmanager
def libraries_visible() -> Iterator[None]:
    """While a command runs: warnings, log lines and errors of threads are shown as all else is, whoever wrote them."""
    before = warnings.showwarning, threading.excepthook
    plain = logging.lastResort.formatter if logging.lastResort is not None else None
    warnings.showwarning, threading.excepthook = _show_warning, _show_error_of_thread
    if logging.lastResort is not None:
        logging.lastResort.setFormatter(_VisibleLines())
    try:
        yield
    finally:
        warnings.showwarning, threading.excepthook = before
        if logging.lastResort is not None:
            logging.lastResort.setFormatter(plain)


class _VisibleLines(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        """Called for each line that no handler takes."""
        return visible(super().format(record), keep="\n")


def _show_warning(
    message: Warning | str, category: type[Warning], filename: str, lineno: int,
    file: TextIO | None = None, line: str | None = None,
) -> None:  # fmt: skip
    text = visible(warnings.formatwarning(message, category, filename, lineno, line), keep="\n")
    (file or sys.stderr).write(text)


def _show_error_of_thread(error: threading.ExceptHookArgs) -> None:
    if error.exc_value is not None and not isinstance(error.exc_value, SystemExit):
        complain(f"a thread ended: {one_line(error.exc_value)}")


@contextmanager
def kept_when_interrupted(kept: str, folder: Path) -> Iterator[None]:
    """If KeyboardInterrupt passes, say on standard error what is kept where, and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        say(f"harness: interrupted: {kept} in '{folder}'. The same command goes on with the rest", err=True)
        raise

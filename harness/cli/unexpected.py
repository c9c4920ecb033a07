"""What becomes of an exception that nobody meant to raise: one line, and a log with the rest."""

import tempfile
import traceback
from pathlib import Path

from harness.errors import one_line
from harness.text import print_visible


def describe_unexpected(error: Exception) -> str:
    """A line that names the exception and the file with its traceback; see `leave_story`."""
    return f"unexpected error: {one_line(error)}. Please report it with {leave_story(error)}"


def describe_fault(owner: str, error: Exception) -> str:
    """The same of an exception that a plugin's code raised.

    Args:
        owner: Whose code it is, ``Command 'wave' of package waving 1.0``.
        error: What it raised.
    """
    return f"{owner} raised {one_line(error)}. Report it to its authors with {leave_story(error)}"


def leave_story(error: Exception) -> str:
    """Write the traceback to a file in the folder for such files, or to standard error if that fails; says where."""
    story = "".join(traceback.format_exception(error))
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="harness-", suffix=".log", delete=False, encoding="utf-8", errors="backslashreplace"
        ) as file:
            file.write(story)
    except OSError:
        print_visible(story.rstrip("\n"), err=True)
        return "the lines above."
    return f"the log, {Path(file.name)}"

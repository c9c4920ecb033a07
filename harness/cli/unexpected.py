"""What becomes of an exception that nobody meant to raise: one line, and a log with the rest."""

import sys
import tempfile
import traceback
from pathlib import Path

from harness.errors import one_line


def describe_unexpected(error: Exception) -> str:
    """A line that names the exception and the file with its traceback, which is written to the folder for such files.

    Where no file can be written the traceback goes to standard error.
    """
    story = "".join(traceback.format_exception(error))
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="harness-", suffix=".log", delete=False, encoding="utf-8", errors="backslashreplace"
        ) as file:
            file.write(story)
    except OSError:
        sys.stderr.write(story)
        return f"nobody foresaw {one_line(error)}. Please report it with the lines above."
    return f"nobody foresaw {one_line(error)}. Please report it with the log, {Path(file.name)}"

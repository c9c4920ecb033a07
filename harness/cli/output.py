"""Lines for the terminal: no name in a file sends it a command."""

import sys
from typing import Any

from harness.text import one_line_of, visible


def say(line: str, err: bool = False) -> None:
    """Print a line that may hold names of strangers, whole, on standard output or on standard error."""
    _print(visible(line, keep="\n"), err)


def complain(message: str) -> None:
    """Say on standard error, in one line that is not long, what went wrong."""
    _print(f"harness: {one_line_of(message)}", err=True)


def say_json(data: Any) -> None:
    """Print plain data as JSON on standard output.

    Raises:
        ValueError: It holds a number that JSON has not, NaN or infinity.
    """
    import json

    _print(json.dumps(data, indent=1, allow_nan=False))


def _print(text: str, err: bool = False) -> None:
    """In the encoding of the stream: typer would write UTF-8 where that is ASCII."""
    print(text, file=sys.stderr if err else sys.stdout, flush=True)  # all others come here

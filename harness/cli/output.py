"""Lines for the terminal: no name in a file sends it a command."""

from typing import Any

import typer

from harness.text import one_line_of, visible


def say(line: str, err: bool = False) -> None:
    """Print a line that may hold names of strangers, whole, on standard output or on standard error."""
    typer.echo(visible(line, keep="\n"), err=err)


def complain(message: str) -> None:
    """Say on standard error, in one line that is not long, what went wrong."""
    typer.echo(f"harness: {one_line_of(message)}", err=True)


def say_json(data: Any) -> None:
    """Print plain data as JSON on standard output.

    Raises:
        ValueError: It holds a number that JSON has not, NaN or infinity.
    """
    import json

    typer.echo(json.dumps(data, indent=1, allow_nan=False))

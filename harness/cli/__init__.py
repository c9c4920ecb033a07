"""The command line. One module per command; each imports what is heavy when it runs."""

import sys
from io import TextIOWrapper

INTERRUPTED = 130
"""The exit status of an interrupted command, as a shell says it: 128 and the number of SIGINT."""
RAISING = ("strict", "surrogateescape", "surrogatepass")
"""What a stream does with a character that its encoding has not, if the program is to end there."""


def main(args: list[str] | None = None) -> None:
    """Entry point of ``harness``: `harness.cli.app.main`, quiet too where Ctrl-C comes before a command runs."""
    _show_every_character()
    try:
        from harness.cli.app import main as run

        run(args)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)


def _show_every_character() -> None:
    """Standard output keeps its encoding, and writes out what it has no character for, as standard error does."""
    if isinstance(sys.stdout, TextIOWrapper) and sys.stdout.errors in RAISING:
        sys.stdout.reconfigure(errors="backslashreplace")

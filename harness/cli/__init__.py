"""The command line. One module per command; each imports what is heavy when it runs."""

import sys

INTERRUPTED = 130
"""The exit status of an interrupted command, as a shell says it: 128 and the number of SIGINT."""


def main(args: list[str] | None = None) -> None:
    """Entry point of ``harness``: `harness.cli.app.main`, quiet too where Ctrl-C comes before a command runs."""
    try:
        from harness.cli.app import main as run

        run(args)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)

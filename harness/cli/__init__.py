"""The command line. One module per command; each imports what is heavy when it runs."""

from harness.cli.app import main

__all__ = ["main"]

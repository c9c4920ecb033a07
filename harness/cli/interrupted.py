"""What a command says when it is interrupted half-way."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from harness.cli.output import say


@contextmanager
def kept_when_interrupted(kept: str, folder: Path) -> Iterator[None]:
    """If KeyboardInterrupt passes, say on standard error what is kept where, and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        say(f"harness: interrupted: {kept} in '{folder}'. The same command goes on with the rest", err=True)
        raise

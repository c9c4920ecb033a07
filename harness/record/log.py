"""What the harness itself writes into the log of a cell, between the lines of its plugins."""

from pathlib import Path

from harness.record.manifest import now


def write_log(path: Path, text: str) -> None:
    """Append a line with the time, UTC."""
    with path.open("a", encoding="utf-8") as log:
        log.write(f"{now()} harness: {text}\n")

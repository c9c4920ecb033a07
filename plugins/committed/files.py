"""The files of a summary, put in place of the old ones."""

import os
import re
import shutil
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from harness.errors import UsageError

from .svg import CREATOR

PARTIAL = ".summary.partial"
FIGURE = re.compile(r"overview|.+\.(runs|split|learning)")
"""Names of our figures, without the ending."""


def put_files(folder: Path, files: Mapping[str, bytes], figures: str) -> None:
    """Write `files`, by their paths within `folder`, and remove our older figures that are not among them.

    All are written beside their final names before the first is renamed. So a killed process leaves whole files.

    Args:
        folder: Made if it is not there; what else is in it stays.
        files: What to write.
        figures: The folder of the figures, within `folder`.

    Raises:
        UsageError: `folder` cannot be written, or a link in it leads out of it.
    """
    for inner in (PARTIAL, figures):
        if (folder / inner).is_symlink():
            raise UsageError(f"'{folder / inner}' is a link; nothing is written through it: remove it")
    partial = folder / PARTIAL
    try:
        _write(partial, files)
        for name in files:
            (folder / name).parent.mkdir(exist_ok=True)
            os.replace(partial / name, folder / name)
        for path in (folder / figures).glob("*.svg"):
            if f"{figures}/{path.name}" not in files and _is_ours(path):
                path.unlink()
    except OSError as error:
        raise UsageError(f"The summary '{folder}' cannot be written: {error.strerror}") from error
    finally:
        with suppress(OSError):  # not there if it could not be made
            shutil.rmtree(partial)


def _is_ours(path: Path) -> bool:
    """Whether a figure is ours, by its name and by its creator."""
    return bool(FIGURE.fullmatch(path.stem)) and CREATOR.encode() in path.read_bytes()


def _write(partial: Path, files: Mapping[str, bytes]) -> None:
    if partial.exists():  # left by a process that was killed
        shutil.rmtree(partial)
    partial.mkdir(parents=True)
    for name, content in files.items():
        (partial / name).parent.mkdir(exist_ok=True)
        (partial / name).write_bytes(content)

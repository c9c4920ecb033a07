"""The folder that work grows in, before any of it is done: no file of it is one of another folder too."""

import shutil
from pathlib import Path

from harness.files.whole_file import whole_file
from harness.record.folder import partial_folder


def own_partial(folder: Path) -> Path:
    """The partial folder of a folder, made if need be, in which what is written changes no file elsewhere.

    An earlier attempt may have left files in it, and logs are appended to. Where one has a second name, as in a copy
    that was made of hard links, a copy of its own takes its place.
    """
    partial = partial_folder(folder)
    partial.mkdir(parents=True, exist_ok=True)
    for path in partial.rglob("*"):
        if path.is_file() and path.stat().st_nlink > 1:
            with whole_file(path) as copy:
                shutil.copyfile(path, copy)
    return partial

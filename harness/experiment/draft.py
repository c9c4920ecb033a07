"""Makes a folder that appears all at once, with a record of how the work for it ended."""

import shutil
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Generic, Self, TypeVar

from harness.errors import one_line
from harness.files.bounded import whole_file
from harness.record.folder import LOG, partial_folder, publish
from harness.record.manifest import Ending, now

Kind = TypeVar("Kind", bound=Ending)


class Draft(Generic[Kind]):
    """The record of work that is not yet done.

    Attributes:
        partial: Where the folder grows until it is complete.
        record: What will be written about it.
    """

    def __init__(self, partial: Path, record: Kind) -> None:
        self.partial, self.record = partial, record

    def note(self, **fields: Any) -> Self:
        """Put fields into the record; they stay there if the work fails later."""
        self.record = replace(self.record, **fields)
        return self


@contextmanager
def draft_of(folder: Path, record: Kind) -> Iterator[Draft[Kind]]:
    """Work on a folder: it is written beside its final name and renamed when the block ends.

    What the block raises ends up in the record, as the reason of a failure, and in the log: a plugin may raise
    anything, and it costs this folder alone.

    Args:
        folder: To leave; replaced if it exists.
        record: What there is to say of it if the work is done; start and duration are filled in.
    """
    clock = time.perf_counter()
    partial = own_partial(folder)
    draft = Draft(partial, replace(record, started=now()))
    try:
        yield draft
    except (Exception, SystemExit) as error:
        with (partial / LOG).open("a") as log:
            traceback.print_exc(file=log)
        draft.note(status="failed", reason=one_line(error).replace(str(partial), str(folder)))
    draft.note(seconds=round(time.perf_counter() - clock, 3))
    draft.record = leave_record(folder, draft.record)


def leave_record(folder: Path, record: Kind) -> Kind:
    """Write a record into the partial folder of `folder`, with whatever is in it already, and complete it.

    Returns:
        What was written: the record with the digests of the files.
    """
    partial = partial_folder(folder)
    partial.mkdir(parents=True, exist_ok=True)
    written = record.write(partial)
    publish(partial, folder)
    return written


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

"""The interface that a reader of logs fills."""

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from harness.log.log import Log

HEAD = 4096
"""The bytes of a file's beginning that `LogFormat.recognises` is given."""


class LogFormat(Protocol):
    """A frozen dataclass that reads the logs of one program. Its fields are its settings: ``--as rosbag:topic=/pay``.

    A reader opens files that anybody may have written. It runs nothing that stands in them, reads within bounds
    (`harness.files`), and refuses what it does not understand: a number that is silently wrong is worse than none.
    """

    def recognises(self, path: Path, head: bytes) -> bool:
        """Whether a file or a folder is of this format. Reads little, and raises nothing.

        Args:
            path: The file, or the folder.
            head: The first `HEAD` bytes of the file; empty of a folder.
        """

    def read(self, path: Path) -> Sequence[Log]:
        """The logs of all trainings in it; mostly one. Rows are read later, when somebody asks for them.

        Args:
            path: A file or a folder that this format recognises, or that a user says is of it.

        Raises:
            UsageError: A setting does not fit the file.
            NewerFormat: A newer version of the program wrote it.
            SchemaError: It is damaged, or not what it says of itself.
        """

    def write_example(self, folder: Path) -> Path:
        """Write a small log of this format into an empty folder, for the contract kit; its path.

        At least two episodes or three points, written by the program's own library where it is installed.
        """

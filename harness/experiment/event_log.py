"""Scalars of one cell, in event files that TensorBoard reads."""

import importlib.util
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from harness.errors import UsageError

if TYPE_CHECKING:
    from tensorboard.summary import Writer


def require_tensorboard() -> None:
    """Look whether event files can be written, before anything runs.

    Raises:
        UsageError: The extra is not installed.
    """
    if importlib.util.find_spec("tensorboard") is None:
        raise UsageError("--tensorboard needs tensorboard: pip install 'fd100-harness[tensorboard]'")


class EventLog:
    """Writes scalars; without a folder it writes nothing."""

    def __init__(self, folder: Path | None) -> None:
        self._writer: Writer | None = None
        if folder is not None:
            from tensorboard import summary  # it takes a second, and few ask for it

            self._writer = summary.Writer(str(folder))

    @property
    def is_open(self) -> bool:
        """Whether what is written goes anywhere."""
        return self._writer is not None

    def write(self, steps: int, values: Mapping[str, float]) -> None:
        """Numbers by their TensorBoard names, as they are after `steps` environment steps."""
        if self._writer is None:
            return
        for name, value in values.items():
            self._writer.add_scalar(name, value, int(steps))
        self._writer.flush()  # who looks on sees it now, and a killed process has lost nothing

    def __enter__(self) -> "EventLog":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        if self._writer is not None:
            self._writer.close()

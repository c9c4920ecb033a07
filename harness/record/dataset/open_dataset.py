"""Data sets by what users type: ``minari:D4RL/pen/human-v2``, ``lerobot:FOLDER``."""

from harness.errors import UsageError
from harness.record.dataset.dataset import Dataset
from harness.record.dataset.labels import parse_success
from harness.record.dataset.lerobot import open_lerobot
from harness.record.dataset.minari import open_minari

FORMATS = {"minari": open_minari, "lerobot": open_lerobot}


def is_dataset(text: str) -> bool:
    """Whether a text names a data set."""
    return text.partition(":")[0] in FORMATS and ":" in text


def open_dataset(text: str, success: str | None = "", cluster: str = "", partial: bool = False) -> Dataset:
    """A data set; its steps are read later.

    Args:
        text: ``minari:NAME`` or ``lerobot:FOLDER``.
        success: What says whether a step, or an episode, was a success: a key, a column or an attribute, also with a
            threshold, ``KEY>0.5``; found by its name if empty. None where labels come from elsewhere.
        cluster: What says who made an episode: an attribute of it, or a column; found by its name if empty.
        partial: Whether less than the metadata declares is enough.

    Raises:
        UsageError: There is no such data set, or a library is missing.
        SchemaError: It is damaged, of another version, or not what its metadata declares.
    """
    kind, _, name = text.partition(":")
    if not is_dataset(text) or not name:
        raise UsageError(f"'{text}' names no data set: write minari:NAME or lerobot:FOLDER")
    return FORMATS[kind](name, None if success is None else parse_success(success), cluster, partial)

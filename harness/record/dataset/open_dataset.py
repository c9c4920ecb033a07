"""Data sets by what users type: ``minari:D4RL/pen/human-v2``, ``lerobot:FOLDER``."""

from harness.errors import UsageError
from harness.record.dataset.dataset import Dataset
from harness.record.dataset.lerobot import open_lerobot
from harness.record.dataset.minari import open_minari

FORMATS = {"minari": open_minari, "lerobot": open_lerobot}


def is_dataset(text: str) -> bool:
    """Whether a text names a data set."""
    return text.partition(":")[0] in FORMATS and ":" in text


def open_dataset(text: str, success: str = "", cluster: str = "") -> Dataset:
    """A data set; its steps are read later.

    Args:
        text: ``minari:NAME`` or ``lerobot:FOLDER``.
        success: What says whether a step was a success: a key of infos, or a column; found by its name if empty.
        cluster: What says who made an episode: an attribute of it, or a column; found by its name if empty.

    Raises:
        UsageError: There is no such data set, or a library is missing.
        SchemaError: It is damaged, or of another version.
    """
    kind, _, name = text.partition(":")
    if not is_dataset(text) or not name:
        raise UsageError(f"'{text}' names no data set: write minari:NAME or lerobot:FOLDER")
    return FORMATS[kind](name, success, cluster)

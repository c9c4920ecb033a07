"""Data sets by what users type: ``minari:D4RL/pen/human-v2``, ``lerobot:FOLDER``, ``d4rl:FILE``, ``robomimic:FILE``."""

import mmap
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from struct import unpack_from
from typing import Any

from harness.errors import SchemaError, UsageError
from harness.files.bounded import reading
from harness.log.facts import LogFacts
from harness.log.log import Log
from harness.log.open_log import LOGS, open_logs
from harness.registry.choice import Registry

SYNTAX = "write minari:NAME, lerobot:FOLDER, d4rl:FILE or robomimic:FILE"
_TYPED = re.compile(r"(?P<format>[A-Za-z][\w/-]+):(?P<settings>\w+=[^:]*(?=:))?:?(?P<place>.*)")
"""The name of a format; settings of it, if there are any, as in ``robomimic:mask=train:FILE``; and the place."""


_FOLDERS = ("meta/info.json", "data/main_data.hdf5")
"""What a folder holds that is a data set of LeRobot, or of Minari."""

MOST_EPISODES = 2_000_000
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
"""How an HDF5 file begins."""
_HEAP, HEAP_HEAD = re.compile(rb"GCOL\x01\x00{3}"), 16
"""How a collection of texts begins in HDF5, and its bytes before the first text; each text has as many before it."""
MOST_SEARCHED = 2**30
"""So far into a file damaged texts are looked for, in half a second."""
INDEX_BYTES = 2**20
"""What HDF5 keeps of a file's index: each episode is read once, and 32 MiB, its default, hold 200 MB of memory."""


@dataclass(frozen=True, kw_only=True)
class DatasetFacts(LogFacts):
    """What is known of a data set beside its steps.

    Attributes:
        name: What a user types for it, ``minari:D4RL/pen/human-v2``.
        names: By column, ``observation`` and ``action``, what its numbers are called, as far as the metadata says.
        success: What says whether a step, or an episode, was a success; empty if nothing does.
        told_by: The recorded reward that says it, if one does.
        operator: What says who made an episode; empty if nothing does.
        task: What says which task an episode does; empty if nothing does.
        pictures_left_out: Whether something that was seen is left out, such as pictures.
    """

    name: str
    names: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    success: str = ""
    told_by: str = ""
    operator: str = ""
    task: str = ""
    pictures_left_out: bool = False


def is_dataset(text: str, formats: Callable[[], Collection[str]]) -> bool:
    """Whether a text names a data set: by a format, as an HDF5 file, or as a folder that is one.

    Args:
        text: What a user typed.
        formats: Gives the names of all formats; called where there is a colon in the text.
    """
    found = _TYPED.fullmatch(text)
    if found is not None and found["format"] in formats():
        return True
    return _is_hdf5(Path(text)) or any((Path(text) / name).is_file() for name in _FOLDERS)


def open_dataset(text: str, registry: Registry, **settings: str | bool) -> Log:
    """A data set; its steps are read later.

    Args:
        text: ``minari:NAME``, ``lerobot:FOLDER``; with settings of the format ``robomimic:mask=train:FILE``; or a file.
        registry: Has the formats.
        settings: Further settings of the format, such as ``success``, ``cluster`` and ``partial``. Empty ones are not
            given.

    Raises:
        UsageError: There is no such data set, a library is missing, or the format has no such setting.
        SchemaError: It is damaged, of another version, or not what its metadata declares.
    """
    found = _TYPED.fullmatch(text)
    given: dict[str, Any] = {name: value for name, value in settings.items() if value}
    if found is None or found["format"] not in registry.names(LOGS):
        if _is_hdf5(Path(text)):  # of one that is cut every format says that it is none of its own
            with reading(Path(text), "HDF5 file"), open_hdf5(Path(text)):
                pass
        logs = open_logs(Path(text), registry, **given)
    elif not found["place"]:
        raise UsageError(f"'{text}' names no data set: {SYNTAX}")
    else:
        named = f"{found['format']}:{found['settings']}" if found["settings"] else found["format"]
        logs = open_logs(Path(found["place"]), registry, named, **given)
    if len(logs) != 1 or logs[0].facts.unit != "step":
        told = f"{len(logs)} logs of {logs[0].facts.unit}s"
        raise UsageError(f"'{text}' holds {told}, and is no data set of steps: {SYNTAX}")
    return logs[0]


def _is_hdf5(path: Path) -> bool:
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(HDF5_SIGNATURE)) == HDF5_SIGNATURE


def dataset_facts(log: Log) -> DatasetFacts:
    """What is known of a data set; of another log of steps, what that tells."""
    facts = log.facts
    if isinstance(facts, DatasetFacts):
        return facts
    return DatasetFacts(**{**vars(facts), "name": str(facts.path)})


def open_hdf5(path: Path) -> Any:
    """The file, open for reading.

    Raises:
        UsageError: h5py is not installed.
        SchemaError: Its texts are damaged.
    """
    try:
        import h5py
    except ImportError as error:
        raise UsageError(
            f"A data set in HDF5 needs h5py, which cannot be imported ({error}): pip install 'fd100-harness[minari]'"
        ) from error
    _require_texts(path)
    file = h5py.File(path, "r", locking=False)
    cache = file.id.get_mdc_config()
    cache.set_initial_size, cache.initial_size, cache.min_size, cache.max_size = True, *[INDEX_BYTES] * 3
    file.id.set_mdc_config(cache)
    return file


def _require_texts(path: Path) -> None:
    """See that each text of a collection has a length: HDF5 itself would look for the next one without an end.

    Source: https://support.hdfgroup.org/documentation/hdf5/latest/_f_m_t3.html, "Global Heap".
    """
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as found:
        for heap in _HEAP.finditer(found, 0, MOST_SEARCHED):
            at, end = heap.start() + HEAP_HEAD, heap.start() + unpack_from("<Q", found, heap.end())[0]
            while at + HEAP_HEAD <= min(end, len(found)):
                number, size = unpack_from("<H6xQ", found, at)
                step = size if number == 0 else HEAP_HEAD + -(-size // 8) * 8  # 0 is the room that is left
                if not 0 < step <= end - at:
                    raise SchemaError(f"{path} is damaged: its texts at byte {at:,} have no length")
                at += step

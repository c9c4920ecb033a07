"""Results of a cell's files, or of a recording's, which are computed once and kept beside them.

::

    derived/<cell id>/values                 numbers: metrics, returns, how many rows there are
    derived/<cell id>/<what>-<key>.array     what a reward pays every row of the training trace
    derived/<cell id>/training/              the same of a recording of the cell, and its episodes
    derived/<path of the recording>/         the same of a recording of no cell

Whatever is kept has a key, a hash of all that it follows from: the SHA-256 of the files, the sources and parameters of
the plugins, the code that puts them together. Nothing is believed under another key, nor what is not whole. The folder
may be removed at any time: reports say the same without it, only later.
"""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
import pyarrow as pa

from harness.files.bounded import digest_of, read_keyed, write_keyed
from harness.record.folder import DERIVED
from harness.registry.sources import digest_of_modules

VALUES = "values"
FORMAT = 1
LARGEST = 2**31
"""The most bytes of an array that are kept, which is 268 million rows."""
MOST_VALUES = 64 * 2**20
"""The most bytes that are read of the numbers of one cell."""
CODE = (
    "harness.eta.rescaling",
    "harness.log",
    "harness.log.measure",
    "harness.record",
    "harness.results.by_term",
    "harness.results.cell_results",
    "harness.results.recordings",
    "harness.reward",
    "harness.score",
)
"""Modules and packages that change the kept results, besides the plugins."""

Told = TypeVar("Told")


class Kept:
    """The kept results of one cell, or of one recording."""

    def __init__(self, folder: Path, name: str, files: Path, digests: Mapping[str, str] = MappingProxyType({})) -> None:
        """Read the numbers; arrays are read when they are asked for.

        Args:
            folder: The experiment's folder, or another one in which recordings lie.
            name: The cell's id, or the path of the recording in that folder.
            files: The folder of the files whose results they are.
            digests: SHA-256 of its files by name, as its manifest names them.
        """
        self._derived = folder / DERIVED
        self._folder, self._files, self._owner = self._derived / name, files, f"{FORMAT} {name}"
        self._digests = dict(digests)
        self._changed = False
        content = read_keyed(self._folder / VALUES, self._owner, MOST_VALUES)  # whole, as `save` wrote it, or None
        self._values: dict[str, list[Any]] = {} if content is None else json.loads(content)

    def digest(self, name: str) -> str:
        """SHA-256 of a file of the cell; empty if there is no such file. Reading that file then raises an error."""
        if name not in self._digests:
            path = self._files / name
            self._digests[name] = digest_of(path) if path.is_file() else ""
        return self._digests[name]

    def told(self, what: str, made_of: Sequence[str], make: Callable[[], Told]) -> Told:
        """What `make` computes: a number, plain data as JSON has it, or an array, (numbers,).

        It is taken from what is kept, if that follows from the same.

        Args:
            what: Its name among those of the cell.
            made_of: Digests of everything that it follows from.
            make: Computes it. An error that it raises is passed on.
        """
        key = hashlib.sha256("\0".join([_code(), what, *made_of]).encode()).hexdigest()[:32]
        found: Any = self._values.get(what)
        if found is not None and found[0] == key:
            told: Told = found[1]
            return told
        name, owner = hashlib.sha256(what.encode()).hexdigest()[:8], f"{self._owner} {key}"
        path = self._folder / f"{name}-{key}.array"
        content = read_keyed(path, owner, LARGEST)
        if content is not None:
            rows = int.from_bytes(content[:8], "little")
            found = np.frombuffer(pa.decompress(content[8:], decompressed_size=8 * rows, codec="zstd"), np.float64)
            told = found
            return told
        made = make()
        if not isinstance(made, np.ndarray):
            self._values[what] = [key, made]
            self._changed = True
            return made
        packed: bytes = pa.compress(np.ascontiguousarray(made), codec="zstd", asbytes=True)
        write_kept(self._derived, path, owner, len(made).to_bytes(8, "little") + packed)
        for old in self._folder.glob(f"{name}-*"):  # of files or plugins that have changed
            if old != path:
                with suppress(OSError):
                    old.unlink()
        return made

    def save(self) -> None:
        """Write the numbers if one is new. A folder that allows no writing stays as it is."""
        if not self._changed:
            return
        self._changed = False
        text = json.dumps(self._values, separators=(",", ":"))
        write_kept(self._derived, self._folder / VALUES, self._owner, text.encode())


def write_kept(derived: Path, path: Path, key: str, content: bytes) -> None:
    """Write a file of kept results. If that fails, nothing is kept, since no report needs it.

    Args:
        derived: The folder of all that is kept.
        path: The file in it.
        key: See `write_keyed`.
        content: See there.
    """
    if any(it.is_symlink() for it in path.parents if it.is_relative_to(derived)):
        return  # a stranger's folder may point anywhere
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_keyed(path, key, content)


@lru_cache(maxsize=1)
def _code() -> str:
    """A digest of the code that turns files into results, and of numpy's version, which may add in another order."""
    return f"{FORMAT} {np.__version__} {digest_of_modules(CODE)}"

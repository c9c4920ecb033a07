"""What follows from a cell's files, computed once and kept beside them.

::

    derived/<cell id>/values                 numbers: metrics, returns, how many rows there are
    derived/<cell id>/<what>-<key>.rewards   what a reward pays every row of the training trace

Whatever is kept has a key, a hash of all that it follows from: the SHA-256 of the files, the sources and parameters of
the plugins, the code that puts them together. Nothing is believed under another key, nor what is not whole. The folder
may be removed at any time: reports say the same without it, only later.
"""

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pyarrow as pa

from harness.arrays import Float
from harness.files.bounded import digest_of
from harness.files.keyed_file import read_keyed, write_keyed
from harness.record.folder import DERIVED
from harness.registry.sources import digest_of_modules

VALUES = "values"
FORMAT = 1
LARGEST = 2**31
"""Bytes of rewards that are kept, 268 million rows."""
MOST_VALUES = 64 * 2**20
"""Bytes of the numbers of one cell that are read."""
CODE = ("harness.metric", "harness.reward", "harness.record", "harness.score", "harness.results.cell_results")
"""Modules and packages that what is kept follows from, beside the plugins."""

Number: TypeAlias = float | int | bool | None


class Kept:
    """What is kept of one cell."""

    def __init__(self, experiment: Path, files: Path, digests: Mapping[str, str]) -> None:
        """Read the numbers; rewards are read when they are asked for.

        Args:
            experiment: Its folder.
            files: The folder of the cell whose results they are.
            digests: SHA-256 of its files by name, as its manifest names them; in cells of version 0.1 none.
        """
        self._folder, self._files, self._owner = experiment / DERIVED / files.name, files, f"{FORMAT} {files.name}"
        self._digests = dict(digests)
        self._values: dict[str, list[Any]] = {}
        self._changed = False
        self._read_values()

    def digest(self, name: str) -> str:
        """SHA-256 of a file of the cell; empty where there is no such file: whoever reads it will say so."""
        if name not in self._digests:
            path = self._files / name
            self._digests[name] = digest_of(path) if path.is_file() else ""
        return self._digests[name]

    def number(self, what: str, made_of: Sequence[str], make: Callable[[], Number]) -> Number:
        """What `make` gives, from what is kept if that follows from the same.

        Args:
            what: Names it among the cell's numbers.
            made_of: Digests of all that it follows from.
            make: Computes it; what it raises passes.
        """
        key = _key(what, made_of)
        found = self._values.get(what)
        if found is not None and found[0] == key:
            number: Number = found[1]
            return number
        made = _plain(make())
        self._values[what] = [key, made]
        self._changed = True
        return made

    def rewards(self, what: str, made_of: Sequence[str], make: Callable[[], Float]) -> Float:
        """The same of an array, (rows,); see `number`."""
        key = _key(what, made_of)
        name = hashlib.sha256(what.encode()).hexdigest()[:8]
        path = self._folder / f"{name}-{key}.rewards"
        content = read_keyed(path, f"{self._owner} {key}", LARGEST)
        if content is not None:
            return _unpack(content)
        made = make()
        self._write(path, f"{self._owner} {key}", _pack(made))
        self._discard(old for old in self._folder.glob(f"{name}-*.rewards") if old != path)
        return made

    def save(self) -> None:
        """Write the numbers, if one is new; a folder that allows no writing stays as it is."""
        if not self._changed:
            return
        self._changed = False
        text = json.dumps(self._values, separators=(",", ":"))
        self._write(self._folder / VALUES, self._owner, text.encode())

    def _write(self, path: Path, key: str, content: bytes) -> None:
        """No report needs what is kept: where nothing can be written, nothing is kept."""
        if self._folder.is_symlink() or self._folder.parent.is_symlink():
            return  # a stranger's folder may point anywhere
        with suppress(OSError):
            self._folder.mkdir(parents=True, exist_ok=True)
            write_keyed(path, key, content)

    def _discard(self, paths: Iterable[Path]) -> None:
        """Of files or plugins that are others now."""
        for path in paths:
            with suppress(OSError):
                path.unlink()

    def _read_values(self) -> None:
        content = read_keyed(self._folder / VALUES, self._owner, MOST_VALUES)
        if content is not None:  # it is as `save` wrote it
            self._values = json.loads(content)


def _plain(number: Any) -> Number:
    """As JSON gives it back."""
    return number if number is None or isinstance(number, int | float) else float(number)


def _key(what: str, made_of: Sequence[str]) -> str:
    return hashlib.sha256("\0".join([_code(), what, *made_of]).encode()).hexdigest()[:32]


@lru_cache(maxsize=1)
def _code() -> str:
    """What turns files into results here, and numpy, whose sums may come in another order."""
    return f"{FORMAT} {np.__version__} {digest_of_modules(CODE)}"


def _pack(rewards: Float) -> bytes:
    content: bytes = pa.compress(np.ascontiguousarray(rewards), codec="zstd", asbytes=True)
    return len(rewards).to_bytes(8, "little") + content


def _unpack(content: bytes) -> Float:
    rows = int.from_bytes(content[:8], "little")
    return np.frombuffer(pa.decompress(content[8:], decompressed_size=8 * rows, codec="zstd"), np.float64)

"""Reads black boxes, an invented binary format: a head, and a record with a checksum for each step of one env.

harness check black_box --plugin black_box.py
"""

import struct
import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.errors import SchemaError
from harness.files import read_bytes, reading
from harness.log import Log, LogFacts, in_memory

MAGIC = b"BLACKBOX"
HEAD = struct.Struct("<8sHI")  # what it is, version, seed
STEP = struct.Struct("<IIBdd")  # episode, step, whether it fell, pay, height
RECORD = np.dtype("<u4, <u4, u1, <f8, <f8, <u4")  # the same, and its CRC-32


@dataclass(frozen=True)
class BlackBox:
    """Steps of a robot that is paid for each of them, and how high it stood; an episode ends with a fall."""

    def recognises(self, path: Path, head: bytes) -> bool:
        """By its first bytes."""
        return head.startswith(MAGIC)

    def read(self, path: Path) -> tuple[Log, ...]:
        """The one training of a black box; a record that its checksum does not fit is refused."""
        with reading(path, "black box"):
            content = read_bytes(path, 2**30)
            magic, version, seed = HEAD.unpack_from(content)
            if (magic, version) != (MAGIC, 1):
                raise SchemaError(f"{path} is no black box of version 1")
            count, rest = divmod(len(content) - HEAD.size, RECORD.itemsize)
            rows = np.frombuffer(content, RECORD, count, HEAD.size)
            if any(zlib.crc32(row.tobytes()[: STEP.size]) != row["f5"] for row in rows):
                raise SchemaError(f"{path}: a record was changed")
            columns = {"env": np.zeros(count, int), "episode": rows["f0"], "step": rows["f1"]}
            columns |= {"terminated": rows["f2"] > 0, "truncated": np.zeros(count, bool)}
            columns |= {"reward/recorded": rows["f3"], "behaviour/height": rows["f4"]}
            notes = ("the last step is not whole, and left out",) if rest else ()
            return (in_memory(LogFacts(path=path, format="black box", seed=seed, notes=notes), columns),)

    def write_example(self, folder: Path) -> Path:
        """Two episodes, of which the second goes on."""
        steps = [(n // 3, n % 3 + 1, n == 2, -0.5 * n, 1 / (n + 1)) for n in range(5)]
        return write_black_box(folder / "robot.bbox", 7, steps)


def write_black_box(path: Path, seed: int, steps: Iterable[tuple[int, int, bool, float, float]]) -> Path:
    """Write what a robot would."""
    packed = [STEP.pack(*step) for step in steps]
    path.write_bytes(HEAD.pack(MAGIC, 1, seed) + b"".join(it + struct.pack("<I", zlib.crc32(it)) for it in packed))
    return path

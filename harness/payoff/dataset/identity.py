"""What an episode is known by: its content. Two that are equal are one, however often it was stored."""

import hashlib

import numpy as np
from numpy.typing import NDArray

from harness.log import Rows
from harness.log.log import ACTION, BEFORE, OBSERVATION, REWARD, Array


class Fingerprint:
    """A digest of what was seen, done and paid in an episode, as float32; pieces of any size give the same."""

    def __init__(self) -> None:
        self.has_fractions = False
        """Whether an observation or an action is no whole number: by chance they are not equal in two episodes."""
        self._parts: dict[str, hashlib.blake2b] = {}

    def take(self, rows: Rows) -> None:
        """The next steps. What was seen before the first one belongs to them."""
        for name, values in rows.columns.items():
            is_vector = name.startswith((OBSERVATION, ACTION))
            if is_vector or name.startswith(REWARD):
                self._add(name, values)
            elif name.startswith(BEFORE) and rows["step"][0] <= 1:
                self._add(name, values[:1])
            self.has_fractions = self.has_fractions or (is_vector and values.dtype.kind == "f" and values.size > 0)

    def digest(self) -> bytes:
        """All steps so far, as some bytes."""
        return b"".join(name.encode() + b"\0" + self._parts[name].digest() for name in sorted(self._parts))

    def _add(self, name: str, values: Array) -> None:
        if name not in self._parts:
            self._parts[name] = hashlib.blake2b(digest_size=16)
        self._parts[name].update(_packed(values).tobytes())


def _packed(values: Array) -> NDArray[np.float32]:
    with np.errstate(over="ignore", invalid="ignore"):
        return np.ascontiguousarray(values, np.float32) + np.float32(0.0)

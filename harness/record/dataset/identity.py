"""What an episode is known by: its content. Two that are equal are one, however often it was stored."""

import hashlib

import numpy as np
from numpy.typing import NDArray

from harness.record.dataset.dataset import Nested, Piece, leaves, take_rows


class Fingerprint:
    """A digest of what was seen, done and paid in an episode, as float32; pieces of any size give the same."""

    def __init__(self) -> None:
        self.has_fractions = False
        """Whether an observation or an action is no whole number: by chance they are not equal in two episodes."""
        self._parts = [hashlib.blake2b(digest_size=16) for _ in range(3)]

    def take(self, piece: Piece) -> None:
        """The next piece. What was seen after its last step belongs to the piece that follows, if one does."""
        steps = len(piece)
        seen = piece.observations if piece.is_last else take_rows(piece.observations, slice(0, steps))
        paid = tuple(piece.rewards[name] for name in sorted(piece.rewards))
        kinds = (part.dtype.kind for rows in (seen, piece.actions) for part in leaves(rows) if part.size)
        self.has_fractions = self.has_fractions or "f" in kinds
        for part, rows in zip(self._parts, (seen, piece.actions, paid), strict=True):
            part.update(_packed(rows).tobytes())

    def digest(self) -> bytes:
        """All pieces so far, as some bytes."""
        return b"".join(part.digest() for part in self._parts)


def _packed(rows: Nested) -> NDArray[np.float32]:
    parts = list(leaves(rows))
    if not parts:
        return np.empty((0, 0), np.float32)
    with np.errstate(over="ignore"):
        flat = [np.asarray(part, np.float32).reshape(len(part), -1) + np.float32(0.0) for part in parts]
    return np.ascontiguousarray(np.concatenate(flat, axis=1))

"""Rows of replay buffers are written once, and come back to their places."""

from typing import Any

import numpy as np
import pytest

from harness.algorithm import Ring
from harness.errors import SchemaError
from harness.experiment.checkpoints.checkpoint import StoredRing, discard_rings, read_ring, require_rings, store_ring

CAPACITY = 10


class Buffer:
    """A ring of numbered rows."""

    def __init__(self) -> None:
        self.columns: dict[str, Any] = {
            "seen": np.zeros((CAPACITY, 2, 3), np.float32),
            "done": np.zeros(CAPACITY, bool),
        }
        self.written = 0

    def write(self, rows):
        """Add so many."""
        for number in range(self.written, self.written + rows):
            self.columns["seen"][number % CAPACITY] = number
            self.columns["done"][number % CAPACITY] = number % 3 == 0
        self.written += rows
        return Ring(self.columns, self.written)

    def holds(self, ring):
        """Whether a restored ring holds the same, at the same places."""
        there = min(self.written, CAPACITY)
        return ring.written == self.written and all(
            ring.columns[name].dtype == array.dtype and np.array_equal(ring.columns[name], array[:there])
            for name, array in self.columns.items()
        )


def _files(folder):
    return sorted(path.name for path in folder.iterdir())


def test_ring_comes_back(tmp_path_factory, subtests):
    """However often it went round between two checkpoints."""
    for steps in [(3,), (3, 4), (10,), (7, 3), (7, 6), (7, 25), (4, 4, 4, 4, 4), (1,) * 23, (25, 1)]:
        with subtests.test(steps=steps):
            tmp_path = tmp_path_factory.mktemp("case")
            buffer, stored = Buffer(), None
            for rows in steps:
                stored = store_ring(tmp_path, "replay", buffer.write(rows), stored)
                require_rings(tmp_path, [stored])
                assert buffer.holds(read_ring(tmp_path, stored))


def test_only_new_rows_are_written(tmp_path):
    """A file that was written stays as it is until no row of it is in the ring."""
    buffer = Buffer()
    first = store_ring(tmp_path, "replay", buffer.write(6), None)
    second = store_ring(tmp_path, "replay", buffer.write(3), first)
    assert _files(tmp_path) == ["ring.replay.0-6.safetensors", "ring.replay.6-9.safetensors"]
    third = store_ring(tmp_path, "replay", buffer.write(8), second)
    assert [part.file for part in third.parts] == ["ring.replay.6-9.safetensors", "ring.replay.9-17.safetensors"]
    discard_rings(tmp_path, [third])
    assert _files(tmp_path) == [part.file for part in third.parts]
    discard_rings(tmp_path)
    assert _files(tmp_path) == []


def test_ring_without_new_rows_writes_nothing(tmp_path):
    """Nor does one that is empty."""
    buffer = Buffer()
    empty = store_ring(tmp_path, "replay", buffer.write(0), None)
    assert _files(tmp_path) == []
    assert read_ring(tmp_path, empty).columns == {}
    stored = store_ring(tmp_path, "replay", buffer.write(4), empty)
    assert store_ring(tmp_path, "replay", buffer.write(0), stored) == stored


def test_ring_that_was_emptied_is_written_anew(tmp_path):
    """What it held before is nothing to go on from."""
    stored = store_ring(tmp_path, "replay", Buffer().write(6), None)
    buffer = Buffer()
    stored = store_ring(tmp_path, "replay", buffer.write(2), stored)
    assert buffer.holds(read_ring(tmp_path, stored))


def test_name_of_a_ring_is_no_path(tmp_path):
    """Whatever an algorithm calls it, its files are in the cell's folder."""
    buffer = Buffer()
    stored = store_ring(tmp_path, "../of/env 1", buffer.write(3), None)
    assert [path.parent for path in tmp_path.iterdir()] == [tmp_path]
    assert buffer.holds(read_ring(tmp_path, stored))


def test_every_damage_is_noticed(tmp_path):
    """A byte that changed, a file that is gone, rows that no file has, a file elsewhere."""
    buffer = Buffer()
    stored = store_ring(tmp_path, "replay", buffer.write(3), None)
    stored = store_ring(tmp_path, "replay", buffer.write(3), stored)
    for parts in (stored.parts[:1], stored.parts[1:], ()):
        with pytest.raises(SchemaError, match="rows of a ring are missing"):
            require_rings(tmp_path, [StoredRing(CAPACITY, 6, parts)])
    outside = stored.parts[1]._replace(file=f"../{tmp_path.name}/{stored.parts[1].file}")
    with pytest.raises(SchemaError, match="is missing or damaged"):
        require_rings(tmp_path, [StoredRing(CAPACITY, 6, (stored.parts[0], outside))])
    path = tmp_path / stored.parts[0].file
    path.write_bytes(path.read_bytes()[:-1] + b"\xff")
    with pytest.raises(SchemaError, match=r"ring\.replay\.0-3\.safetensors is missing or damaged"):
        require_rings(tmp_path, [stored])
    path.unlink()
    with pytest.raises(SchemaError, match="is missing or damaged"):
        require_rings(tmp_path, [stored])


def test_ring_is_copied_into_a_buffer():
    """Places that were never written stay as they are."""
    columns = {"seen": np.full(5, -1)}
    Ring({"seen": np.arange(3)}, 3).copy_into(columns)
    assert columns["seen"].tolist() == [0, 1, 2, -1, -1]

"""A third party's reader of an invented format, ``examples/log-format``: one short file is enough.

That it keeps the contract is tested with the command that says so.
"""

import struct
import zlib

import pytest

from harness import load_registry
from harness.errors import SchemaError
from harness.log import open_logs
from harness.log.open_log import find_logs
from harness.registry.given import read_given
from tests.project import ROOT

FILE = ROOT / "examples" / "log-format" / "black_box.py"
MOST_LINES = 60
STEPS = ((0, 1, False, 0.25, 0.75), (0, 2, True, -1.5, 0.125), (1, 1, False, 2.0, 0.5))


@pytest.fixture(scope="module")
def registry():
    """The built-in plugins, and those of the file."""
    return load_registry(given=read_given([str(FILE)]))


@pytest.fixture
def recorded(tmp_path):
    """A black box, written byte by byte as its format says, by other code than the example's."""
    content = b"BLACKBOX" + (1).to_bytes(2, "little") + (11).to_bytes(4, "little")
    for episode, step, fell, pay, height in STEPS:
        record = episode.to_bytes(4, "little") + step.to_bytes(4, "little") + bytes([fell])
        record += struct.pack("<d", pay) + struct.pack("<d", height)
        content += record + zlib.crc32(record).to_bytes(4, "little")
    (tmp_path / "flight.bbox").write_bytes(content)
    return tmp_path / "flight.bbox"


def test_reader_is_one_short_file():
    """With its imports, its docstrings and the code that writes the format."""
    assert len(FILE.read_text(encoding="utf-8").splitlines()) <= MOST_LINES


def test_numbers_are_those_of_the_file(registry, recorded):
    """It is found by what it is, and every step is as it was written."""
    (log,) = open_logs(recorded, registry)
    names = ("episode", "step", "terminated", "reward/recorded", "behaviour/height")
    assert list(zip(*(log[name].tolist() for name in names), strict=True)) == list(STEPS)
    assert (log.facts.seed, log.rewards, log.measures) == (11, ("recorded",), ("height",))


def test_changed_step_is_refused(registry, recorded):
    """By its checksum; a folder of such logs says which one it was, and why."""
    content = bytearray(recorded.read_bytes())
    content[30] ^= 1
    recorded.write_bytes(content)
    with pytest.raises(SchemaError, match=r"flight\.bbox: a record was changed"):
        open_logs(recorded, registry)
    ((path, reason),) = find_logs(recorded.parent, registry).left_out
    assert path == recorded
    assert "a record was changed" in reason

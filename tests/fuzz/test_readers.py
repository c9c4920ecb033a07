"""Whatever stands in a file, its reader reads it or refuses it: `HarnessError` alone, within a second and 500 MB.

Warnings are errors here, and a reader that writes, starts or connects anything fails. The long run is for an issue:
``pytest tests/fuzz -m slow``, 10,000 inputs for each reader; an input is named by its seed.
"""

from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tests.fuzz.readers import Reader

NAMES = (
    *("csv", "toml", "experiment", "tuning", "urdf", "robot", "binary stl", "text stl", "obj"),
    *("policy squashed-gaussian", "policy greedy", "policy uniform-choice", "policy inverse-kinematics"),
    *("text of rewards", "text of tasks", "text of algorithms", "text of executors"),
    *("recorded trace", "trace", "scene", "manifest", "sealed manifest", "plan", "sealed plan"),
    *("recorded training", "steps of a recorded training"),
)
EACH = pytest.mark.parametrize("name", NAMES)
SEEDS = st.integers(0, 2**63)
Fuzz = Callable[[Reader, int], bool]


def play(reader: Reader, fuzz: Fuzz, count: int) -> None:
    """Let the reader read so many inputs, some of which have to be refused."""
    refused, tried = 0, 0

    @settings(
        max_examples=count,
        derandomize=True,
        database=None,
        phases=[Phase.generate],  # a seed has no simpler one
        suppress_health_check=list(HealthCheck),
    )
    @given(SEEDS)
    def read(seed: int) -> None:
        nonlocal refused, tried
        tried += 1
        refused += fuzz(reader, seed)

    read()
    assert tried >= count
    assert refused > count / 20


def test_every_reader_is_tried(all_readers: dict[str, Reader]):
    """The table and the tests name the same."""
    assert sorted(all_readers) == sorted(NAMES)


@EACH
def test_valid_content_is_read(all_readers: dict[str, Reader], name: str, tmp_path):
    """What the inputs are made of is right, or its mistakes would hide others."""
    for file, content in all_readers[name].files.items():
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_bytes(content)
    all_readers[name].read(tmp_path)


@EACH
def test_a_reader_refuses_what_it_cannot_read(all_readers: dict[str, Reader], fuzz: Fuzz, name: str):
    """A few inputs of each kind."""
    play(all_readers[name], fuzz, 100)


@pytest.mark.slow
@EACH
def test_a_reader_refuses_whatever_it_cannot_read(all_readers: dict[str, Reader], fuzz: Fuzz, name: str):
    """Very many."""
    play(all_readers[name], fuzz, 10_000)

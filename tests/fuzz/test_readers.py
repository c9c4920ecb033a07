"""Whatever stands in a file, its reader reads it or refuses it: `HarnessError` alone, within a second and 500 MB.

Warnings are errors here, and a reader that writes, starts or connects anything fails. The long run is for an issue:
``pytest tests/fuzz -m slow``, 10,000 inputs for each reader; an input is named by its seed. With FUZZ_MINUTES it is new
inputs each time, as many as can be tried in so many minutes.
"""

import os
import time
from random import SystemRandom

import pytest
from hypothesis import HealthCheck, Phase, given, settings, strategies as st

NAMES = (
    *("csv", "toml", "experiment", "urdf", "robot", "binary stl", "collada", "glb", "ply", "text stl", "obj"),
    *("policy squashed-gaussian", "policy greedy", "policy uniform-choice", "policy inverse-kinematics"),
    *("text of rewards", "text of tasks", "text of algorithms", "text of executors"),
    *("recorded trace", "trace", "scene", "certificate", "manifest", "sealed manifest", "plan", "sealed plan"),
    *("recorded training", "steps of a recorded training"),
    *("minari", "facts of minari", "lerobot", "facts of lerobot"),
    *("episodes of lerobot", "lines of lerobot", "labels"),
    *("d4rl", "robomimic", "evaluations", "tensorboard"),
)
EACH = pytest.mark.parametrize("name", NAMES)
SEEDS = st.integers(0, 2**63)
MINUTES = "FUZZ_MINUTES"
"""The environment variable with the minutes of the long run, for all readers together."""


def play(reader, fuzz, count):
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
    def read(seed):
        nonlocal refused, tried
        tried += 1
        refused += fuzz(reader, seed)

    read()
    assert tried >= count
    assert refused > count / 20


def play_for(reader, fuzz, seconds):
    """Let the reader read new inputs for so long, some of which have to be refused."""
    refused, tried, until = 0, 0, time.monotonic() + seconds
    while not tried or time.monotonic() < until:
        seed = SystemRandom().randrange(2**63)
        tried += 1
        try:
            refused += fuzz(reader, seed)
        except Exception as error:
            raise AssertionError(f"seed {seed}: {error!r}") from error
    assert refused > tried / 20


def test_every_reader_is_tried(all_readers):
    """The table and the tests name the same."""
    assert sorted(all_readers) == sorted(NAMES)


@EACH
def test_valid_content_is_read(all_readers, name, tmp_path):
    """What the inputs are made of is right, or its mistakes would hide others."""
    for file, content in all_readers[name].files.items():
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_bytes(content)
    all_readers[name].read(tmp_path)


def test_a_run_of_minutes_has_other_inputs_each_time(all_readers):
    """And ends when they are over."""
    runs = [[], []]
    for seeds in runs:
        play_for(all_readers["csv"], lambda reader, seed, seeds=seeds: not seeds.append(seed), 0.01)
    assert runs[0]
    assert not set(runs[0]) & set(runs[1])


def test_a_run_of_minutes_names_the_seed_that_fails(all_readers):
    """So that it can be tried again."""

    def fail(reader, seed):
        raise ZeroDivisionError

    with pytest.raises(AssertionError, match=r"^seed \d+: ZeroDivisionError"):
        play_for(all_readers["csv"], fail, 0.01)


@EACH
def test_a_reader_refuses_what_it_cannot_read(all_readers, fuzz, name):
    """A few inputs of each kind."""
    play(all_readers[name], fuzz, 100)


@pytest.mark.slow
@EACH
def test_a_reader_refuses_whatever_it_cannot_read(all_readers, fuzz, name):
    """Very many."""
    if MINUTES in os.environ:
        play_for(all_readers[name], fuzz, 60.0 * float(os.environ[MINUTES]) / len(NAMES))
    else:
        play(all_readers[name], fuzz, 10_000)

"""What is read is right: an input that is changed is answered as an independent computation says, or refused.

`tests/fuzz` asks whether a reader raises; these ask whether what it accepted is true. A quick sample runs with the
other tests. ``pytest tests/oracles -m slow`` tries 500 inputs. With ORACLE_INPUTS=5000 it is so many, and new ones each
time; what fails names its seed.
"""

import os
from random import Random, SystemRandom

import pytest

from tests.oracles import (
    arms,
    csv_files,
    experiments,
    lerobot_damage,
    lerobot_sets,
    minari_sets,
    named_labels,
    recordings,
    settings,
)
from tests.oracles.trial import fault_of

ORACLES = {
    **lerobot_sets.ORACLES,
    **lerobot_damage.ORACLES,
    **minari_sets.ORACLES,
    **named_labels.ORACLES,
    **csv_files.ORACLES,
    **recordings.ORACLES,
    **experiments.ORACLES,
    **arms.ORACLES,
    **settings.ORACLES,
}
EACH = pytest.mark.parametrize("name", ORACLES)
INPUTS, ALL, QUICK = "ORACLE_INPUTS", 500, 1
"""The environment variable with the number of inputs of the long run; that number without it; and of the quick one, of
each oracle."""


def faults_of(name, seeds, folder):
    """What is answered wrongly, by seed."""
    found = []
    for place, seed in enumerate(seeds):
        own = folder / str(place)
        own.mkdir()
        fault = fault_of(ORACLES[name](Random(seed), own))
        found += [] if fault is None else [f"seed {seed}: {fault}"]
    return found


@EACH
def test_an_answer_is_right_or_refused(name, tmp_path):
    """A few inputs of each kind."""
    assert faults_of(name, list(range(QUICK)), tmp_path) == []


@pytest.mark.slow
@EACH
def test_every_answer_is_right_or_refused(name, tmp_path):
    """Very many."""
    count = -(-int(os.environ.get(INPUTS, ALL)) // len(ORACLES))
    seeds = [SystemRandom().randrange(2**32) for _ in range(count)] if INPUTS in os.environ else list(range(count))
    assert faults_of(name, seeds, tmp_path) == []

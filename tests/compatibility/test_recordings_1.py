"""Recordings of format 1, which hold no actions, are read and reported as before.

``recordings_1/loose`` was made by ``recordings_1/make.py``, and ``recordings_1/experiment`` by::

    harness run --task gymnasium:id=FrozenLake-v1,pays=prob,tells=prob --algo random --seeds 2 --steps 64
        --evaluation-episodes 3 --out experiment --jobs 1

``returns.json`` has the mean returns that ``harness report --json`` told of both.
"""

import json
import shutil
from pathlib import Path

import pytest

from harness import load_results
from harness.record.recording.recorded_training import read_recording
from harness.record.store import Store

HERE = Path(__file__).parent / "recordings_1"
TOLD = json.loads((HERE / "returns.json").read_text())


@pytest.fixture
def here(tmp_path):
    """A copy: what a report keeps is left in the folder."""
    return Path(shutil.copytree(HERE, tmp_path / "here"))


def _returns(results):
    return {
        it.manner: {f"{payer} pays {by}": mean.value for payer, row in it.returns.items() for by, mean in row.items()}
        for it in results.returns
    }


def test_loose_recordings_are_reported_as_before(here):
    """The same trainings, and the same mean returns."""
    results = load_results(here / "loose")
    assert sorted(results.trainings[0].runs) == [(reward, seed) for reward in ("own", "slow") for seed in (0, 1)]
    assert _returns(results) == TOLD["loose"]


def test_experiment_in_an_environment_is_reported_as_before(here):
    """Its cells are done, and their returns are the same."""
    results = load_results(here / "experiment")
    assert results.plan.note == ""  # the plan was read, and not put together from the cells
    assert len(results.trainings[0].runs) == len(Store.open(here / "experiment").read_plan().cells) == 4
    assert _returns(results) == TOLD["experiment"]


@pytest.mark.parametrize("path", ["own-0", "own-0/evaluation"])
def test_recording_says_that_it_has_no_actions(path):
    """So nobody takes them again."""
    assert read_recording(HERE / "loose" / path).facts.actions is None

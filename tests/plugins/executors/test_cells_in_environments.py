"""Executors do cells whose task is an environment as they do others: wherever it was done, a cell leaves the same."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import pytest

from harness import load_registry
from harness.executor import CellOptions, Event, Job, Part, Word, add_parts
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_cell import run_cell
from harness.record import EVALUATION_RECORDING, POLICY, RANDOM
from harness.record.folder import TRAINING_RECORDING, recording_of
from harness.registry import choose, read_given
from harness_plugins.ray_cluster.node import Ended, Slot
from tests.experiment.environments.test_going_on import files_of

TOY = Path(__file__).parents[2] / "experiment" / "environments" / "toy.py"


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    """A cell that trains in a toy, which is a file of the user's."""
    given = read_given([TOY])
    asked = {"task": "toy", "algo": "random", "seeds": 1, "steps": 40, "evaluation_episodes": 2, "reward": []}
    (cell,) = expand(check_experiment(asked), load_registry(given=given)).cells
    return Job(cell, tmp_path_factory.mktemp("cells") / cell.id, CellOptions(plugins=given))


@pytest.fixture(scope="module")
def expected(job, tmp_path_factory):
    """What it leaves when this process does it."""
    folder = tmp_path_factory.mktemp("here") / "cell"
    assert run_cell(job.cell, folder, lambda word: None, job.options).status == "done"
    return files_of(folder)


def test_a_node_of_ray_sends_its_recordings(job, expected, tmp_path):
    """From a folder of its own: recordings and policy, byte for byte."""
    told = list(Slot().do_and_send(job.to_json(), ["harness"], []))
    assert told[-1] == Ended("")
    assert any(isinstance(word, Word) for word in told)
    add_parts(tmp_path / "sent", [part for part in told if isinstance(part, Part)])
    assert files_of(tmp_path / "sent") == expected
    assert {name.split("/")[0] for name in expected} == {
        *(TRAINING_RECORDING, EVALUATION_RECORDING, POLICY),
        *map(recording_of, ("stochastic", RANDOM)),
    }


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # of submitit, see test_slurm
@pytest.mark.parametrize(
    ("executor", "library"), [("ray", "ray"), ("ray:fetch=true", "ray"), ("slurm:cluster=local", "submitit")]
)
def test_other_machines_leave_the_same(job, expected, tmp_path, executor, library):
    """By a cluster of this machine alone, and by jobs of it."""
    if importlib.util.find_spec(library) is None:
        pytest.skip(f"needs {library}")
    registry, told = load_registry(), list[Event]()
    built = choose(registry, "executors", executor).build(registry, "executors")
    built.run([replace(job, folder=tmp_path / "cells" / job.cell.id)], 1, told.append)
    assert [(event.kind, event.reason) for event in told if event.kind != "progress"] == [
        ("started", ""),
        ("ended", ""),
    ]
    assert files_of(tmp_path / "cells" / job.cell.id) == expected

"""The episodes that policies are judged by."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.executor import CellOptions
from harness.experiment.arm_evaluation import EVALUATION_SEED
from harness.experiment.run_cell import run_cell
from harness.experiment.workers.order import Order
from harness.record.folder import EVALUATION, LOG
from harness.record.manifest import read_manifest
from harness.record.trace import read_trace
from harness.registry.choice import Choice
from harness.registry.given import read_given
from harness_plugins.tune.outcomes import REASON, VALIDATION_SEED, ValidatePolicy, validate_all
from tests.registry.test_given import REWARD


@pytest.fixture
def trained(toys, make_cell, tmp_path):
    """Train a cell of the ideal arm; returns its order."""

    def train(name: str = "cell", **fields) -> Order:
        run_cell(make_cell(evaluation_episodes=8, **fields), tmp_path / name, lambda steps: None)
        return Order(tmp_path / "validation" / name, ValidatePolicy(tmp_path / name, 8))

    return train


def _validate(order: Order) -> Path:
    """In this process; the trace."""
    assert order.work.do(order.folder, lambda steps: None)
    return order.folder / EVALUATION


def _targets(path: Path) -> np.ndarray:
    trace = read_trace(path)
    return np.stack([trace[f"target_{axis}"] for axis in "xyz"], axis=1)


def test_targets_are_apart_from_the_evaluation(toys, trained):
    """No target of a validation is one of the evaluation, nor is the seed; the number of episodes is the same here."""
    order = trained()
    judged, evaluated = _targets(_validate(order)), _targets(order.work.cell_folder / EVALUATION)
    assert VALIDATION_SEED != EVALUATION_SEED
    assert not np.isin(judged, evaluated).any()


def test_targets_are_the_same_for_every_policy(toys, trained):
    """Whatever the reward and the seed that trained it."""
    first, second = trained("one"), trained("two", seed=5, reward=Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp"))
    starts = [read_trace(_validate(order), ["target_x", "step", "env"]) for order in (first, second)]
    per_env = [{(env, x) for env, x in zip(t["env"], t["target_x"], strict=True)} for t in starts]
    assert per_env[0] == per_env[1]


def test_policies_are_validated_in_processes_of_their_own(trained):
    """Each leaves its trace, one episode per env."""
    orders = [trained("one"), trained("two", seed=1), trained("three", seed=2)]
    validate_all(orders, 2)
    for order in orders:
        assert len(read_trace(order.folder / EVALUATION).episodes) == 8
        assert not (order.folder / REASON).exists()


def _elsewhere(order: Order, then: str) -> Order:
    """The cell as if it had been trained in a simulator that goes wrong."""
    manifest = read_manifest(order.work.cell_folder)
    simulator = Choice("stuck", (("then", then), ("note", "")), f"stuck:then={then}")
    replace(manifest, cell=replace(manifest.cell, simulator=simulator)).write(order.work.cell_folder)
    return order


def test_what_goes_wrong_costs_itself_alone(trained):
    """One that raises and one that kills its process have their reasons; those after them are validated."""
    raising, dying = _elsewhere(trained("raising"), "raise"), _elsewhere(trained("dying"), "be killed")
    fine = trained("fine")
    validate_all([raising, dying, fine], 1)
    assert (raising.folder / REASON).read_text() == "RuntimeError: the arm fell off"
    assert (dying.folder / REASON).read_text() == "its process was ended by SIGKILL"
    assert "Traceback" in (raising.folder / LOG).read_text()
    assert [order.folder / EVALUATION for order in (raising, dying, fine) if (order.folder / EVALUATION).exists()] == [
        fine.folder / EVALUATION
    ]


def test_policy_that_a_file_taught_is_validated(toys, make_cell, tmp_path):
    """The file goes with the order."""
    (tmp_path / "my_reward.py").write_text(REWARD)
    given = read_given([tmp_path / "my_reward.py"])
    cell = make_cell(reward=Choice("my_reward", (("scale", 1.0),), "my_reward"))
    run_cell(cell, tmp_path / "cell", lambda steps: None, CellOptions(plugins=given))
    done = Order(tmp_path / "with", ValidatePolicy(tmp_path / "cell", 2, given))
    assert _validate(done).is_file()
    assert not ValidatePolicy(tmp_path / "cell", 2).do(tmp_path / "without", lambda steps: None)


def test_what_is_validated_is_not_again(trained):
    """A folder that is there stays as it is."""
    order = trained()
    order.folder.mkdir(parents=True)
    validate_all([order], 1)
    assert not list(order.folder.iterdir())

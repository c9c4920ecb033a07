"""The episodes that policies are judged by."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.experiment.evaluate import EVALUATION_SEED
from harness.experiment.run_cell import run_cell
from harness.record.folder import EVALUATION
from harness.record.manifest import read_manifest
from harness.record.trace import read_trace
from harness.registry.choice import Choice
from harness.tune.validation import VALIDATION_SEED, Order, validate
from harness.tune.validator import validate_all


@pytest.fixture
def trained(toys, make_cell, tmp_path):
    """Train a cell of the ideal arm; returns its order."""

    def train(name: str = "cell", **fields) -> Order:
        run_cell(make_cell(evaluation_episodes=8, **fields), tmp_path / name, lambda steps: None)
        return Order(str(tmp_path / name), str(tmp_path / f"{name}.parquet"), 8)

    return train


def _targets(path: Path) -> np.ndarray:
    trace = read_trace(path)
    return np.stack([trace[f"target_{axis}"] for axis in "xyz"], axis=1)


def test_targets_are_apart_from_the_evaluation(toys, trained):
    """No target of a validation is one of the evaluation, nor is the seed; the number of episodes is the same here."""
    order = trained()
    validate(order, toys)
    judged, evaluated = _targets(Path(order.path)), _targets(Path(order.cell_folder) / EVALUATION)
    assert VALIDATION_SEED != EVALUATION_SEED
    assert not np.isin(judged, evaluated).any()


def test_targets_are_the_same_for_every_policy(toys, trained):
    """Whatever the reward and the seed that trained it."""
    first, second = trained("one"), trained("two", seed=5, reward=Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp"))
    for order in (first, second):
        validate(order, toys)
    starts = [read_trace(Path(order.path), ["target_x", "step", "env"]) for order in (first, second)]
    per_env = [{(env, x) for env, x in zip(t["env"], t["target_x"], strict=True)} for t in starts]
    assert per_env[0] == per_env[1]


def test_policies_are_validated_in_processes_of_their_own(trained, tmp_path):
    """Each leaves its trace, one episode per env."""
    orders = [trained("one"), trained("two", seed=1), trained("three", seed=2)]
    validate_all(orders, 2, tmp_path)
    for order in orders:
        assert len(read_trace(Path(order.path)).episodes) == 8
        assert not order.failure.exists()


def _elsewhere(order: Order, then: str) -> Order:
    """The cell as if it had been trained in a simulator that goes wrong."""
    manifest = read_manifest(Path(order.cell_folder))
    simulator = Choice("stuck", (("then", then), ("note", "")), f"stuck:then={then}")
    replace(manifest, cell=replace(manifest.cell, simulator=simulator)).write(Path(order.cell_folder))
    return order


def test_what_goes_wrong_costs_itself_alone(trained, tmp_path):
    """One that raises and one that kills its process have their reasons; those after them are validated."""
    raising, dying = _elsewhere(trained("raising"), "raise"), _elsewhere(trained("dying"), "be killed")
    fine = trained("fine")
    validate_all([raising, dying, fine], 1, tmp_path)
    assert raising.failure.read_text() == "RuntimeError: the arm fell off"
    assert "exit status -9" in dying.failure.read_text()
    assert Path(fine.path).exists()
    assert not fine.failure.exists()


def test_what_is_validated_is_not_again(trained, tmp_path):
    """A trace that is there stays as it is."""
    order = trained()
    Path(order.path).write_text("there")
    validate_all([order], 1, tmp_path)
    assert Path(order.path).read_text() == "there"

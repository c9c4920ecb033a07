"""Cells that learn in hindsight: on a toy with goals, and where that is not possible."""

import numpy as np
import pytest

from harness.executor import CellOptions
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_cell import run_cell
from harness.record import read_recording

SMALL = "net_arch=32,batch_size=64,learning_starts=50,learning_rate=0.003"


def _plan(registry, algo, **keys):
    asked = {"task": "goal_toy", "baseline": "there", "reward": [], "seeds": 1, "steps": 500, **keys}
    return expand(check_experiment({"algo": algo, **asked}), registry)


def _done(plan, folder, given):
    return run_cell(plan.cells[0], folder, lambda word: None, CellOptions(plugins=given))


def _success(folder):
    told = read_recording(folder / "evaluation")
    return float(told["behaviour/success"][told["truncated"]].mean())


def test_hindsight_learns_from_a_sparse_reward(registry, given, tmp_path):
    """500 steps are enough, of which the same learner without hindsight learns next to nothing."""
    for name, algo in (("with", "her"), ("without", "sac-fast")):
        assert _done(_plan(registry, f"{algo}:{SMALL}"), tmp_path / name, given).status == "done"
    assert _success(tmp_path / "with") > 0.6
    assert _success(tmp_path / "without") < 0.3
    assert set(np.unique(read_recording(tmp_path / "with" / "training")["reward/there"])) <= {-1.0, 0.0}


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"baseline": "slow"}, "'slow' is not known to depend on the goals alone; these are: there"),
        ({"task": "toy", "baseline": "near"}, "in toy observations have no goals"),
        ({"task": "fd100-reach", "sim": "kinematic", "baseline": "dense"}, "Give an environment with goals"),
    ],
)
def test_what_cannot_be_paid_again_is_skipped(registry, keys, told):
    """With the reason."""
    plan = _plan(registry, "her", **keys)
    assert not plan.cells
    assert plan.skipped
    assert all(told in reason for _, reason in plan.skipped)


def test_other_rewards_of_the_matrix_train(registry):
    """What is skipped is the reward that is no function of goals, and with this algorithm alone."""
    assert [
        (cell.algorithm.name, cell.reward.label) for cell in _plan(registry, "her,sac-fast", reward=["slow"]).cells
    ] == [
        ("her", "there"),
        ("sac-fast", "there"),
        ("sac-fast", "slow"),
    ]


def test_a_reward_that_pays_otherwise_than_by_its_goals_fails_the_cell(registry, given, tmp_path):
    """At the first step: nothing is learned from steps that are paid wrongly."""
    manifest = _done(_plan(registry, f"her:{SMALL}", task="goal_toy:lies=true"), tmp_path / "cell", given)
    assert manifest.status == "failed"
    assert "it is no function of goals alone" in manifest.reason

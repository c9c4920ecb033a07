"""Return under every reward."""

import json

import numpy as np
import pytest

from harness.record import read_trace
from harness.registry import Choice
from harness.score.scorer import pay_log


@pytest.fixture
def results(ran_toys):
    """Two seeds of three rewards."""
    return ran_toys(evaluate_every=5)


@pytest.fixture
def matrix(results):
    """The one there is."""
    (matrix,) = results.returns
    return matrix


def evaluations(results, label):
    """Of the trainings by a reward."""
    cells = [cell for cell in results.done_cells if cell.reward.label == label]
    return [read_trace(results.store.cell_folder(cell) / "evaluation.parquet") for cell in cells]


def test_every_training_is_scored_by_every_reward(matrix):
    """Rows and columns are the experiment's rewards, the baseline first."""
    assert matrix.trained_with == ("baseline", "arp", "dense")
    assert {scoring: tuple(row) for scoring, row in matrix.returns.items()} == dict.fromkeys(
        matrix.trained_with, matrix.trained_with
    )


def test_return_is_the_mean_over_episodes_and_seeds(results, matrix):
    """Of the shaped reward of whole episodes, as worked out apart; on the diagonal, what was recorded."""
    dense = next(cell.reward for cell in results.done_cells if cell.reward.label == "dense")
    reward = dense.build(results.registry, "rewards")
    found = matrix.returns["dense"]["arp"]
    sums = [pay_log(reward, trace).total.sum() / 3 for trace in evaluations(results, "arp")]
    assert found.value == pytest.approx(np.mean(sums), rel=1e-12)
    assert (found.seeds, found.note) == (2, "2 seeds: no interval below 3 seeds")
    for label in matrix.trained_with:
        recorded = np.mean([trace["reward"].sum() / 3 for trace in evaluations(results, label)])
        assert matrix.returns[label][label].value == pytest.approx(recorded, rel=1e-12)


def test_events_are_apart(results, matrix):
    """What they paid is the same under every reward; here a policy that drifts alike gets alike."""
    trace = evaluations(results, "baseline")[0]
    paid = sum(trace[name].sum() for name in ("reward_ground", "reward_target", "reward_step")) / 3
    assert matrix.events["baseline"].value == pytest.approx(paid)
    assert set(matrix.events) == {"baseline", "arp", "dense"}


def test_reward_that_has_changed_has_no_return(results):
    """The whole row has the reason; the other rows stand."""
    for manifest in results.manifests:
        if manifest.cell.reward.label == "arp":
            changed = Choice("arp", (("k1", 1.0), ("k2", 9.0)), "arp")
            assert manifest.cell.id  # kept: it names the folder
            object.__setattr__(manifest.cell, "reward", changed)
    (matrix,) = results.returns
    reason = "reward arp now pays its recorded steps differently: it has changed"
    assert {(mean.value, mean.note) for mean in matrix.returns["arp"].values()} == {(None, reason)}
    assert all(mean.value is not None for mean in matrix.returns["dense"].values())


def test_matrix_is_strict_json(matrix):
    """By label, with the group."""
    data = matrix.to_json()
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert set(data["returns"]["arp"]["dense"]) == {"value", "low", "high", "seeds", "note"}
    assert data["algorithm"] == "narrate"

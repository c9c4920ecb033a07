"""Return under every reward."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harness.experiment.plan import check_experiment, expand
from harness.record.folder import EVALUATION
from harness.record.trace import read_trace
from harness.registry.choice import Choice
from harness.registry.registry import Registry
from harness.results import Results
from harness.results.return_matrix import ReturnMatrix
from harness.score.scorer import pay_log

GIVEN = {
    "sim": "ideal", "algo": "narrate", "task": "fd100-reach:horizon=5", "seeds": 2, "steps": 12,
    "evaluation_episodes": 3, "evaluate_every": 5, "reward": "arp,dense",
}  # fmt: skip


@pytest.fixture
def results(toys: Registry, run_once: Callable[..., Results], tmp_path: Path) -> Results:
    """Two seeds of three rewards."""
    return run_once(expand(check_experiment(GIVEN), toys), tmp_path / "out")


@pytest.fixture
def matrix(results: Results) -> ReturnMatrix:
    """The one there is."""
    (matrix,) = results.returns
    return matrix


def test_every_training_is_scored_by_every_reward(matrix: ReturnMatrix):
    """Rows and columns are the experiment's rewards, the baseline first."""
    assert matrix.trained_with == ("baseline", "arp", "dense")
    assert {scoring: tuple(row) for scoring, row in matrix.returns.items()} == dict.fromkeys(
        matrix.trained_with, matrix.trained_with
    )


def test_return_is_the_mean_over_episodes_and_seeds(results: Results, matrix: ReturnMatrix):
    """Of the shaped reward of whole episodes, as worked out apart."""
    cells = [cell for cell in results.done_cells if cell.reward.label == "arp"]
    dense = next(cell.reward for cell in results.done_cells if cell.reward.label == "dense")
    reward = dense.build(results.registry, "rewards")
    traces = [read_trace(results.store.cell_folder(cell) / EVALUATION) for cell in cells]
    sums = [pay_log(reward, trace).total.sum() / 3 for trace in traces]
    found = matrix.returns["dense"]["arp"]
    assert found.mean == pytest.approx(np.mean(sums), rel=1e-12)
    assert (found.seeds, found.note) == (2, "2 seeds: no interval below 3 seeds")


def test_own_return_is_what_was_recorded(results: Results, matrix: ReturnMatrix):
    """On the diagonal, the recorded shaped rewards."""
    for label in matrix.trained_with:
        cells = [cell for cell in results.done_cells if cell.reward.label == label]
        traces = [read_trace(results.store.cell_folder(cell) / EVALUATION) for cell in cells]
        recorded = np.mean([trace["reward"].sum() / 3 for trace in traces])
        assert matrix.returns[label][label].mean == pytest.approx(recorded, rel=1e-12)


def test_events_are_apart(results: Results, matrix: ReturnMatrix):
    """What they paid is the same under every reward; here a policy that drifts alike gets alike."""
    cell = next(cell for cell in results.done_cells if cell.reward.label == "baseline")
    trace = read_trace(results.store.cell_folder(cell) / EVALUATION)
    paid = sum(trace[name].sum() for name in ("reward_ground", "reward_target", "reward_step")) / 3
    assert matrix.events["baseline"].mean == pytest.approx(paid)
    assert set(matrix.events) == {"baseline", "arp", "dense"}


def test_reward_that_has_changed_has_no_return(results: Results):
    """The whole row has the reason; the other rows stand."""
    for manifest in results.manifests:
        if manifest.cell.reward.label == "arp":
            changed = Choice("arp", (("k1", 1.0), ("k2", 9.0)), "arp")
            assert manifest.cell.id  # kept: it names the folder
            object.__setattr__(manifest.cell, "reward", changed)
    (matrix,) = results.returns
    reason = "reward arp now pays its recorded steps differently: it has changed"
    assert {(mean.mean, mean.note) for mean in matrix.returns["arp"].values()} == {(None, reason)}
    assert all(mean.mean is not None for mean in matrix.returns["dense"].values())


def test_matrix_is_strict_json(matrix: ReturnMatrix):
    """By label, with the group."""
    data = matrix.to_json()
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert set(data["returns"]["arp"]["dense"]) == {"mean", "low", "high", "seeds", "note"}
    assert data["algorithm"] == "narrate"

"""What a folder says of transfer, read from records that were written by hand: nothing is trained or evaluated."""

import json
from collections.abc import Callable

import numpy as np
import pytest

from harness import load_results
from harness.files.plain import to_plain
from harness.record import COLUMN, EVALUATION, POLICY, SCALARS, Manifest, TraceWriter
from harness.record.folder import WEIGHTS
from harness.registry import Choice
from harness.results import Results
from harness_plugins.transfer import TRANSFER, TransferRecord, load_transfers, simulator_id
from harness_plugins.transfer.record import policy_digest
from tests.stores import create_store

HOME, AWAY = Choice("ideal", (), "ideal"), Choice("stuck", (), "stuck")
REASON = "RuntimeError: it fell"

Train = Callable[..., Results]


@pytest.fixture
def train(make_cell, make_plan, tmp_path):
    """A folder of done cells, one per seed: of the four episodes of each evaluation so many reach the target."""

    def write(at_home, **fields):
        cells = [make_cell(seed=seed, **fields) for seed in range(len(at_home))]
        store = create_store(tmp_path / "mine", make_plan(*cells))
        for cell, reached in zip(cells, at_home, strict=True):
            folder = store.cell_folder(cell)
            (folder / POLICY).mkdir(parents=True)
            (folder / POLICY / WEIGHTS).write_bytes(bytes([cell.seed]))
            write_evaluation(folder, reached)
            Manifest(cell, status="done").write(folder)
        return load_results(store.folder)

    return write


def write_evaluation(folder, reached):
    """Four episodes of one step, each paid 1, and 10 more by an event term where it reaches the target."""
    rows = np.zeros((8, len(SCALARS) + 2))
    rows[:, COLUMN["episode"]] = np.repeat(np.arange(4), 2)
    rows[1::2, COLUMN["step"]] = rows[1::2, COLUMN["reward"]] = rows[1::2, COLUMN["terminated"]] = 1.0
    rows[1 : 2 * reached : 2, COLUMN["reached"]] = 1.0
    rows[1 : 2 * reached : 2, COLUMN["reward_target"]] = 10.0
    with TraceWriter(folder / EVALUATION, dof=1, action_size=1) as writer:
        writer.append(rows)


def visit(results, cell, reached, simulator=AWAY):
    """Record that the cell's policy was evaluated there; None where that failed."""
    folder = results.folder / TRANSFER / cell.id / simulator_id(simulator)
    folder.mkdir(parents=True)
    digest = policy_digest(results.store.cell_folder(cell))
    if reached is None:
        TransferRecord(cell.id, simulator, digest, status="failed", reason=REASON).write(folder)
    else:
        write_evaluation(folder, reached)
        TransferRecord(cell.id, simulator, digest, status="done").write(folder)


def visit_all(results, away):
    """All policies evaluated elsewhere, in the order of their seeds, and what the folder then says."""
    for cell, reached in zip(results.done_cells, away, strict=True):
        visit(results, cell, reached)
    (matrix,) = load_transfers(results).matrices
    return matrix


def test_home_comes_first(train):
    """Rows are the simulators trained in; columns are those, then the ones that were visited."""
    matrix = visit_all(train([4, 2]), [1, 1])
    assert (matrix.trained_in, matrix.evaluated_in) == ((HOME.label,), (HOME.label, AWAY.label))


def test_success_is_the_mean_over_seeds(train):
    """In each simulator, of its own evaluations."""
    assert [mean.value for mean in visit_all(train([4, 2]), [1, 0]).success[0]] == [0.75, 0.125]


def test_return_is_all_that_an_episode_was_paid(train):
    """Shaped reward and event terms, mean over episodes and seeds."""
    assert [mean.value for mean in visit_all(train([4, 2]), [1, 0]).paid[0]] == [1.0 + 10.0 * 0.75, 1.0 + 10.0 * 0.125]


def test_drop_is_taken_seed_by_seed(train):
    """Every seed loses half, however much it had: the mean is exact. At home there is nothing to lose."""
    home, away = visit_all(train([4, 3, 2]), [2, 1, 0]).drop[0]
    assert away.value == 0.5
    assert away.low is not None
    assert away.low < 0.5  # a seed that was not seen may lose another share
    assert home.value is None


def test_seed_that_was_not_evaluated_is_said(train):
    """The mean is over those that were, the drop over pairs; only that place is short of a seed."""
    results = train([4, 2, 0])
    for cell in results.done_cells[:2]:
        visit(results, cell, 0)
    (matrix,) = load_transfers(results).matrices
    home, away = matrix.success[0]
    assert (home.seeds, away.seeds) == (3, 2)
    assert "1 of 3 not evaluated" in away.notes
    assert "1 of 3 not evaluated" not in home.notes
    assert matrix.drop[0][1].value == 0.75


def test_evaluation_that_failed_is_counted_and_listed(train):
    """With its reason, beside those that were never tried."""
    results = train([4, 4, 4])
    visit(results, results.done_cells[0], None)
    visit(results, results.done_cells[1], 4)
    transfers = load_transfers(results)
    assert "1 of 3 failed, 1 of 3 not evaluated" in transfers.matrices[0].success[0][1].notes
    assert [to_plain(failure)["reason"] for failure in transfers.failed] == [REASON]


def test_one_seed_has_no_interval(train):
    """Anywhere, and the reason stands beside each number."""
    matrix = visit_all(train([4]), [1])
    for mean in (*matrix.success[0], *matrix.paid[0], matrix.drop[0][1]):
        assert (mean.low, mean.high, mean.seeds) == (None, None, 1)
        assert any("one seed" in note for note in mean.notes)


def test_other_policy_of_a_cell_is_another_result(train):
    """What was recorded of weights that were trained again since is not told; of weights that are gone it is."""
    results = train([4])
    visit(results, results.done_cells[0], 1)
    weights = results.store.cell_folder(results.done_cells[0]) / POLICY / WEIGHTS
    weights.unlink()
    assert len(load_transfers(results).matrices) == 1
    weights.write_bytes(b"another")
    assert load_transfers(results).matrices == ()


@pytest.mark.parametrize(
    "fields",
    [{"steps": 99}, {"evaluation_episodes": 3}, {"deterministic": False}, {"reward": Choice("arp", (), "arp")}],
)
def test_policies_that_share_less_have_a_matrix_of_their_own(make_cell, make_plan, tmp_path, fields):
    """Steps, episodes, the manner of evaluation and the reward are never mixed; the simulators are compared."""
    cells = [make_cell(), make_cell(simulator=AWAY), make_cell(**fields)]
    store = create_store(tmp_path / "mine", make_plan(*cells))
    for cell in cells:
        folder = store.cell_folder(cell)
        folder.mkdir(parents=True)
        write_evaluation(folder, 4)
        Manifest(cell, status="done").write(folder)
    results = load_results(store.folder)
    for cell in cells:
        visit(results, cell, 0, Choice("far", (), "far"))
    assert [len(matrix.trained_in) for matrix in load_transfers(results).matrices] == [2, 1]


def test_nothing_visited_is_no_matrix(train):
    """An experiment that nobody transferred has none."""
    transfers = load_transfers(train([4]))
    assert (transfers.matrices, transfers.failed) == ((), ())


def test_json_is_plain_and_by_label(train):
    """The keys that readers of other versions know, in their order."""
    results = train([4, 2])
    visit_all(results, [1, None])
    data = load_transfers(results).to_json()
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert list(data) == ["format", "combinations", "failed"]
    (combination,) = data["combinations"]
    assert list(combination) == [
        "algorithm", "reward", "robot", "task", "steps", "evaluation_episodes", "deterministic", "trained_in",
        "evaluated_in", "success", "return", "drop",
    ]  # fmt: skip
    assert set(combination["success"][0][1]) == {"value", "low", "high", "seeds", "note"}
    (failure,) = data["failed"]
    assert (failure["seed"], failure["trained_in"], failure["evaluated_in"]) == (1, "ideal", "stuck")


def test_a_drop_may_be_a_gain(train):
    """Its interval holds it; one training more may have lost 100 points, and five tell more than that."""
    drop = visit_all(train([0] * 5), [4] * 5).drop[0][1]
    assert drop.value == -1.0
    assert drop.low == -1.0
    assert -1.0 < drop.high < 1.0

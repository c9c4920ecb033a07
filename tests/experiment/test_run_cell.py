"""A cell from its start to its folder, in this process."""

from hashlib import sha256

import numpy as np
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_array_equal

from harness import load_robot
from harness.env.vector_env import build_world
from harness.executor import CellOptions
from harness.experiment.arm_evaluation import evaluate
from harness.experiment.run_cell import run_cell
from harness.policy import load_policy
from harness.record import EVALUATION, LOG, MANIFEST, POLICY, RANDOM, TRACE, partial_folder, read_manifest, read_trace
from harness.record.progress import RETURN, SUCCESS
from harness.record.trace import mean_return
from harness.registry import Choice, read_given
from harness.robot import robot
from tests.registry.test_given import REWARD

pytestmark = pytest.mark.usefixtures("toys")


def _run(cell, folder):
    return run_cell(cell, folder, lambda steps: None)


def _that(make_cell, then):
    return make_cell(algorithm=Choice("wander", (("then", then),), f"wander:then={then}"))


def test_done_cell_leaves_its_folder(make_cell, tmp_path):
    """Trace, policy, evaluation, random actions and the manifest: when, how long, what it ran on; nothing beside it."""
    manifest = _run(make_cell(), tmp_path / "cell")
    assert (manifest.status, manifest.reason, manifest.cell) == ("done", "", make_cell())
    assert read_manifest(tmp_path / "cell") == manifest
    assert 0.0 < manifest.training_seconds <= manifest.seconds
    assert set(manifest.environment["sources"]) == {"simulators", "tasks", "algorithms", "rewards", "robots"}
    left = {TRACE, POLICY, EVALUATION, "stochastic.parquet", RANDOM, "scene.json", MANIFEST}
    assert {path.name for path in (tmp_path / "cell").iterdir()} == left
    assert [path.name for path in tmp_path.iterdir()] == ["cell"]


def test_trace_has_every_step_of_training(make_cell, done):
    """As many rows as steps, and one more per episode."""
    trace = read_trace(done(make_cell()) / TRACE)
    assert np.count_nonzero(trace["step"]) == 12
    assert np.count_nonzero(trace["step"] == 0) == trace["episode"].max() + 1


def test_evaluations_have_one_finished_episode_per_env(make_cell, done):
    """The trained policy and random actions meet the same starts and targets; who ends early waits for the others."""
    easy = Choice("fd100-reach", (("horizon", 30), ("epsilon", 0.4)), "easy")
    folder = done(make_cell(evaluation_episodes=8, task=easy))
    trained, floor = (read_trace(folder / name) for name in (EVALUATION, RANDOM))
    for trace in (trained, floor):
        assert sorted(trace["env"][trace.last_rows]) == list(range(8))
        assert set(trace["episode"]) == {0}
    assert len(set(floor["step"][floor.last_rows])) > 1
    for name in ("qpos", "target_x"):
        assert_array_equal(*(trace[name][trace["step"] == 0] for trace in (trained, floor)))


def test_saved_policy_is_the_one_that_was_evaluated(make_cell, toys, done, tmp_path):
    """Loaded from the folder and evaluated again, it does the same, bit for bit."""
    policy = load_policy(done(make_cell()) / POLICY)
    world = build_world(make_cell(), load_robot("fd100"), toys)
    evaluate(world, lambda: policy.act, make_cell().evaluation_episodes, tmp_path / "again.parquet")
    assert pq.read_table(tmp_path / "again.parquet").equals(pq.read_table(done(make_cell()) / EVALUATION))


def test_same_cell_leaves_the_same_trace(make_cell, done, tmp_path):
    """Bit for bit, evaluation included; another seed leaves another."""
    _run(make_cell(), tmp_path / "one")
    for file in (TRACE, EVALUATION, RANDOM):
        assert pq.read_table(tmp_path / "one" / file).equals(pq.read_table(done(make_cell()) / file))
    assert not pq.read_table(tmp_path / "one" / TRACE).equals(pq.read_table(done(make_cell(seed=1)) / TRACE))


def test_equal_seeds_meet_equal_starts_under_any_reward(make_cell, done):
    """What a reward is compared on is the same for both."""
    cells = [make_cell(reward=Choice(name, (), name)) for name in ("baseline", "arp")]
    one, other = (read_trace(done(cell) / TRACE) for cell in cells)
    assert one["begin_distance"][one["step"] == 0].tolist() == other["begin_distance"][other["step"] == 0].tolist()


def test_progress_is_told(make_cell, tmp_path):
    """Where the training begins, then the steps done so far; the last word tells success and return of its episodes."""
    told = []
    run_cell(make_cell(steps=6), tmp_path / "cell", told.append)
    assert [word.steps for word in told] == [0, 1, 2, 3, 4, 5, 6, 6]
    trace = read_trace(tmp_path / "cell" / TRACE)
    assert told[-1].scalars[SUCCESS] == 0.0
    assert told[-1].scalars[RETURN] == pytest.approx(mean_return(trace))


def test_cell_that_raises_is_failed(make_cell, tmp_path):
    """The reason is one line with the kind of the error; the traceback is in the log, what was recorded is there."""
    manifest = _run(_that(make_cell, "raise"), tmp_path / "cell")
    assert (manifest.status, manifest.reason) == ("failed", "RuntimeError: the arm fell off")
    assert read_manifest(tmp_path / "cell") == manifest
    log = (tmp_path / "cell" / LOG).read_text()
    assert log.startswith("Traceback")
    assert "toy_arm.py" in log
    assert np.count_nonzero(read_trace(tmp_path / "cell" / TRACE)["step"]) == 12


def test_plugin_that_leaves_is_a_failed_cell(make_cell, tmp_path):
    """`sys.exit` in a plugin does not end the plan."""
    manifest = _run(_that(make_cell, "sys.exit"), tmp_path / "cell")
    assert (manifest.status, manifest.reason) == ("failed", "SystemExit: 0")


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"simulator": Choice("gone", (), "gone")}, "UsageError: No simulator 'gone'."),
        ({"reward": Choice("arp", (("k2", -1.0),), "arp")}, "UsageError: Reward 'arp': k2=-1.0"),
        ({"robot": "./nowhere"}, "UsageError: No robot at './nowhere'"),
    ],
    ids=["name", "parameter", "robot"],
)
def test_cell_that_cannot_be_built_is_failed(make_cell, tmp_path, fields, reason):
    """Where a plugin has gone or changed since the plan was made, the manifest says so."""
    manifest = _run(make_cell(**fields), tmp_path / "cell")
    assert manifest.status == "failed"
    assert manifest.reason.startswith(reason)


def test_interrupt_passes(make_cell, tmp_path):
    """KeyboardInterrupt is no failure of the cell: nothing gets the cell's name."""
    with pytest.raises(KeyboardInterrupt):
        _run(_that(make_cell, "interrupt"), tmp_path / "cell")
    assert not (tmp_path / "cell").exists()


def test_cell_is_done_again_over_what_was_left(make_cell, tmp_path):
    """A folder of an earlier failure and a partial folder of an earlier kill do not stand in the way."""
    _run(_that(make_cell, "raise"), tmp_path / "cell")
    partial = partial_folder(tmp_path / "cell")
    partial.mkdir()
    (partial / TRACE).write_bytes(b"half")
    (partial / POLICY).mkdir()
    assert _run(make_cell(), tmp_path / "cell").status == "done"
    assert read_manifest(tmp_path / "cell").status == "done"
    assert not partial.exists()


def test_robot_is_read_once(make_cell, toys, tmp_path, monkeypatch):
    """The training, its evaluations and the manifest share it: its files are parsed and checked once in a cell."""
    read, plain = [], robot.read_robot
    monkeypatch.setattr("harness.robot.robot.read_robot", lambda path, *rest: read.append(path) or plain(path, *rest))
    _run(make_cell(evaluate_every=6), tmp_path / "cell")
    assert len(read) == 1


def test_cell_is_taught_by_a_file_that_came_with_it(toys, make_cell, tmp_path):
    """Where the cell is done the file need not be; its SHA-256 is in the manifest."""
    path = tmp_path / "my_reward.py"
    path.write_text(REWARD)
    digest = sha256(path.read_bytes()).hexdigest()
    options = CellOptions(plugins=read_given([path]))
    path.unlink()
    cell = make_cell(reward=Choice("my_reward", (("scale", 1.0),), "my_reward"))
    manifest = run_cell(cell, tmp_path / "cell", lambda steps: None, options)
    assert (manifest.status, manifest.environment["sources"]["rewards"]) == ("done", digest)

"""Evaluations of a cell: when they are due, and that a training takes no notice of them."""

from functools import lru_cache

import numpy as np
import pyarrow.parquet as pq
import pytest

from harness.executor import CellOptions
from harness.experiment import arm_evaluation
from harness.experiment.run_cell import run_cell
from harness.policy import WEIGHTS
from harness.progress import RETURN, SPEED, SUCCESS
from harness.record import EVALUATION, LOG, MANIFEST, POLICY, RANDOM, TRACE, EpisodeFacts, read_manifest, read_trace
from harness.record.episode_facts import episode_facts
from harness.record.folder import DETERMINISTIC, EVALUATIONS, SCENE, STOCHASTIC, evaluation_files
from harness.registry import Choice
from harness.score.scorer import SCORED

pytestmark = pytest.mark.usefixtures("toys")
NARRATE = {"algorithm": Choice("narrate", (), "narrate")}
SPG = {"algorithm": Choice("spg", (("restart", 2), ("decisions", 10)), "spg"), "steps": 1920}
SAC_FAST = {"algorithm": Choice("sac-fast", (("learning_starts", 50), ("train_freq", 8)), "sac-fast"), "steps": 1920}
SAC = {"algorithm": Choice("sb3-sac", (), "sb3-sac"), "steps": 1200}
WATCHED = (
    "Environment/Cumulative Reward",
    "Environment/Episode Length",
    "Losses/Policy Loss",
    "Losses/Value Loss",
    "Policy/Entropy",
)


def _run(cell, folder, **options):
    assert run_cell(cell, folder, lambda steps: None, CellOptions(**options)).status == "done"
    return folder


def _told(cell, folder, **options):
    """What a cell tells: by name, (steps, value) in order."""
    words = []
    assert run_cell(cell, folder, words.append, CellOptions(**options)).status == "done"
    found = {}
    for word in words:
        for name, value in word.scalars.items():
            found.setdefault(name, []).append((word.steps, value))
    return found


def _require_equal_results(one, other):
    """Row by row, and weight by weight."""
    for name in (TRACE, EVALUATION, RANDOM):
        assert pq.read_table(one / name).equals(pq.read_table(other / name))
    assert (one / POLICY / WEIGHTS).read_bytes() == (other / POLICY / WEIGHTS).read_bytes()


def test_one_evaluation_at_the_end_is_the_default(make_cell, tmp_path):
    """A training that tells of its policy all the time leaves none before."""
    folder = _run(make_cell(**NARRATE), tmp_path / "cell")
    assert {path.name for path in folder.iterdir()} == {TRACE, POLICY, EVALUATION, STOCHASTIC, RANDOM, SCENE, MANIFEST}


@pytest.mark.parametrize(
    ("every", "num_envs", "steps", "due"),
    [(5, 1, 12, [5, 10]), (6, 1, 12, [6]), (4, 3, 12, [6, 9]), (1, 6, 12, [6]), (13, 1, 12, [])],
    ids=["multiples", "not at the end", "at or after", "several at once", "never"],
)
def test_an_evaluation_is_due_at_or_after_each_multiple(make_cell, tmp_path, every, num_envs, steps, due):
    """Once for each, at the first word of the training; the end has the evaluation that is always there."""
    algorithm = Choice("narrate", (("num_envs", num_envs),), "narrate")
    folder = _run(make_cell(algorithm=algorithm, steps=steps, evaluate_every=every), tmp_path / "cell")
    assert list(evaluation_files(folder)) == due


def test_an_evaluation_is_of_the_policy_as_it_was_then(make_cell, tmp_path):
    """It meets the starts and targets of the final one, and acts otherwise."""
    folder = _run(make_cell(**NARRATE, evaluate_every=5), tmp_path / "cell")
    traces = [read_trace(path) for path in (*evaluation_files(folder).values(), folder / EVALUATION)]
    first = [trace["action"][trace["step"] == 1] for trace in traces]
    np.testing.assert_allclose([action[0, 0] for action in first], np.tanh([5 / 12, 10 / 12, 1.0]), rtol=1e-6)
    for name in ("qpos", "target_x", "target_y", "target_z"):
        starts = [trace[name][trace["step"] == 0] for trace in traces]
        np.testing.assert_array_equal(starts[0], starts[2])


def test_an_evaluation_is_a_trace_like_the_final_one(make_cell, tmp_path):
    """The same columns, a finished episode of each env, and what a score needs."""
    folder = _run(make_cell(**NARRATE, evaluate_every=5), tmp_path / "cell")
    files = [folder / EVALUATIONS / "5.parquet", folder / EVALUATION]
    assert pq.read_schema(files[0]).equals(pq.read_schema(files[1]), check_metadata=True)
    assert len(read_trace(files[0], [*SCORED, "episode", "reward"]).episodes) == 2


@pytest.mark.parametrize(
    "fields",
    [NARRATE, SPG, pytest.param(SAC, marks=pytest.mark.slow)],
    ids=["toy", "spg", "sb3-sac"],
)
def test_evaluations_disturb_nothing(make_cell, tmp_path, fields):
    """The trace of the training and its policy are the same, bit for bit, with them and without."""
    every = max(make_cell(**fields).steps // 4, 1)
    often = _run(make_cell(**fields, evaluate_every=every), tmp_path / "often")
    assert len(evaluation_files(often)) == 3
    _require_equal_results(often, _run(make_cell(**fields), tmp_path / "once"))


def test_time_of_evaluations_is_no_time_of_training(make_cell, tmp_path, monkeypatch):
    """The manifest's seconds of training are without them."""
    import time

    import harness.experiment.arm_evaluation as module

    evaluate = module.evaluate
    monkeypatch.setattr(module, "evaluate", lambda *given, **more: (time.sleep(0.5), evaluate(*given, **more)))
    manifest = run_cell(make_cell(**NARRATE, evaluate_every=6), tmp_path / "cell", lambda steps: None)
    assert manifest.seconds > 2.0
    assert manifest.training_seconds < manifest.seconds - 1.9


def test_killed_cell_evaluates_nothing_twice(train_in_a_process, make_cell, tmp_path):
    """Evaluations before the checkpoint stay as they are; in the end there are those of a cell that nobody killed."""
    cell = make_cell(**SAC_FAST, evaluate_every=320)
    _run(cell, tmp_path / "whole", checkpoint_every=640)
    train_in_a_process(cell, tmp_path / "killed", every=640, until=1440)
    partial = next(tmp_path.glob(".killed*"))
    before = {steps: path.stat().st_mtime_ns for steps, path in evaluation_files(partial).items()}
    train_in_a_process(cell, tmp_path / "killed", every=640)
    begun = read_manifest(tmp_path / "killed").resumed_from
    kept = {steps: path.stat().st_mtime_ns for steps, path in evaluation_files(tmp_path / "killed").items()}
    assert begun == 1280
    assert {steps: when for steps, when in kept.items() if steps <= begun} == {
        steps: when for steps, when in before.items() if steps <= begun
    }
    whole, killed = (evaluation_files(tmp_path / name) for name in ("whole", "killed"))
    assert list(killed) == list(whole) == [320, 640, 960, 1280, 1600]
    assert all(path.read_bytes() == whole[steps].read_bytes() for steps, path in killed.items())
    _require_equal_results(tmp_path / "whole", tmp_path / "killed")


def test_stochastic_evaluation_is_reproducible(make_cell, tmp_path):
    """Draws of one evaluation depend on nothing that was drawn before, in another evaluation for one."""
    one = _run(make_cell(**NARRATE, deterministic=False), tmp_path / "one")
    other = _run(make_cell(**NARRATE, deterministic=False, evaluate_every=5), tmp_path / "other")
    _require_equal_results(one, other)


def test_stochastic_evaluation_draws(make_cell, tmp_path):
    """Only the evaluation is another one: the policy is the same."""
    drawn = _run(make_cell(**NARRATE, deterministic=False), tmp_path / "drawn")
    likeliest = _run(make_cell(**NARRATE), tmp_path / "likeliest")
    traces = [read_trace(folder / EVALUATION) for folder in (drawn, likeliest)]
    spread = [np.ptp(trace["action"][trace["step"] > 0], axis=0).max() for trace in traces]
    assert spread[0] > 0.1
    assert spread[1] == 0.0
    assert pq.read_table(drawn / TRACE).equals(pq.read_table(likeliest / TRACE))
    assert not pq.read_table(drawn / EVALUATION).equals(pq.read_table(likeliest / EVALUATION))


def test_cell_leaves_its_final_evaluation_in_the_other_manner(make_cell, tmp_path):
    """Row by row what the same training leaves whose evaluations are in that manner."""
    likeliest = _run(make_cell(**NARRATE), tmp_path / "likeliest")
    drawn = _run(make_cell(**NARRATE, deterministic=False), tmp_path / "drawn")
    for one, other in (
        (likeliest / STOCHASTIC, drawn / EVALUATION),
        (likeliest / EVALUATION, drawn / DETERMINISTIC),
    ):
        assert pq.read_table(one).equals(pq.read_table(other))
    assert not (likeliest / DETERMINISTIC).exists()
    assert not (drawn / STOCHASTIC).exists()


def test_evaluations_before_the_end_are_in_the_manner_of_the_cell_alone(make_cell, tmp_path):
    """The other manner is recorded once, at the end."""
    folder = _run(make_cell(**NARRATE, evaluate_every=5), tmp_path / "cell")
    assert sorted(path.name for path in (folder / EVALUATIONS).iterdir()) == ["10.parquet", "5.parquet"]


@pytest.mark.parametrize(
    ("deterministic", "episodes"),
    [(True, {EVALUATION: 1, STOCHASTIC: 3, RANDOM: 3}), (False, {EVALUATION: 3, DETERMINISTIC: 1, RANDOM: 3})],
)
def test_task_that_does_not_vary_has_one_deterministic_episode(make_cell, tmp_path, deterministic, episodes):
    """All of them would be alike; drawn actions differ."""
    task = Choice("arp-2021", (("horizon", 5),), "arp-2021:horizon=5")
    world = {"simulator": Choice("kinematic", (), "kinematic"), "robot": "unity-arm", "task": task}
    cell = make_cell(**NARRATE, **world, deterministic=deterministic, evaluation_episodes=3, evaluate_every=5)
    folder = _run(cell, tmp_path / "cell")
    assert {name: len(read_trace(folder / name).episodes) for name in episodes} == episodes
    before = {len(read_trace(path).episodes) for path in evaluation_files(folder).values()}
    assert before == {episodes[EVALUATION]}


def test_every_evaluation_tells_the_facts_of_its_episodes(make_cell, tmp_path):
    """Steps of the kinematics and work are there for each env, the former the same in all of them."""
    folder = _run(make_cell(**NARRATE, evaluate_every=5), tmp_path / "cell")
    paths = (*evaluation_files(folder).values(), folder / EVALUATION, folder / STOCHASTIC, folder / RANDOM)
    facts = [episode_facts(read_trace(path)) for path in paths]
    assert {(one.horizon, one.control_period, one.ik_steps) for one in facts} == {(5, 0.1, facts[0].ik_steps)}
    assert {(len(one.ik_steps), len(one.work)) for one in facts} == {(2, 2)}
    assert min(facts[-1].work) > 0.0


def test_kinematics_are_asked_once_in_a_cell(make_cell, tmp_path, monkeypatch):
    """However many evaluations there are."""
    asked = []

    def play(world, episodes, seed):
        asked.append(seed)
        return (None,) * episodes

    monkeypatch.setattr(arm_evaluation, "_play", play)
    monkeypatch.setattr(arm_evaluation, "_answer", lru_cache(arm_evaluation._answer.__wrapped__))
    _run(make_cell(**NARRATE, evaluate_every=5), tmp_path / "cell")
    assert len(asked) == 1


def test_training_tells_what_is_known_before_it(make_cell, tmp_path):
    """Horizon and control period; nothing of single episodes."""
    folder = _run(make_cell(**NARRATE), tmp_path / "cell")
    assert episode_facts(read_trace(folder / TRACE)) == EpisodeFacts(horizon=5, control_period=0.1)


def test_what_is_told_is_passed_on_when_asked_for(make_cell, tmp_path):
    """All that the training tells, under its names, and each evaluation, the final one included."""
    told = _told(make_cell(**NARRATE, evaluate_every=5), tmp_path / "cell", tracked=True)
    assert set(WATCHED) <= set(told)
    assert told["Policy/Entropy"] == [(steps, 1.5) for steps in range(1, 13)]
    assert [steps for steps, _ in told["Evaluation/Success Rate"]] == [5, 10, 12]
    assert [steps for steps, _ in told["Evaluation/Cumulative Reward"]] == [5, 10, 12]


def test_nothing_but_the_harness_s_own_numbers_is_passed_on_unasked(make_cell, tmp_path):
    """Where no tracker listens, no metric is computed for it."""
    assert set(_told(make_cell(**NARRATE), tmp_path / "cell")) <= {SUCCESS, RETURN, SPEED}


def test_what_is_told_changes_nothing(make_cell, tmp_path):
    """A cell that is tracked has the files and the results of one that is not."""
    tracked = _run(make_cell(**NARRATE), tmp_path / "tracked", tracked=True)
    alone = _run(make_cell(**NARRATE), tmp_path / "alone")
    _require_equal_results(tracked, alone)
    assert {path.name for path in tracked.iterdir()} == {path.name for path in alone.iterdir()}


def test_metric_that_raises_costs_no_cell(make_cell, tmp_path, monkeypatch):
    """What a tracker would show of an evaluation decides nothing: the error is in the log, the cell is done."""

    def fail(trace, registry):
        raise ZeroDivisionError("a metric")

    monkeypatch.setattr("harness.experiment.arm_world.evaluation_scalars", fail)
    folder = _run(make_cell(**NARRATE), tmp_path / "cell", tracked=True)
    assert "ZeroDivisionError: a metric" in (folder / LOG).read_text()


@pytest.mark.slow
def test_sac_tells_what_unity_tells(make_cell, tmp_path):
    """The names that users of Unity ML-Agents look for, and finite numbers."""
    told = _told(make_cell(**SAC), tmp_path / "cell", tracked=True)
    assert set(WATCHED) <= set(told)
    assert all(np.isfinite(value) for values in told.values() for _, value in values)

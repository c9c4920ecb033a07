"""Evaluations of a cell: when they are due, and that a training takes no notice of them."""

from functools import lru_cache

import numpy as np
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harness.executor import CellOptions
from harness.experiment import arm_evaluation
from harness.experiment.run_cell import run_cell
from harness.log import episode_facts
from harness.record import (
    EVALUATION,
    LOG,
    MANIFEST,
    POLICY,
    RANDOM,
    TRACE,
    EpisodeFacts,
    partial_folder,
    read_manifest,
    read_trace,
)
from harness.record.folder import WEIGHTS, evaluation_files
from harness.record.progress import RETURN, SPEED, SUCCESS
from harness.registry import Choice

pytestmark = pytest.mark.usefixtures("toys")
NARRATE = {"algorithm": Choice("narrate", (), "narrate")}
SPG = {"algorithm": Choice("spg", (("restart", 2), ("decisions", 10)), "spg"), "steps": 1920}
SAC_FAST = {"algorithm": Choice("sac-fast", (("learning_starts", 50), ("train_freq", 8)), "sac-fast"), "steps": 1920}
SAC = {"algorithm": Choice("sb3-sac", (), "sb3-sac"), "steps": 1200}
WATCHED = (
    "Losses/Policy Loss",
    "Losses/Value Loss",
    "Policy/Entropy",
)


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


def test_one_evaluation_at_the_end_is_the_default(make_cell, done):
    """A training that tells of its policy all the time leaves none before."""
    names = {path.name for path in done(make_cell(**NARRATE)).iterdir()}
    assert names == {TRACE, POLICY, EVALUATION, "stochastic.parquet", RANDOM, "scene.json", MANIFEST}


@pytest.mark.parametrize(
    ("every", "num_envs", "due"),
    [(5, 1, [5, 10]), (6, 1, [6]), (4, 3, [6, 9]), (1, 6, [6]), (13, 1, [])],
    ids=["multiples", "not at the end", "at or after", "several at once", "never"],
)
def test_an_evaluation_is_due_at_or_after_each_multiple(make_cell, done, every, num_envs, due):
    """Once for each, at the first word of the training; the end has the evaluation that is always there."""
    algorithm = Choice("narrate", (("num_envs", num_envs),), "narrate")
    assert list(evaluation_files(done(make_cell(algorithm=algorithm, evaluate_every=every)))) == due


@pytest.fixture
def often(make_cell, done):
    """A cell that is evaluated after 5, 10 and 12 steps."""
    return done(make_cell(**NARRATE, evaluate_every=5))


def test_an_evaluation_is_of_the_policy_as_it_was_then(often):
    """It meets the starts and targets of the final one, and acts otherwise."""
    traces = [read_trace(path) for path in (*evaluation_files(often).values(), often / EVALUATION)]
    first = [trace["action"][trace["step"] == 1] for trace in traces]
    assert_allclose([action[0, 0] for action in first], np.tanh([5 / 12, 10 / 12, 1.0]), rtol=1e-6)
    for name in ("qpos", "target_x", "target_y", "target_z"):
        starts = [trace[name][trace["step"] == 0] for trace in traces]
        assert_array_equal(starts[0], starts[2])


def test_an_evaluation_is_a_trace_like_the_final_one(often):
    """The same columns, a finished episode of each env, and what a score needs; in the manner of the cell alone."""
    assert sorted(path.name for path in (often / "evaluations").iterdir()) == ["10.parquet", "5.parquet"]
    early, final = often / "evaluations" / "5.parquet", often / EVALUATION
    one, other = map(pq.read_schema, (early, final))
    assert one.equals(other)
    assert one.metadata.keys() == other.metadata.keys() == {b"harness.trace", b"harness.facts"}
    assert len(read_trace(early).episodes) == 2


@pytest.mark.parametrize(
    "fields",
    [NARRATE, SPG, pytest.param(SAC, marks=pytest.mark.slow)],
    ids=["toy", "spg", "sb3-sac"],
)
def test_evaluations_disturb_nothing(make_cell, done, fields):
    """The trace of the training and its policy are the same, bit for bit, with them and without."""
    often = done(make_cell(**fields, evaluate_every=make_cell(**fields).steps // 4))
    assert len(evaluation_files(often)) == 3
    _require_equal_results(often, done(make_cell(**fields)))


def test_time_of_evaluations_is_no_time_of_training(make_cell, tmp_path, monkeypatch):
    """The manifest's seconds of training are without them."""
    import time

    import harness.experiment.arm_evaluation as module

    evaluate = module.evaluate
    monkeypatch.setattr(module, "evaluate", lambda *given, **more: (time.sleep(0.5), evaluate(*given, **more)))
    manifest = run_cell(make_cell(**NARRATE, evaluate_every=6), tmp_path / "cell", lambda steps: None)
    assert manifest.seconds > 2.0
    assert manifest.training_seconds < manifest.seconds - 1.9


def test_killed_cell_evaluates_nothing_twice(train_in_a_process, make_cell, done, tmp_path):
    """Evaluations before the checkpoint stay as they are; in the end there are those of a cell that nobody killed."""
    cell, killed = make_cell(**SAC_FAST, evaluate_every=320), tmp_path / "killed"
    whole = done(cell, checkpoint_every=640)
    train_in_a_process(cell, killed, every=640, until=1440)
    before = {path.name: path.stat().st_mtime_ns for path in evaluation_files(partial_folder(killed)).values()}
    train_in_a_process(cell, killed, every=640)
    assert read_manifest(killed).resumed_from == 1280
    found = evaluation_files(killed)
    assert list(found) == list(evaluation_files(whole)) == [320, 640, 960, 1280, 1600]
    for steps, path in found.items():
        assert path.read_bytes() == evaluation_files(whole)[steps].read_bytes()
        assert steps > 1280 or path.stat().st_mtime_ns == before[path.name]
    _require_equal_results(whole, killed)


@pytest.fixture
def drawn(make_cell, done):
    """The same cell, evaluated by drawn actions."""
    return done(make_cell(**NARRATE, deterministic=False))


def test_stochastic_evaluation_is_reproducible(make_cell, done, drawn):
    """Draws of one evaluation depend on nothing that was drawn before, in another evaluation for one."""
    _require_equal_results(drawn, done(make_cell(**NARRATE, deterministic=False, evaluate_every=5)))


def test_stochastic_evaluation_draws(make_cell, done, drawn):
    """Only the evaluation is another one: the policy is the same. Each cell leaves the other's manner too."""
    likeliest = done(make_cell(**NARRATE))
    traces = [read_trace(folder / EVALUATION) for folder in (drawn, likeliest)]
    spread = [np.ptp(trace["action"][trace["step"] > 0], axis=0).max() for trace in traces]
    assert spread[0] > 0.1
    assert spread[1] == 0.0
    pairs = [(TRACE, TRACE), ("stochastic.parquet", EVALUATION), (EVALUATION, "deterministic.parquet")]
    assert all(pq.read_table(likeliest / one).equals(pq.read_table(drawn / other)) for one, other in pairs)
    assert not (likeliest / "deterministic.parquet").exists()
    assert not (drawn / "stochastic.parquet").exists()


@pytest.mark.parametrize(
    ("deterministic", "episodes"),
    [
        (True, {EVALUATION: 1, "stochastic.parquet": 3, RANDOM: 3}),
        (False, {EVALUATION: 3, "deterministic.parquet": 1, RANDOM: 3}),
    ],
)
def test_task_that_does_not_vary_has_one_deterministic_episode(make_cell, done, deterministic, episodes):
    """All of them would be alike; drawn actions differ."""
    task = Choice("arp-2021", (("horizon", 5),), "arp-2021:horizon=5")
    world = {"simulator": Choice("kinematic", (), "kinematic"), "robot": "unity-arm", "task": task}
    folder = done(make_cell(**NARRATE, **world, deterministic=deterministic, evaluation_episodes=3, evaluate_every=5))
    assert {name: len(read_trace(folder / name).episodes) for name in episodes} == episodes
    assert {len(read_trace(path).episodes) for path in evaluation_files(folder).values()} == {episodes[EVALUATION]}


def test_every_evaluation_tells_the_facts_of_its_episodes(often):
    """Steps of the kinematics and work are there for each env, the former the same in all of them."""
    paths = (*evaluation_files(often).values(), *(often / name for name in (EVALUATION, "stochastic.parquet", RANDOM)))
    facts = [episode_facts(read_trace(path)) for path in paths]
    assert {(one.horizon, one.control_period, one.ik_steps) for one in facts} == {(5, 0.1, facts[0].ik_steps)}
    assert {(len(one.ik_steps), len(one.work)) for one in facts} == {(2, 2)}
    assert min(facts[-1].work) > 0.0
    assert episode_facts(read_trace(often / TRACE)) == EpisodeFacts(horizon=5, control_period=0.1)  # before it trains


def test_kinematics_are_asked_once_in_a_cell(make_cell, tmp_path, monkeypatch):
    """However many evaluations there are."""
    asked = []

    def play(world, episodes, seed):
        asked.append(seed)
        return (None,) * episodes

    monkeypatch.setattr(arm_evaluation, "_play", play)
    monkeypatch.setattr(arm_evaluation, "_answer", lru_cache(arm_evaluation._answer.__wrapped__))
    run_cell(make_cell(**NARRATE, evaluate_every=5), tmp_path / "cell", lambda word: None)
    assert len(asked) == 1


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


def test_what_is_told_changes_nothing(make_cell, done):
    """A cell that is tracked has the files and the results of one that is not."""
    tracked, alone = done(make_cell(**NARRATE), tracked=True), done(make_cell(**NARRATE))
    _require_equal_results(tracked, alone)
    assert {path.name for path in tracked.iterdir()} == {path.name for path in alone.iterdir()}


def test_metric_that_raises_costs_no_cell(make_cell, tmp_path, monkeypatch):
    """What a tracker would show of an evaluation decides nothing: the error is in the log, the cell is done."""

    def fail(trace, registry):
        raise ZeroDivisionError("a metric")

    monkeypatch.setattr("harness.experiment.arm_world.evaluation_scalars", fail)
    assert _told(make_cell(**NARRATE), tmp_path / "cell", tracked=True)
    assert "ZeroDivisionError: a metric" in (tmp_path / "cell" / LOG).read_text()


@pytest.mark.slow
def test_sac_tells_what_unity_tells(make_cell, tmp_path):
    """The names that users of Unity ML-Agents look for, and finite numbers."""
    told = _told(make_cell(**SAC), tmp_path / "cell", tracked=True)
    assert set(WATCHED) <= set(told)
    assert all(np.isfinite(value) for values in told.values() for _, value in values)

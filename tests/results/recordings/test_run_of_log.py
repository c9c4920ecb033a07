"""Runs and episodes of logs that nobody here has recorded."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.errors import SchemaError, Unscored, UsageError
from harness.log import Failed, Log, LogFacts, in_memory
from harness.results.recordings.episodes import episodes_of, require_ends
from harness.results.recordings.runs import run_of


def _episodes(reward, seed, returns, **facts):
    """A log of episodes of ten steps each, as a Monitor writes it."""
    told = {"path": Path(f"{reward}-{seed}"), "format": "Monitor", "unit": "episode", **facts}
    columns = {
        "reward/recorded": np.array(returns),
        "behaviour/success": (np.array(returns) > 0.0).astype(float),
        "length": np.full(len(returns), 10.0),
        "time": 10.0 * np.arange(1, len(returns) + 1),
    }
    return in_memory(LogFacts(trained_with=reward, seed=seed, **told), columns)


def test_episodes_are_rows_of_a_log_of_episodes():
    """Each ended in the step before its time."""
    found = episodes_of(_episodes("base", 0, [1.0, -2.0, 3.0]))
    assert found.last.tolist() == [9, 19, 29]
    assert found.returns["recorded"].tolist() == [1.0, -2.0, 3.0]
    assert found.behaviour["success"].tolist() == [1.0, 0.0, 1.0]


def _steps(rows, **more):
    """Steps of three envs in turns, whose episodes have three, four and five steps."""
    tick, env = np.divmod(np.arange(rows), 3)
    columns = {
        "env": env,
        "episode": tick // (3 + env),
        "reward/own": np.random.default_rng(0).normal(size=rows),
        "behaviour/place": np.arange(rows) * 0.5,
        "terminated": (tick % (3 + env) == 2 + env) & (env < 2),
        "truncated": (tick % (3 + env) == 2 + env) & (env == 2),
    }
    return in_memory(LogFacts(path=Path("some"), format="of a test"), {**columns, **more})


@pytest.mark.parametrize("rows", [1, 2, 7, 1_000])
def test_episodes_of_steps_do_not_depend_on_pieces(rows, monkeypatch):
    """To the last bit: what an episode was paid in one piece goes on in the next."""
    log = _steps(200)
    pieces = Log.pieces
    monkeypatch.setattr(Log, "pieces", lambda self, columns: pieces(self, columns, rows))
    found = episodes_of(log)
    ended = np.flatnonzero(log["terminated"] | log["truncated"])
    assert found.last.tolist() == ended.tolist()
    for at, paid, place in zip(ended, found.returns["own"], found.behaviour["place"], strict=True):
        of = (log["env"] == log["env"][at]) & (log["episode"] == log["episode"][at])
        assert paid == np.cumsum(log["reward/own"][of])[-1]
        assert place == at * 0.5


def test_start_rows_are_no_steps():
    """They are paid nothing, whatever stands there, and are not counted."""
    start = np.arange(12) % 4 == 0
    columns = {
        "episode": np.arange(12) // 4,
        "start": start,
        "reward/own": np.where(start, np.nan, 1.0),
        "terminated": np.arange(12) % 4 == 3,
    }
    found = episodes_of(in_memory(LogFacts(path=Path("some"), format="of a test"), columns))
    assert (found.last.tolist(), found.returns["own"].tolist()) == ([2, 5, 8], [3.0, 3.0, 3.0])


def test_log_without_ends_is_refused():
    """Nobody knows then which steps are one episode; and none is told."""
    log = in_memory(LogFacts(path=Path("some"), format="of a test"), {"reward/own": np.zeros(3)})
    with pytest.raises(UsageError, match="'some' does not tell where episodes end"):
        require_ends(log)
    assert len(episodes_of(log).last) == 0


def test_last_episode_may_go_on_where_nothing_tells_its_end():
    """Of each env; every one before it has ended, because another followed."""
    columns = {"env": [0, 1, 0, 0, 1], "episode": [0, 0, 0, 1, 1], "reward/a": [1.0, 8.0, 2.0, 4.0, 16.0]}
    log = in_memory(LogFacts(path=Path("some"), format="of a test"), {k: np.array(v) for k, v in columns.items()})
    found = episodes_of(log)
    assert (found.last.tolist(), found.returns["a"].tolist()) == ([1, 2], [8.0, 3.0])


def test_episodes_without_a_time_are_counted_and_out_of_order_refused():
    """A curve over steps would be drawn of these otherwise."""
    log = _episodes("base", 0, [1.0, 2.0])
    assert episodes_of(log.renamed({"time": "seconds"})).last.tolist() == [0, 1]
    with pytest.raises(SchemaError, match="do not stand in the order of time"):
        episodes_of(log.add({"time": np.array([20.0, 10.0])}))


def test_what_a_log_calls_recorded_is_what_trained_it():
    """Only that reward is known; it says why there is no pay of steps, and what was given up."""
    failed = (Failed("reward/recorded", "it was NaN"),)
    run = run_of(_episodes("base", 4, [1.0, 2.0], failed=failed), 4, 20)
    assert (run.reward, run.seed, run.steps, run.facts.rewards) == ("base", 4, 20, ("base",))
    assert run.episodes.reasons == {"reward/base": "given up: it was NaN"}
    assert run.parts(20)["over the training"].returns == {"base": 1.5}
    with pytest.raises(Unscored, match="'base-4' tells episodes, and not what was paid for each step"):
        run.recorded.paid_by("base")
    assert run.recorded.terms_paid("base").terms == {}


def test_run_of_steps_tells_pay_and_terms():
    """As a recording does."""
    log = _steps(60, **{"reward/own/half": np.arange(60) / 2})
    run = run_of(replace(log, facts=replace(log.facts, trained_with="own")), 4)
    assert (run.seed, run.steps) == (4, 60)
    assert run.recorded.paid_by("own").tolist() == log["reward/own"].tolist()
    assert run.recorded.terms_paid("own").steps == 60
    assert [*run.recorded.terms_paid("own").terms] == ["half"]

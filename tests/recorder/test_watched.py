"""A recording that is watched has a process beside it, which ends with it."""

import subprocess
import sys

import gymnasium
import pytest

from harness import RecordRewards, RecordVectorRewards
from harness.recorder import recorder, watched


@pytest.fixture
def started(monkeypatch):
    """The processes that were started."""
    processes = []

    def start(folder):
        processes.append(watched.start_watching(folder))
        return processes[-1]

    monkeypatch.setattr(recorder, "start_watching", start)
    return processes


def record(folder, **more):
    """CartPole, recorded."""
    env = gymnasium.make("CartPole-v1")
    return RecordRewards(env, folder, trained_with="own", rewards={}, **more)


def test_page_ends_when_the_recording_is_closed(tmp_path, started):
    """The process is gone after close, and not before."""
    env = record(tmp_path, watch=True)
    assert started[0].poll() is None
    env.close()
    assert started[0].poll() is not None


def test_nothing_is_started_unless_it_is_asked_for(tmp_path, started):
    """Nor by another env of the same training."""
    record(tmp_path / "a").close()
    record(tmp_path / "b", watch=True, number=1).close()
    assert started == []


def test_batch_is_watched_too(tmp_path, started):
    """`RecordVectorRewards` starts one page."""
    envs = gymnasium.make_vec("CartPole-v1", num_envs=2, vectorization_mode="sync")
    RecordVectorRewards(envs, tmp_path, trained_with="own", rewards={}, watch=True).close()
    assert len(started) == 1


def test_page_ends_with_a_process_that_is_killed():
    """The end of its standard input ends it, as when whoever holds the other end is killed."""
    page = subprocess.Popen([sys.executable, "-c", watched.CHILD, "--version"], stdin=subprocess.DEVNULL)
    assert page.wait(timeout=60) == 0


def test_page_says_its_address_before_the_first_step(tmp_path, capfd):
    """In one line, however short the training is."""
    env = record(tmp_path, watch=True)
    told = capfd.readouterr().err
    env.close()
    assert told.count("\n") == 1
    assert "http://127.0.0.1:" in told

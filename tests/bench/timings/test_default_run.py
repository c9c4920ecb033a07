"""The default run: does it learn, and how long does it take?"""

import statistics

import pytest

import harness
from harness.env.single_env import ReachEnv
from harness.eta.behaviour_change import Change
from harness.results import Results
from harness_plugins.algorithms.sac import Sac

pytestmark = pytest.mark.bench
CELLS, STEPS, PIECE, PIECES = 12, 5_000, 1_000, 3


def success_of(results: Results) -> Change:
    """Of the one comparison."""
    success = results.combinations[0].decisive
    assert success is not None
    assert success.name == "success_rate"
    return success


def test_the_default_run_learns_in_less_time_than_its_bare_trainings(tmp_path, seconds, is_timed):
    """Success is at least 0.6 under baseline and ARP, below 0.1 at random, and two cores do it all sooner than one.

    The one core does the same trainings, one after the other, by bare stable-baselines3, without an evaluation. Of
    these a piece is timed, before the run and after it.
    """
    if not is_timed:  # sac starts slowly
        results = harness.run(
            sim="mujoco", algo="random", steps=5, seeds=1, evaluation_episodes=1, out=tmp_path / "run"
        )
        assert not results.failed
        assert success_of(results).random is not None
        return

    def bare() -> list[float]:
        return [seconds(Sac().bare_training(ReachEnv(), PIECE, 0)) for _ in range(PIECES)]

    runs = []
    before = bare()
    took = seconds(lambda: runs.append(harness.run(sim="mujoco", algo="sac", out=tmp_path / "run")))
    piece = statistics.median(before + bare())
    success = success_of(runs[0])
    ratio = CELLS * STEPS / PIECE * piece / took
    print(f"\n  success {success}; speed ratio {ratio:.3f}, at least 1 (run {took:.0f} s)")  # noqa: T201
    assert not runs[0].failed
    assert (success.baseline or 0.0) >= 0.6
    assert (success.proposed or 0.0) >= 0.6
    assert success.random is not None
    assert success.random < 0.1
    assert ratio >= 1.0

"""Targets that do not end the episode: a bonus on entering, then the next target."""

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.testing import assert_allclose, assert_array_equal

from harness.record.cell_log import cell_log
from harness.robot import reach_position
from harness.task import Targets
from harness_plugins.kit.trainings import NegativeDistance
from harness_plugins.tasks.unity import Arp2021, UnityReach
from tests.env.conftest import CountsSteps
from tests.registered import UNITY_ARM as ARM

PLACES = np.array([[0.45, -0.45, 0.2], [0.3, -0.5, 0.3], [0.5, -0.3, 0.5]])


class Tour(UnityReach):
    """From the home pose to one place after the other."""

    def draw_start(self, robot, rng):
        """Home."""
        return robot.home

    def draw_targets(self, robot, rng, count):
        """The places in order."""
        return Targets(PLACES[np.arange(count) % len(PLACES)], np.zeros(count, bool))


def action_at(position):
    """The action that jumps to a position, (1, 5)."""
    goal, reached = reach_position(ARM, np.atleast_2d(position), ARM.home[None], tolerance=1e-6)
    assert reached.all()
    return (goal / ARM.upper).astype(np.float32)


HOME = (ARM.home / ARM.upper).astype(np.float32)[None]
FIRST, SECOND, THIRD = (action_at(place) for place in PLACES)


@pytest.fixture
def tour(make, recorded):
    """Jump through some actions: what the steps return, and the trace."""

    def go(*actions, task=None, **options):
        taken = []
        env = make(1, task or Tour(decision_period=1), robot=ARM, **options)
        return taken, recorded(env, lambda env: taken.extend(map(env.step, actions)))

    return go


def test_bonus_is_paid_once_on_entering(tour):
    """In the step that enters the target, and in none that stays in it."""
    _, trace = tour(HOME, FIRST, FIRST, FIRST, HOME, FIRST, task=Arp2021(decision_period=1))
    assert_array_equal(trace["reached"], [False, False, True, False, False, False, True])
    assert_array_equal(trace["reward_target"] > 0.0, trace["reached"])


def test_next_target_that_one_is_in_has_to_be_left(tour):
    """A fixed target is set again where the end effector is: it is touched again on entering it again."""
    taken, _ = tour(FIRST, FIRST, HOME, HOME, FIRST, task=Arp2021(decision_period=1))
    assert [bool(infos["is_success"][0]) for *_, infos in taken] == [True, False, False, False, True]


def test_bonus_is_paid_once_in_a_decision(tour):
    """Of five steps in the target the first one is paid."""
    taken, trace = tour(FIRST, task=Arp2021())
    assert trace["reached"].sum() == 1
    assert_allclose(taken[0][1][0], np.sum([trace[f"reward{n}"] for n in ("", "_target", "_step")]))


def test_episode_goes_on(tour):
    """A touched target is no end, and opens no episode: steps are counted on without a start row."""
    taken, trace = tour(FIRST, SECOND, THIRD, HOME)
    assert not any(terminated[0] or truncated[0] for _, _, terminated, truncated, _ in taken)
    assert_array_equal(trace["step"], range(5))
    assert_array_equal(trace["reached"], [False, True, True, True, False])
    assert len(trace.last_rows) == 0


def test_next_target_is_seen_at_once(tour):
    """The step that touches a target tells the distance to it, and shows the next one."""
    taken, _ = tour(FIRST)
    observations, *_, infos = taken[0]
    assert infos["distance"][0] < 1e-5
    assert observations[0, 17] == pytest.approx(norm(PLACES[0] - PLACES[1]), abs=1e-5)


def test_distances_restart_with_the_next_target(tour):
    """Bd and Pb are the distance to the new target from where the old one was touched, in the very next row."""
    _, trace = tour(HOME, FIRST, HOME, SECOND, HOME)
    target = np.stack([trace[f"target_{axis}"] for axis in "xyz"], axis=1)
    tip = np.stack([trace[f"end_effector_{axis}"] for axis in "xyz"], axis=1)
    assert_array_equal(target, PLACES[[0, 0, 0, 1, 1, 2]])
    begin = norm(PLACES - tip[[0, 2, 4]], axis=1)
    assert_allclose(trace["begin_distance"], begin[[0, 0, 0, 1, 1, 2]], rtol=1e-12)
    assert_array_equal(trace["previous_best"][[3, 5]], trace["begin_distance"][[3, 5]])
    assert_array_equal(trace["delta_distance"], trace["distance"] - trace["previous_best"])


def test_previous_distance_restarts_with_the_next_target(tour):
    """A reward sees the begin distance of the new target, not the distance to the old one."""

    class Shows(NegativeDistance):
        def __call__(self, carry, sample):
            return carry, sample.previous_distance.copy()

    _, trace = tour(HOME, FIRST, HOME, HOME, reward=Shows())
    begin, distance = trace["begin_distance"], trace["distance"]
    assert_array_equal(trace["reward"][1:], [begin[0], distance[1], begin[3], distance[3]])


def test_carry_restarts_with_the_next_target(tour):
    """What a reward remembers belongs to the target; the step number to the episode."""
    _, trace = tour(HOME, FIRST, HOME, HOME, SECOND, HOME, reward=CountsSteps())
    assert_array_equal(trace["reward"], [0.0, 1.0, 2.0, 1.0, 2.0, 3.0, 1.0])


def test_carry_of_the_other_envs_goes_on(make):
    """One arm's touched target is nothing to another."""
    env = make(2, Tour(decision_period=1), robot=ARM, reward=CountsSteps(), seed=0)
    env.step(np.concatenate([FIRST, HOME]))
    assert_array_equal(env.step(np.concatenate([HOME, HOME]))[4]["reward_shaped"], [1.0, 2.0])


def test_target_at_the_horizon_is_paid_and_truncates(tour):
    """It does not end the episode, the horizon does: both are told, and no other target is drawn for it."""
    taken, trace = tour(HOME, FIRST, FIRST, task=Tour(decision_period=1, horizon=2))
    assert trace["reached"][2]
    assert trace["truncated"][2]
    assert not trace["terminated"].any()
    assert taken[1][1][0] > 0.4
    assert_array_equal(trace["step"], [0, 1, 2, 0, 1])
    assert_array_equal(trace["target_x"][3:], PLACES[1, 0])


def test_touched_target_in_a_recording_is_no_start(tour, tmp_path):
    """A recording of arp-2021 has one start row an episode, as the published files: Bd changes inside."""
    tour(*[HOME, FIRST] * 4, task=Arp2021(decision_period=1, horizon=6))
    log = cell_log(tmp_path / "trace.parquet")
    assert_array_equal(np.flatnonzero(log["step"] == 0), [0, 7])
    assert log["reward/recorded"][0] == log["reward/recorded"][7] == 0.0
    assert len(np.unique(log["begin_distance"][:7])) == 2
    assert_array_equal(log["step"], [0, 1, 2, 3, 4, 5, 6, 0, 1, 2])
    touched = log["reached"] & ~(log["terminated"] | log["truncated"])
    assert_array_equal(np.flatnonzero(touched), [2, 4, 9])

"""Decisions of several environment steps under one action."""

from typing import ClassVar

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.env.ideal import IdealSimulation
from harness.record import TraceWriter, read_trace
from harness.robot import reach_position
from harness.score.scorer import pay_log
from harness.task import ReachTask

PERIOD = 5


class InFives(ReachTask):
    """A decision every five environment steps."""

    decision_period: ClassVar[int] = PERIOD


class GoingOn(InFives):
    """The same, where a touched target is followed by the next."""

    ends_at_target: ClassVar[bool] = False


class Remembers:
    """A reward that pays what it paid before, half of it, and the distance."""

    def initial_carry(self, begin_distance):
        """What the episode began with."""
        return (begin_distance,)

    def __call__(self, carry, sample):
        """Of a step."""
        value = 0.5 * carry[0] + sample.distance
        return (value,), value


OFTEN = {"epsilon": 0.35, "horizon": 23}
"""Episodes end at the target, and at the horizon within a decision."""


def play(env, decisions, columns=slice(None)):
    """Decisions at random; `columns`, of eight envs, are those of the env."""
    actions = default_rng(0).uniform(-1.0, 1.0, (decisions, 8, 6)).astype(np.float32)
    return [env.step(action[columns]) for action in actions]


def record(make, path, columns, task, decisions=60):
    """What envs of these numbers return and record, as one batch."""
    env = make(len(columns), task, reward=Remembers())
    with TraceWriter(path, 6, 6) as recorder:
        env.recorder = recorder
        start = env.reset(seed=[[3, k] for k in columns])
        env.step(np.zeros((len(columns), 6), np.float32))
        env.reset(options={"reset_mask": np.array(columns) % 2 == 1})  # from now on they end at different times
        taken = play(env, decisions, columns)
    return (start, taken), read_trace(path)


def test_decision_is_its_environment_steps(make):
    """It returns what five steps under its action return in the end, and the sum of their rewards, bit for bit."""
    fives, ones = make(8, InFives(epsilon=0.001)), make(8, ReachTask(epsilon=0.001))
    for env in (fives, ones):
        env.reset(seed=0)
    rng = default_rng(0)
    for _ in range(6):
        action = rng.uniform(-0.3, 0.3, (8, 6)).astype(np.float32)
        steps = [ones.step(action) for _ in range(PERIOD)]
        observations, rewards, terminated, truncated, infos = fives.step(action)
        assert not (terminated | truncated).any()
        assert_array_equal(observations, steps[-1][0])
        assert_array_equal(rewards, sum(step[1] for step in steps))
        assert_array_equal(infos["distance"], steps[-1][4]["distance"])
        assert_array_equal(infos["reward_shaped"], sum(step[4]["reward_shaped"] for step in steps))


def test_one_row_per_environment_step(make, tmp_path):
    """Five rows a decision with its action; their terms add up to what it paid."""
    (_, taken), trace = record(make, tmp_path / "trace.parquet", [0], InFives(horizon=100), decisions=3)
    assert_array_equal(trace["step"], range(4 * PERIOD + 1))
    actions = trace["action"][1:].reshape(4, PERIOD, 6)
    assert_array_equal(actions, np.repeat(actions[:, :1], PERIOD, axis=1))
    terms = trace["reward"] + trace["reward_ground"] + trace["reward_target"] + trace["reward_step"]
    assert_allclose(terms[1:].reshape(4, PERIOD).sum(axis=1)[1:], [step[1][0] for step in taken], rtol=1e-12)


def test_horizon_counts_environment_steps(make, stand):
    """A horizon of 7 is in the second decision, which lasts two steps."""
    env = make(2, InFives(horizon=7), seed=2)
    assert not stand(env)[3].any()
    _, rewards, _, truncated, infos = stand(env)
    assert truncated.all()
    assert_allclose(rewards, 2.0 * (-infos["distance"] - 0.0001), rtol=1e-12)
    assert env.environment_steps == 14


def test_environment_steps_are_counted_where_they_are_taken(make, recorded):
    """Each env counts its own: as many as rows were recorded, start rows apart."""
    env = make(8, InFives(**OFTEN))
    steps = np.count_nonzero(recorded(env, lambda env: play(env, 60), seed=3)["step"])
    assert env.environment_steps == steps < 60 * PERIOD * 8


def test_episode_that_ends_in_a_decision_stops_there(make, tmp_path):
    """What is told of it is told of its end: the last row that was recorded of it."""
    (_, taken), trace = record(make, tmp_path / "trace.parquet", list(range(8)), InFives(**OFTEN))
    ends = {k: iter(trace.last_rows[trace["env"][trace.last_rows] == k]) for k in range(8)}
    within, kinds = 0, set()
    for _, _, terminated, truncated, infos in taken:
        for k in np.flatnonzero(terminated | truncated):
            row = next(ends[k])
            assert (trace["terminated"][row], trace["truncated"][row]) == (terminated[k], truncated[k])
            assert infos["distance"][k] == trace["distance"][row]
            assert infos["is_success"][k] == trace["reached"][row]
            assert infos["final_obs"][k, -1] == np.float32(trace["distance"][row])
            within += trace["step"][row] % PERIOD != 0
            kinds.add(bool(terminated[k]))
    assert within > 10
    assert kinds == {True, False}
    assert all(next(rest, None) is None for rest in ends.values())


@pytest.mark.parametrize("task", [InFives(**OFTEN), GoingOn(epsilon=0.35, horizon=8)], ids=["ends", "goes on"])
def test_env_of_a_batch_is_as_one_alone(make, tmp_path, task):
    """Though the others' episodes end at other times within a decision: what it returns and records, bit for bit."""
    (start, together), trace = record(make, tmp_path / "batch.parquet", list(range(8)), task)
    for k in range(8):
        (own_start, alone), own_trace = record(make, tmp_path / f"{k}.parquet", [k], task)
        assert_array_equal(own_start[0][0], start[0][k])
        for one, many in zip(alone, together, strict=True):
            for mine, theirs in zip(one[:4], many[:4], strict=True):
                assert_array_equal(mine[0], theirs[k])
            for name, values in one[4].items():
                assert_array_equal(values[0], many[4][name][k], err_msg=name)
        rows = trace["env"] == k
        for name, column in own_trace.rows().columns.items():
            if name != "env":
                assert_array_equal(column, trace[name][rows], err_msg=name)


class Bumps(IdealSimulation):
    """Env 0 touches the ground for a moment, in the period of this number."""

    period, driven = 0, 0

    def drive(self, qpos, duration):
        """As any drive, but for the touch."""
        state = super().drive(qpos, duration)
        self.driven += 1
        state.ground_contact[0] |= self.driven == self.period
        return state


def test_target_that_is_reached_after_the_end_is_not_taken(make):
    """What an arm touches while the others finish their decision draws nothing from its stream."""
    action, ahead = straight_to_the_target(make)
    starts = []
    for num_envs in (1, 2):
        env = make(num_envs, GoingOn(epsilon=0.1))
        env.simulation = Bumps(env.robot, num_envs)
        env.simulation.period = ahead
        env.reset(seed=3)
        for _ in range(ahead // PERIOD):
            assert not env.step(np.repeat(action, num_envs, axis=0))[2].any()
        observations, _, terminated, *_ = env.step(np.repeat(action, num_envs, axis=0))
        assert_array_equal(terminated, np.arange(num_envs) == 0)
        starts.append(observations[0])
    assert_array_equal(*starts)


def straight_to_the_target(make):
    """An action of env 0 that leads to its target, and the steps before, such that a decision is under way then."""
    env = make(1, ReachTask(epsilon=0.1))
    for share in np.linspace(0.05, 0.6, 60):
        env.reset(seed=3)
        goal, _ = reach_position(env.robot, env.episodes.target, env.simulation.read().qpos)
        way = goal - env.simulation.read().qpos
        action = (share * way / np.abs(way).max()).astype(np.float32)
        steps = next(step for step in range(1, 101) if env.step(action)[2][0])
        if 1 <= (steps - 1) % PERIOD <= PERIOD - 1 and steps > PERIOD:
            return action, steps - 1
    raise AssertionError("no such action")


def test_disabled_leaves_an_episode_as_it_ended(make):
    """Without autoreset the observation is that of the end, and the other env's decision is done to its end."""
    modes = (AutoresetMode.SAME_STEP, AutoresetMode.DISABLED)
    same, disabled = (make(8, InFives(**OFTEN), autoreset_mode=mode) for mode in modes)
    for env in (same, disabled):
        env.reset(seed=3)
    ended = np.zeros(8, bool)
    for one, other in zip(play(same, 5), play(disabled, 5), strict=True):
        now = (other[2] | other[3]) & ~ended
        assert_array_equal(other[0][now], one[4].get("final_obs", one[0])[now])
        going = ~(now | ended)
        assert_array_equal(other[0][going], one[0][going])
        assert_array_equal(other[1][~ended], one[1][~ended])
        ended |= now
    assert ended.all()


def test_memory_of_an_ended_episode_stands_still(make, recorded):
    """Stepped on without autoreset it goes on from its end: its rows are scored as they were paid, bit for bit."""
    env = make(8, InFives(**OFTEN), reward=Remembers(), autoreset_mode=AutoresetMode.DISABLED)
    trace = recorded(env, lambda env: play(env, 12), seed=3)
    assert len(trace.last_rows) > 20
    assert_array_equal(pay_log(Remembers(), trace).total, trace["reward"])


def test_both_autoreset_modes_tell_the_same_story(make):
    """Resetting what has ended by its mask gives the episodes that autoreset gives."""
    same = make(8, InFives(**OFTEN), reward=Remembers())
    disabled = make(8, InFives(**OFTEN), reward=Remembers(), autoreset_mode=AutoresetMode.DISABLED)
    assert_array_equal(same.reset(seed=5)[0], disabled.reset(seed=5)[0])
    rng = default_rng(1)
    for _ in range(40):
        actions = rng.uniform(-1.0, 1.0, (8, 6)).astype(np.float32)
        expected, paid, *_ = same.step(actions)
        observations, rewards, terminated, truncated, _ = disabled.step(actions)
        assert_array_equal(rewards, paid)
        ended = terminated | truncated
        if ended.any():
            observations, _ = disabled.reset(options={"reset_mask": ended})
        assert_array_equal(observations, expected)

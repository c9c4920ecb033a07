"""What the env leaves in a trace."""

import numpy as np
from numpy.linalg import norm
from numpy.testing import assert_allclose, assert_array_equal

from harness.task import ReachTask
from tests.registered import FD100 as ROBOT


def test_recorded_terms_add_up_to_what_was_paid(recorded, make, wander):
    """Shaped reward and event terms are columns of their own; their sum is what the learner was paid, in order."""
    taken = []
    env = make(3, ReachTask(horizon=15, epsilon=0.25))
    trace = recorded(env, lambda env: taken.extend(wander(env, 120)))
    rewards = np.array([step[1] for step in taken])
    assert {name for name in ("ground", "reached", "truncated") if trace[name].any()} == {"reached", "truncated"}
    for env_number in range(3):
        steps = (trace["env"] == env_number) & (trace["step"] > 0)
        terms = [trace[name][steps] for name in ("reward", "reward_ground", "reward_target", "reward_step")]
        assert_allclose(np.sum(terms, axis=0), rewards[:, env_number], rtol=0.0, atol=1e-12)


def test_recorded_columns_follow_from_one_another(recorded, make, wander):
    """Step, begin distance, best, distance and delta are recorded as the NOTE defines them: Pb is the value before."""
    trace = recorded(make(1, ReachTask(horizon=15)), lambda env: wander(env, 100))
    target, tip = (np.stack([trace[f"{name}_{axis}"] for axis in "xyz"], 1) for name in ("target", "end_effector"))
    assert_allclose(trace["distance"], norm(target - tip, axis=1))
    assert_allclose(ROBOT.end_effector(trace["qpos"]), tip, atol=1e-9)
    assert_allclose(trace["delta_distance"], trace["distance"] - trace["previous_best"], atol=1e-15)
    starts = np.flatnonzero(trace["step"] == 0)
    assert len(starts) > 3
    for start, end in zip(starts, [*starts[1:], len(trace)], strict=True):
        rows = slice(start, end)
        distance = trace["distance"][rows]
        assert_array_equal(trace["step"][rows], np.arange(end - start))
        assert_array_equal(trace["begin_distance"][rows], distance[0])
        best = np.minimum.accumulate(np.concatenate([distance[:1], distance[:-1]]))
        assert_array_equal(trace["previous_best"][rows], best)


def test_start_rows_pay_nothing(recorded, make, wander):
    """One row opens each episode, with the action and every reward 0."""
    trace = recorded(make(2), lambda env: wander(env, 10))
    starts = trace["step"] == 0
    assert starts.sum() == 2 * 3
    paid = ("reward", "reward_ground", "reward_target", "reward_step", "delta_distance", "action")
    for name in (*paid, "ground", "reached", "truncated"):
        assert not trace[name][starts].any(), name


def test_actions_are_recorded_as_asked(recorded, make):
    """The trace holds what the policy asked for, not what the limits left of it."""
    trace = recorded(make(), lambda env: env.step(np.full((1, 6), 0.75, np.float32)))
    assert_array_equal(trace["action"], [[0.0] * 6, [0.75] * 6])


def test_reset_without_a_step_leaves_no_row(recorded, make, stand):
    """An episode that was left before its first step is not in the trace, and takes no number."""

    def leave(env):
        env.reset(seed=0)
        env.reset(seed=0)
        stand(env)
        env.reset()

    trace = recorded(make(), leave)
    assert trace["episode"].tolist() == [0, 0]
    assert trace["step"].tolist() == [0, 1]

"""What a reward is told of an arm's steps, its terms in the trace, and that a trace is paid again bit for bit."""

from functools import partial, reduce
from operator import add

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_array_equal

import harness
from harness.env.vector_env import ReachVectorEnv
from harness.log import trace_of
from harness.record import TraceWriter, read_trace
from harness.record.trace import TERM, terms_of
from harness.reward.forms import reward_class
from harness.reward.steps import MissingField
from harness.score.scorer import pay_log
from harness.task import ReachTask
from harness_plugins.kit.trainings import NegativeDistance
from tests.env.conftest import REGISTRY, SHORT_TASK, TASKS, build
from tests.refusals import refused

AIDS = ("joints", "choices", "long decisions", "next targets", "a goal that moves", "worse")
BEFORE = ("action", "ground", "qpos", "distance", "qvel")
TOURS = {**TASKS["next targets"], "epsilon": 0.7}


def everything(step):
    """Every field of a step, and of what was before."""
    before = step.before
    return {
        "reach": -step.distance + 0.3 * step.delta_distance * step.previous_distance - step.previous_best,
        "effort": -0.01 * (step.action**2).sum(-1),
        "jerk": -0.1 * ((step.action - before.action) ** 2).sum(-1),
        "speed": abs(step.qvel).max(-1) + (step.qvel * before.qvel).sum(-1),
        "bend": np.cos(step.qpos).sum(-1) - before.qpos[:, 1],
        "way": ((step.end_effector - before.end_effector) ** 2).sum(-1) ** 0.5,
        "goal": (step.target - before.target)[:, 2] + before.distance,
        "ground": -0.5 * step.ground + 0.25 * before.ground,
        "late": step.step / step.begin_distance,
    }


class Remembers(NegativeDistance):
    """Pays the sum of all earlier efforts of an episode, and what the last step said of the ground."""

    def initial_carry(self, begin_distance):
        """Nothing was done."""
        return (0.0 * begin_distance,)

    def __call__(self, carry, steps):
        """One term more than one may need."""
        done = carry[0] + abs(steps.action).sum(-1)
        return (done,), {"done": -done, "before": 1.0 * steps.before.ground + steps.before.qvel[:, 0]}


def record(path, simulator, task, reward, steps=40, **options):
    """Three arms that go mostly down, by a reward that reads qvel."""
    goal = build("tasks", task)
    robot = harness.load_robot(goal.robot, REGISTRY)
    env = ReachVectorEnv(build("simulators", simulator), robot, goal, reward, 3, records=("qvel",), **options)
    env.action_space.seed(3)
    with TraceWriter(path, robot.dof, env.episodes.action.shape[1], extras=env.episodes.extras) as env.recorder:
        env.reset(seed=0)
        for _ in range(steps):
            action = env.action_space.sample()
            env.step(action if action.dtype != np.float32 else np.clip(0.4 * action + 0.6, -1.0, 1.0))
    env.close()
    return read_trace(path)


def test_a_trace_is_paid_again_to_the_last_bit(tmp_path_factory, subtests):
    """The pay and each term of it, in every step; and the pay is the sum of the recorded terms."""
    for task in AIDS:
        for simulator in ["kinematic", "mujoco", "pybullet", "dm_control"]:
            with subtests.test(task=task, simulator=simulator):
                tmp_path = tmp_path_factory.mktemp("case")
                if task == "worse" and simulator == "kinematic":
                    pytest.skip("arms do not vary without an engine")
                reward = reward_class(everything)()
                trace = record(
                    tmp_path / "trace.parquet", simulator, TOURS if task == "next targets" else TASKS[task], reward
                )
                paid = pay_log(reward, trace)
                assert_array_equal(paid.total, trace["reward"])
                assert list(terms_of(trace)) == list(paid.terms)
                for name, values in terms_of(trace).items():
                    assert_array_equal(paid.terms[name], values)
                assert_array_equal(reduce(add, terms_of(trace).values()), trace["reward"])
                assert len(trace.last_rows) > 0


def test_a_reward_that_remembers_is_paid_again_to_the_last_bit(tmp_path):
    """Step by step, with what was before each."""
    trace = record(tmp_path / "trace.parquet", "kinematic", TOURS, Remembers())
    assert_array_equal(pay_log(Remembers(), trace).total, trace["reward"])
    assert trace["reached"].sum() > 0


def test_what_was_before_a_step_is_what_the_last_one_left(make):
    """Its action above all; before a first step there is no action, no ground, and the arm at rest where it starts."""
    seen = []

    def spy(step):
        seen.append([np.array(part) for part in (*map(partial(getattr, step.before), BEFORE), step.qvel)])
        return -step.distance

    env = make(2, reward=reward_class(spy)(), task=ReachTask(horizon=9))
    _, infos = env.reset(seed=0)
    start, begun = env.episodes.qpos.copy(), infos["distance"].copy()
    seen.clear()
    given = [np.full((2, 6), size, np.float32) for size in (0.5, -0.25, -0.25)]
    for action in given:
        env.step(action)
    actions, grounds, places, distances, before, speeds = zip(*seen, strict=True)
    assert_array_equal(actions, [0.0 * given[0], *given[:2]])
    assert not grounds[0].any()
    assert_array_equal(places[0], start)
    assert_array_equal(distances[0], begun)
    assert_array_equal(before[2], speeds[1])


def test_nobody_can_write_into_what_was_before(make):
    """It is the env's, as the step is."""

    def spoils(step):
        step.before.action[...] = 7.0
        return -step.distance

    class Spoils(NegativeDistance):
        def __call__(self, carry, steps):
            return carry, spoils(steps)

    env = make(1, reward=Spoils(), seed=0)
    with pytest.raises(ValueError, match="read-only"):
        env.step(np.zeros((1, 6), np.float32))


def test_a_trace_has_qvel_where_it_is_asked_for(make):
    """Traces of rewards that need no more stay as they were."""
    assert "qvel" not in make().episodes.extras
    assert make(records=("qvel",)).episodes.extras == {"qvel": 6}
    assert make(reward=reward_class(everything)()).episodes.extras.keys() == {
        f"{TERM}{name}" for name in ("reach", "effort", "jerk", "speed", "bend", "way", "goal", "ground", "late")
    }


def test_a_trace_without_qvel_pays_what_does_not_need_it(tmp_path):
    """And refuses the rest by name."""
    trace = record(tmp_path / "trace.parquet", "kinematic", SHORT_TASK, build("rewards", "baseline"))
    old = trace_of(trace.rows(name for name in trace.names if name != "qvel").columns)

    def calm(step):
        return -abs(step.action).sum(-1)

    assert pay_log(reward_class(calm)(), old).total.shape == (len(old),)
    with pytest.raises(MissingField, match=r"has no 'qvel'\. It has: .*end_effector"):
        pay_log(reward_class(everything)(), old)


def test_a_field_that_is_read_late_is_found_in_the_trace(tmp_path):
    """Made-up steps do not show it: it is read in the fifth step of an episode."""

    class Late(NegativeDistance):
        def __call__(self, carry, steps):
            return carry, -abs(steps.qvel).sum(-1) if (steps.step > 4.5).any() else -steps.distance

    trace = record(tmp_path / "trace.parquet", "kinematic", SHORT_TASK, build("rewards", "baseline"))
    assert_array_equal(pay_log(Late(), trace).total[trace["step"] > 0][-1], -abs(trace["qvel"][-1]).sum(-1))


def test_other_terms_than_at_first_end_the_run(make):
    """Their columns are those of the first step."""

    class Fickle(NegativeDistance):
        def __call__(self, carry, steps):
            return carry, {"a": steps.distance} if steps.step[0] > 1.5 else {"b": steps.distance}

    env = make(1, reward=Fickle(), seed=0)
    with refused("the terms a at first, and now b"):
        env.step(np.zeros((1, 6), np.float32))


@pytest.fixture
def goes_on(make):
    """Has an env go on from the state of another one, or from what is kept of it: it pays as that one does."""

    def goes_on(kept=lambda state: state, **given):
        env, again = (make(2, task=ReachTask(horizon=9), resumable=True, **given) for _ in range(2))
        env.reset(seed=0)
        actions = default_rng(0).uniform(-1.0, 1.0, (12, 2, 6)).astype(np.float32)
        for action in actions[:5]:
            env.step(action)
        again.restore(kept(env.state()))
        for action in actions[5:]:
            assert_array_equal(env.step(action)[1], again.step(action)[1])

    return goes_on


def test_what_was_before_is_kept_with_the_state(goes_on):
    """An env that goes on from another's state pays as that one does."""
    goes_on(reward=reward_class(everything)())


def test_a_state_of_an_earlier_version_goes_on(goes_on):
    """It does not tell what was before: rewards of its time did not read that."""
    goes_on(lambda state: {name: value for name, value in state.items() if "before" not in name})

"""The environment: Gymnasium's rules, seeds, how episodes begin and end, and what is paid."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from stable_baselines3.common import env_checker

import harness
from harness.env import ReachVectorEnv
from harness.errors import SimulationDiverged, UsageError
from harness.inverse import reach_position
from harness.robot import Robot
from harness.simulator import State
from harness.task import ReachTask
from harness.testing import IdealSimulator
from harness.testing.ideal import IdealSimulation
from harness.testing.trainings import NegativeDistance
from harness.trace import TraceWriter, read_trace

ROBOT = harness.load_robot("fd100")
SHORT = ReachTask(horizon=4)
NAMES = {"simulator": "mujoco", "task": "fd100-reach:horizon=20", "reward": "arp:k2=2"}


def make(num_envs: int = 1, task: ReachTask = SHORT, **options: Any) -> ReachVectorEnv:
    """An env without an engine."""
    given = {"simulator": IdealSimulator(), "robot": ROBOT, "task": task, "reward": NegativeDistance(), **options}
    return ReachVectorEnv(num_envs=num_envs, **given)


def stand(env: ReachVectorEnv) -> tuple[Any, ...]:
    """One step without motion."""
    return env.step(np.zeros((env.num_envs, 6), np.float32))


def wander(env: ReachVectorEnv, steps: int, seed: int = 0) -> list[tuple[Any, ...]]:
    """Steps with random actions."""
    rng = np.random.default_rng(seed)
    shape = (env.num_envs, 6)
    return [env.step(rng.uniform(-1.0, 1.0, shape).astype(np.float32)) for _ in range(steps)]


def drive_to(env: ReachVectorEnv, position: np.ndarray) -> tuple[Any, ...]:
    """Drive the end effectors of all envs to a position until an episode ends; the last step."""
    goal, reached = reach_position(ROBOT, position, env.simulation.read().qpos)
    assert reached.all()
    for _ in range(100):
        way = goal - env.simulation.read().qpos
        taken = env.step((way / (0.1 * env.task.speed * ROBOT.max_speed)).astype(np.float32))
        if (taken[2] | taken[3]).any():
            return taken
    raise AssertionError("no episode ended")


def target_of(observations: np.ndarray) -> np.ndarray:
    """The target as it is observed."""
    return observations[:, 18:21]


# Gymnasium and stable-baselines3


@pytest.mark.parametrize("simulator", ["mujoco"])
def test_gymnasium_finds_no_fault(simulator: str):
    """Gymnasium's checker passes without a warning."""
    env = gymnasium.make("harness/Reach-v0", **{**NAMES, "simulator": simulator})
    check_env(env.unwrapped, skip_render_check=True)
    env.close()


@pytest.mark.parametrize("simulator", ["mujoco"])
def test_stable_baselines3_finds_no_fault(simulator: str):
    """stable-baselines3's checker passes without a warning."""
    env = gymnasium.make("harness/Reach-v0", **{**NAMES, "simulator": simulator})
    env_checker.check_env(env.unwrapped, warn=True, skip_render_check=True)
    env.close()


def test_make_vec_makes_a_batch():
    """`gymnasium.make_vec` gives our vector env, of as many arms as asked for."""
    envs = gymnasium.make_vec("harness/Reach-v0", num_envs=3, **NAMES)
    assert isinstance(envs.unwrapped, ReachVectorEnv)
    observations, _ = envs.reset(seed=0)
    assert observations.shape == (3, 28)
    envs.close()


def test_spaces_of_a_batch():
    """Observation and action spaces are the single ones with a leading num_envs axis; actions fill [-1, 1]."""
    env = make(3)
    assert env.observation_space.shape == (3, *env.single_observation_space.shape)
    assert env.action_space.shape == (3, 6)
    np.testing.assert_array_equal(env.single_action_space.low, -1.0)
    np.testing.assert_array_equal(env.single_action_space.high, 1.0)


def test_next_step_autoreset_is_refused():
    """The autoreset mode that is not offered is a usage error that names the two that are."""
    with pytest.raises(UsageError, match="SAME_STEP or DISABLED"):
        make(autoreset_mode=AutoresetMode.NEXT_STEP)


def test_no_envs_are_refused():
    """A batch of no envs is a usage error."""
    with pytest.raises(UsageError, match="num_envs=0"):
        harness.make_env(num_envs=0)


# Observations


def test_observations_are_in_their_space():
    """Whatever the actions, every observation of every episode is within the bounds, in float32."""
    env = make(4, ReachTask(horizon=30))
    assert env.reset(seed=0)[0] in env.observation_space
    for observations, *_, infos in wander(env, 200):
        assert observations in env.observation_space
        assert infos.get("final_obs", observations) in env.observation_space


def test_no_observation_is_constant():
    """Every number of the observation changes from step to step, for every arm."""
    env = make(3, ReachTask(horizon=10))
    env.reset(seed=0)
    seen = np.array([observations for observations, *_ in wander(env, 60)])
    assert (seen.std(axis=0) > 0.0).all()


def test_what_a_step_returns_is_the_callers():
    """No array that was returned changes with the next step, or shares memory with what it returns."""
    env = make(3)
    env.reset(seed=0)
    for _ in range(10):
        first = arrays_of(stand(env))
        before = [array.copy() for array in first]
        second = arrays_of(wander(env, 1)[0])
        for array, copy in zip(first, before, strict=True):
            np.testing.assert_array_equal(array, copy)
        assert not any(np.shares_memory(one, other) for one in first for other in second)


def arrays_of(taken: tuple[Any, ...]) -> list[np.ndarray]:
    """All arrays that a step returns."""
    *arrays, infos = taken
    return [*arrays, *infos.values()]


def test_what_a_reset_returns_is_the_callers():
    """The first observations and infos stay as they are when the episode goes on."""
    env = make(2)
    observations, infos = env.reset(seed=0)
    before = observations.copy(), infos["distance"].copy()
    wander(env, 3)
    np.testing.assert_array_equal(observations, before[0])
    np.testing.assert_array_equal(infos["distance"], before[1])


def test_actions_are_left_alone():
    """The caller's actions are not changed, also where they are beyond the box."""
    env = make(2)
    env.reset(seed=0)
    actions = np.full((2, 6), 5.0, np.float32)
    env.step(actions)
    np.testing.assert_array_equal(actions, 5.0)


# Seeds


def first_observations(env: ReachVectorEnv, episodes: int, action_seed: int) -> np.ndarray:
    """The first observations of several episodes, (episodes, num_envs, size), under random actions between."""
    seen = [env.reset(seed=11)[0]]
    for _ in range(episodes - 1):
        observations, _, terminated, truncated, _ = wander(env, env.task.horizon, action_seed)[-1]
        assert (truncated & ~terminated).all()
        seen.append(observations)
    return np.array(seen)


def test_same_seed_same_starts_under_other_rewards():
    """Starts and targets of all episodes depend on the seed: neither on the reward nor on the actions."""
    starts = []
    for action_seed, reward in enumerate(("baseline", "arp:k1=2,k2=3")):
        env = harness.make_env("mujoco", "fd100-reach:horizon=3,epsilon=0.001", reward, num_envs=2)
        starts.append(first_observations(env, 5, action_seed))
        env.close()
    np.testing.assert_array_equal(*starts)


def test_env_of_a_batch_meets_what_it_meets_alone():
    """What env k meets depends on the seed and k, not on how many envs there are."""
    task = ReachTask(horizon=3, epsilon=0.001)
    small, large = (first_observations(make(num_envs, task), 5, 0) for num_envs in (2, 5))
    np.testing.assert_array_equal(small, large[:, :2])


def test_envs_of_a_batch_meet_different_things():
    """No two arms of a batch start alike, nor have they the same target."""
    observations, _ = make(4).reset(seed=0)
    assert len(np.unique(observations[:, 0])) == 4
    assert len(np.unique(target_of(observations)[:, 0])) == 4


def test_other_seed_other_starts():
    """Two seeds give two starts."""
    env = make()
    first, second = env.reset(seed=1)[0], env.reset(seed=2)[0]
    assert (first != second).any()


def test_reset_without_a_seed_goes_on():
    """Episodes after the first one go on with the stream: all different, and the same when all is done again."""
    env = make()
    runs = [[env.reset(seed=1)[0], env.reset()[0], env.reset()[0]] for _ in range(2)]
    np.testing.assert_array_equal(runs[0], runs[1])
    assert len({observations.tobytes() for observations in runs[0]}) == 3


def test_seeds_may_be_given_one_by_one():
    """A list gives each env a seed of its own, whatever its place."""
    env = make(2)
    first, second = env.reset(seed=[7, 8])[0], env.reset(seed=[8, 7])[0]
    np.testing.assert_array_equal(first, second[::-1])


def test_episodes_without_a_seed_differ_between_envs():
    """Two envs that were never seeded start differently."""
    assert (make().reset()[0] != make().reset()[0]).any()


# How episodes begin and end


def test_episode_begins_outside_of_epsilon():
    """No episode begins on its target, however large epsilon is."""
    env = make(task=ReachTask(epsilon=0.4, horizon=1))
    _, infos = env.reset(seed=0)
    for _ in range(50):
        assert (infos["distance"] > 0.4).all()
        _, infos = env.reset()


def test_target_ends_the_episode_and_pays():
    """Within epsilon of the target the episode is terminated and +1 is paid on top (NOTE eq. 19)."""
    env = make(task=ReachTask(epsilon=0.03))
    observations, _ = env.reset(seed=2)
    _, rewards, terminated, truncated, infos = drive_to(env, target_of(observations))
    assert terminated.tolist() == [True]
    assert truncated.tolist() == [False]
    assert infos["is_success"].tolist() == [True]
    assert infos["distance"][0] <= 0.03
    np.testing.assert_allclose(rewards, infos["reward_shaped"] + 1.0 - 0.0001)


def test_ground_ends_the_episode_and_costs():
    """On the ground the episode is terminated and -1 is paid on top (NOTE eq. 18)."""
    env = make(task=ReachTask())
    env.reset(seed=2)
    _, rewards, terminated, truncated, infos = drive_to(env, np.array([[0.9, 0.0, -0.1]]))
    assert terminated.tolist() == [True]
    assert truncated.tolist() == [False]
    assert infos["is_success"].tolist() == [False]
    np.testing.assert_allclose(rewards, infos["reward_shaped"] - 1.0 - 0.0001)


def test_horizon_truncates():
    """At the horizon, and not before, the episode is truncated, which is no event and pays nothing."""
    env = make()
    env.reset(seed=2)
    for step in range(1, 5):
        _, rewards, terminated, truncated, infos = stand(env)
        assert not terminated.any()
        assert truncated.tolist() == [step == 4]
        np.testing.assert_allclose(rewards, infos["reward_shaped"] - 0.0001)


def test_target_at_the_horizon_is_no_truncation():
    """An episode that reaches its target in the last step is terminated, not truncated."""
    env = make(task=ReachTask(epsilon=0.03))
    observations, _ = env.reset(seed=2)
    steps = 0
    while True:
        steps += 1
        short = make(task=ReachTask(epsilon=0.03, horizon=steps))
        short.reset(seed=2)
        *_, terminated, truncated, _ = drive_to(short, target_of(observations))
        if terminated.any():
            break
    assert steps > 2
    assert not truncated.any()


def test_event_terms_are_the_tasks():
    """What the events pay is set by the task."""
    env = make(task=ReachTask(epsilon=0.03, target_reward=5.0, step_reward=-0.5))
    observations, _ = env.reset(seed=2)
    _, rewards, _, _, infos = drive_to(env, target_of(observations))
    np.testing.assert_allclose(rewards, infos["reward_shaped"] + 4.5)


def test_same_step_starts_the_next_episode():
    """The step that ends an episode returns the next one's start; the last observation is in the infos."""
    env = make(2)
    env.reset(seed=0)
    wander(env, 3)
    observations, _, _, truncated, infos = wander(env, 1, seed=9)[0]
    assert truncated.all()
    np.testing.assert_array_equal(infos["_final_obs"], [True, True])
    np.testing.assert_allclose(infos["final_obs"][:, -1], infos["distance"], atol=1e-6)
    np.testing.assert_array_equal(observations[:, 6:18], 0.0)
    assert (target_of(observations) != target_of(infos["final_obs"])).any(axis=1).all()


def test_same_step_leaves_the_other_envs_alone():
    """When one arm starts anew the others go on as if it had not."""
    task = ReachTask(horizon=6)
    env, undisturbed = make(2, task, autoreset_mode=AutoresetMode.DISABLED), make(2, task)
    for either in (env, undisturbed):
        either.reset(seed=0)
    wander(env, 2)
    wander(undisturbed, 2)
    env.reset(options={"reset_mask": np.array([True, False])})
    for one, other in zip(wander(env, 3, seed=4), wander(undisturbed, 3, seed=4), strict=True):
        np.testing.assert_array_equal(one[0][1], other[0][1])
        assert one[1][1] == other[1][1]


def test_disabled_waits_for_the_reset_mask():
    """Without autoreset an ended episode stays ended; a reset with a mask starts those of the mask alone."""
    env = make(2, autoreset_mode=AutoresetMode.DISABLED)
    start, _ = env.reset(seed=0)
    observations, _, _, truncated, infos = wander(env, 4)[-1]
    assert truncated.all()
    assert "final_obs" not in infos
    np.testing.assert_array_equal(target_of(observations), target_of(start))
    again, infos = env.reset(options={"reset_mask": np.array([False, True])})
    np.testing.assert_array_equal(again[0], observations[0])
    assert (target_of(again)[1] != target_of(observations)[1]).any()
    assert infos["distance"].shape == (2,)


def test_both_autoreset_modes_tell_the_same_story():
    """Resetting what has ended by its mask gives the episodes that autoreset gives."""
    same, disabled = make(3), make(3, autoreset_mode=AutoresetMode.DISABLED)
    seen = [[same.reset(seed=5)[0]], [disabled.reset(seed=5)[0]]]
    rng = np.random.default_rng(1)
    for _ in range(20):
        actions = rng.uniform(-1.0, 1.0, (3, 6)).astype(np.float32)
        seen[0].append(same.step(actions)[0])
        observations, _, terminated, truncated, _ = disabled.step(actions)
        ended = terminated | truncated
        seen[1].append(disabled.reset(options={"reset_mask": ended})[0] if ended.any() else observations)
    np.testing.assert_array_equal(*seen)


class LosesTheEndEffector(IdealSimulation):
    """After a drive the end effector of env 1 is nowhere."""

    number = np.nan

    def drive(self, qpos: np.ndarray, duration: float) -> State:
        """As any drive, but for env 1."""
        state = super().drive(qpos, duration)
        state.end_effector[1] = self.number
        return state


class LosesItAtInfinity(LosesTheEndEffector):
    """The same, with a number that can be compared."""

    number = np.inf


def simulator_of(simulation: type[IdealSimulation]) -> IdealSimulator:
    """The simulator that opens a simulation."""

    class Simulator(IdealSimulator):
        def open(self, robot: Robot, num_envs: int, control_period: float) -> IdealSimulation:
            return simulation(robot, num_envs)

    return Simulator()


def test_diverging_simulation_is_told_at_once():
    """A number that is none raises SimulationDiverged in the step where it comes, with the env and the step."""
    env = make(3, simulator=simulator_of(LosesTheEndEffector))
    env.reset(seed=0)
    with pytest.raises(SimulationDiverged, match=r"env \[1\] is nowhere at step 1"):
        stand(env)


def test_diverging_simulation_never_gets_into_a_trace(tmp_path: Path):
    """An infinite number raises SimulationDiverged when the trace is written, at the latest."""
    recorder = TraceWriter(tmp_path / "trace.parquet", dof=6, action_size=6)
    env = make(3, simulator=simulator_of(LosesItAtInfinity), recorder=recorder)
    env.reset(seed=0)
    stand(env)
    with pytest.raises(SimulationDiverged, match="distance is not finite at env 1, episode 0, step 1"):
        recorder.close()


# What is told and paid


def test_infos_of_every_step():
    """Every step tells distance, shaped reward and success of every env."""
    env = make(2)
    env.reset(seed=0)
    observations, _, _, _, infos = wander(env, 1)[0]
    assert set(infos) == {"distance", "reward_shaped", "is_success"}
    np.testing.assert_allclose(infos["distance"], observations[:, -1], atol=1e-6)
    np.testing.assert_array_equal(infos["reward_shaped"], -infos["distance"])
    assert infos["is_success"].dtype == bool


def test_rewards_are_float64():
    """What is paid is recorded and summed over whole runs: it is not rounded to float32."""
    env = make(2)
    env.reset(seed=0)
    assert stand(env)[1].dtype == np.float64


def test_reward_sees_one_sample_per_step():
    """The sample is begin distance, best before the step, last distance, distance, their difference, and t."""
    samples = []

    class Spy(NegativeDistance):
        def __call__(self, carry: Any, sample: Any) -> Any:
            samples.append([float(part[0]) for part in sample])
            return carry, -sample.distance

    env = make(task=ReachTask(horizon=5), reward=Spy())
    _, infos = env.reset(seed=0)
    distances = [infos["distance"][0], *(infos["distance"][0] for *_, infos in wander(env, 5))]
    for t in range(1, 6):
        best = min(distances[:t])
        expected = [distances[0], best, distances[t - 1], distances[t], distances[t] - best, t]
        np.testing.assert_allclose(samples[t - 1], expected, rtol=1e-12)


def test_carry_starts_anew_with_an_episode():
    """What a reward remembers is forgotten for the arms that start, and kept for the others."""

    class CountsSteps(NegativeDistance):
        def initial_carry(self, begin_distance: Any) -> Any:
            return (begin_distance * 0.0,)

        def __call__(self, carry: Any, sample: Any) -> Any:
            return (carry[0] + 1.0,), carry[0] + 1.0

    env = make(2, ReachTask(horizon=9), reward=CountsSteps(), autoreset_mode=AutoresetMode.DISABLED)
    env.reset(seed=0)
    wander(env, 2)
    env.reset(options={"reset_mask": np.array([True, False])})
    np.testing.assert_array_equal(stand(env)[-1]["reward_shaped"], [1.0, 3.0])


def test_recorded_terms_add_up_to_what_was_paid(tmp_path: Path):
    """Shaped reward and event terms are columns of their own; their sum is what the learner was paid, in order."""
    path = tmp_path / "trace.parquet"
    with TraceWriter(path, dof=6, action_size=6) as recorder:
        env = make(3, ReachTask(horizon=15, epsilon=0.25), recorder=recorder)
        env.reset(seed=0)
        rewards = np.array([taken[1] for taken in wander(env, 120)])
    trace = read_trace(path)
    assert {name for name in ("ground", "reached", "truncated") if trace[name].any()} == {"reached", "truncated"}
    for env_number in range(3):
        steps = (trace["env"] == env_number) & (trace["step"] > 0)
        terms = [trace[name][steps] for name in ("reward", "reward_ground", "reward_target", "reward_step")]
        np.testing.assert_allclose(np.sum(terms, axis=0), rewards[:, env_number], rtol=0.0, atol=1e-12)


def test_recorded_columns_follow_from_one_another(tmp_path: Path):
    """Step, begin distance, best, distance and delta are recorded as the NOTE defines them: Pb is the value before."""
    path = tmp_path / "trace.parquet"
    with TraceWriter(path, dof=6, action_size=6) as recorder:
        env = make(1, ReachTask(horizon=15), recorder=recorder)
        env.reset(seed=0)
        wander(env, 100)
    trace = read_trace(path)
    target, tip = (np.stack([trace[f"{name}_{axis}"] for axis in "xyz"], 1) for name in ("target", "end_effector"))
    np.testing.assert_allclose(trace["distance"], np.linalg.norm(target - tip, axis=1))
    np.testing.assert_allclose(ROBOT.end_effector(trace["qpos"]), tip, atol=1e-9)
    np.testing.assert_allclose(trace["delta_distance"], trace["distance"] - trace["previous_best"], atol=1e-15)
    starts = np.flatnonzero(trace["step"] == 0)
    assert len(starts) > 3
    for start, end in zip(starts, [*starts[1:], len(trace)], strict=True):
        rows = slice(start, end)
        distance = trace["distance"][rows]
        np.testing.assert_array_equal(trace["step"][rows], np.arange(end - start))
        np.testing.assert_array_equal(trace["begin_distance"][rows], distance[0])
        best = np.minimum.accumulate(np.concatenate([distance[:1], distance[:-1]]))
        np.testing.assert_array_equal(trace["previous_best"][rows], best)


def test_start_rows_pay_nothing(tmp_path: Path):
    """One row opens each episode, with the action and every reward 0."""
    path = tmp_path / "trace.parquet"
    with TraceWriter(path, dof=6, action_size=6) as recorder:
        env = make(2, recorder=recorder)
        env.reset(seed=0)
        wander(env, 10)
    trace = read_trace(path)
    starts = trace["step"] == 0
    assert starts.sum() == 2 * 3
    for name in ("reward", "reward_ground", "reward_target", "reward_step", "delta_distance", "action"):
        assert not trace[name][starts].any(), name
    for name in ("ground", "reached", "truncated"):
        assert not trace[name][starts].any(), name


def test_actions_are_recorded_as_asked(tmp_path: Path):
    """The trace holds what the policy asked for, not what the limits left of it."""
    path = tmp_path / "trace.parquet"
    with TraceWriter(path, dof=6, action_size=6) as recorder:
        env = make(recorder=recorder)
        env.reset(seed=0)
        env.step(np.full((1, 6), 0.75, np.float32))
    np.testing.assert_array_equal(read_trace(path)["action"], [[0.0] * 6, [0.75] * 6])


def test_reset_without_a_step_leaves_no_row(tmp_path: Path):
    """An episode that was left before its first step is not in the trace, and takes no number."""
    path = tmp_path / "trace.parquet"
    with TraceWriter(path, dof=6, action_size=6) as recorder:
        env = make(recorder=recorder)
        for _ in range(3):
            env.reset(seed=0)
        stand(env)
        env.reset()
    trace = read_trace(path)
    assert trace["episode"].tolist() == [0, 0]
    assert trace["step"].tolist() == [0, 1]


def test_ended_episode_that_is_stepped_on_forgets_its_end():
    """Without autoreset, steps after the target was reached are neither terminated nor paid for it again."""
    env = make(autoreset_mode=AutoresetMode.DISABLED, task=ReachTask(epsilon=0.03))
    observations, _ = env.reset(seed=2)
    drive_to(env, target_of(observations))
    for _ in range(10):
        _, rewards, terminated, _, infos = env.step(np.ones((1, 6), np.float32))
    assert not terminated.any()
    np.testing.assert_allclose(rewards, infos["reward_shaped"] - 0.0001)


def test_mujoco_batch_is_its_envs_alone():
    """Through the whole env, an arm of a MuJoCo batch lives, bit for bit, as it does alone."""
    runs = []
    for num_envs in (1, 3):
        env = harness.make_env(num_envs=num_envs, task="fd100-reach:horizon=8")
        env.reset(seed=4)
        actions = np.random.default_rng(0).uniform(-1.0, 1.0, (20, 1, 6)).astype(np.float32)
        runs.append([env.step(np.repeat(action, num_envs, axis=0))[:2] for action in actions])
        env.close()
    for (alone, paid_alone), (batch, paid) in zip(*runs, strict=True):
        np.testing.assert_array_equal(alone[0], batch[0])
        assert paid_alone[0] == paid[0]


def test_close_can_be_called_twice():
    """A second close does nothing."""
    env = harness.make_env()
    env.reset(seed=0)
    env.close()
    env.close()
    assert env.closed


def test_an_end_is_not_told_twice_without_autoreset(tmp_path: Path):
    """A finished env that is stepped on beside a restarted one is recorded as it is then, not as it ended."""
    away = np.zeros((2, 6), np.float32)
    away[1] = [0, -1, -1, 0, 0, 0]  # env 1 rises out of the reach of its target
    env = harness.make_env(
        num_envs=2, task="fd100-reach:epsilon=0.3,horizon=200", autoreset_mode=AutoresetMode.DISABLED
    )
    with TraceWriter(tmp_path / "trace.parquet", 6, 6) as recorder:
        env.recorder = recorder
        env.reset(seed=3)
        reached = np.zeros(2, bool)
        for action in np.random.default_rng(0).uniform(-1.0, 1.0, (200, 2, 6)).astype(np.float32):
            reached = env.step(action)[4]["is_success"]
            if reached[1]:
                break
        assert reached[1]
        env.reset(options={"reset_mask": np.array([True, False])})
        for _ in range(15):
            infos = env.step(away)[4]
    env.close()
    assert not infos["is_success"][1]
    trace = read_trace(tmp_path / "trace.parquet")
    assert not trace["reached"][trace["env"] == 1][-1]
    assert trace["reward_target"][trace["env"] == 1][-1] == 0.0

"""An arm's task as a search plays it: paid as its env pays, whatever is played beside it."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest
from gymnasium.spaces import Discrete
from gymnasium.vector import AutoresetMode
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal, assert_equal

from harness.env.vector_env import ReachVectorEnv, World as Arm
from harness.errors import SimulationDiverged
from harness.log.log import episode_sum
from harness.registry import choose
from harness.task import ReachTask
from harness_plugins.audit.search.arm_world import ArmWorld
from harness_plugins.audit.search.place import places_on_task, world_at
from harness_plugins.kit import IdealSimulator
from tests.heavy_arms import Heavy
from tests.registered import FD100 as ROBOT, REGISTRY

STARTS = np.array([0, 1, 0, 2])


class Onward(ReachTask):
    """A task that goes on at a target."""

    ends_at_target = False


class Held(ReachTask):
    """A task whose decisions hold for five steps."""

    decision_period = 5


@dataclass(frozen=True)
class Remembering:
    """Pays a nearer arm, more at every step, in two terms."""

    def initial_carry(self, begin_distance):
        """No step so far."""
        return np.zeros_like(begin_distance)

    def __call__(self, carry, steps):
        """Progress, and the number of the step."""
        return carry + 1.0, {"nearer": steps.previous_distance - steps.distance, "late": -0.01 * carry}


@dataclass(frozen=True)
class Broken:
    """Pays no number."""

    def initial_carry(self, begin_distance):
        """Nothing."""
        return ()

    def __call__(self, carry, steps):
        """NaN."""
        return carry, steps.distance * np.nan


def world_of(task=None, reward=None, gamma=0.9):
    """A world without an engine."""
    task = task or ReachTask(horizon=20)
    return ArmWorld(Arm(IdealSimulator(), ROBOT, task, reward or Remembering()), "reach", "mine", gamma)


def drawn(world, count, seed=0):
    """Random actions of so many episodes."""
    world.space.seed(seed)
    return np.stack([[world.space.sample() for _ in range(world.horizon)] for _ in range(count)])


def paid_by_env(world, start, actions):
    """What an env of one arm pays an episode, step by step."""
    arm = world.arm
    env = ReachVectorEnv(arm.simulator, arm.robot, arm.task, arm.reward, 1, autoreset_mode=AutoresetMode.DISABLED)
    env.reset(seed=[int(start)])
    paid = []
    for action in actions:
        _, pay, terminated, truncated, _ = env.step(action[None])
        paid.append(pay[0])
        if terminated[0] or truncated[0]:
            return np.array(paid)
    raise AssertionError("the episode does not end")


TASKS = (
    partial(ReachTask, horizon=20),
    partial(ReachTask, horizon=20, action="movel"),
    partial(ReachTask, horizon=20, action="discrete"),
    partial(ReachTask, horizon=20, action_noise=0.1, joint_noise=0.01),
    partial(Onward, horizon=20, epsilon=0.4),
    partial(Held, horizon=18),
)


@pytest.mark.parametrize("make", TASKS)
def test_pay_is_that_of_an_env_of_one_arm(make):
    """Bit for bit, of tasks of all kinds; and so is what is shown."""
    world = world_of(make())
    actions = drawn(world, len(STARTS))
    outcomes = world.play(STARTS, actions)
    assert world.taken == outcomes.steps.sum() * world.arm.task.decision_period  # not of arms that rest
    assert isinstance(world.space, Discrete) == (world.arm.task.action == "discrete")
    for number, start in enumerate(STARTS):
        paid = paid_by_env(world, start, actions[number])
        shown = world.show(int(start), actions[number])
        assert_array_equal(shown.paid, paid)
        assert (episode_sum(paid), episode_sum(paid, 0.9)) == (outcomes.paid[number], outcomes.discounted[number])
        assert outcomes.steps[number] == len(paid) == len(shown.actions)
        assert {name: values[-1] for name, values in shown.measures.items()} == {
            name: values[number] for name, values in outcomes.measures.items()
        }


def test_batches_do_the_same():
    """Arms of which three are held at once do and begin what they do and begin side by side."""
    starts, actions = np.arange(7), default_rng(0).uniform(-1.0, 1.0, (7, 5, 6)).astype(np.float32)
    told = []
    for simulator in (IdealSimulator(), Heavy()):
        world = ArmWorld(Arm(simulator, ROBOT, ReachTask(horizon=5), Remembering()), "reach", "remembering", 1.0)
        planned = [it.actions for it in world.scripts(starts)[1:]]
        told.append((world.play(starts, actions).paid, world.distinct(starts), planned))
        world.close()
    assert_equal(*told)


def test_terms_and_events_add_up_to_the_pay():
    """Each term under its name, and what the task pays."""
    world = world_of(Held(horizon=18))
    shown = world.show(0, drawn(world, 1)[0])
    assert [*shown.terms] == ["nearer", "late", "events"]
    assert_allclose(sum(shown.terms.values()), shown.paid)
    assert shown.ended == "truncated"


def test_episodes_do_not_depend_on_those_beside_them():
    """More than move together, some of which end at once."""
    world = world_of()
    actions = drawn(world, 4)
    many = world.together // 2
    outcomes, alone = world.play(np.tile(STARTS, many), np.tile(actions, (many, 1, 1))), world.play(STARTS, actions)
    assert_array_equal(outcomes.paid, np.tile(alone.paid, many))
    assert_array_equal(outcomes.near, np.tile(alone.near, many))


def test_success_is_reaching():
    """The script that finishes succeeds in the step in which it ends, and the one that holds never does."""
    world = world_of(ReachTask(horizon=60))
    by_script = {it.made_by: it for it in world.scripts([0]) if it.act is None}
    made = np.stack([by_script[f"script {name}"].actions[0] for name in ("finish", "hold")])
    outcomes = world.play(np.zeros(2, int), made)
    assert outcomes.success.tolist() == [True, False]
    assert outcomes.time.tolist() == [outcomes.steps[0], 60]
    assert outcomes.share.tolist() == [1.0 / outcomes.steps[0], 0.0]
    assert outcomes.near[0] > -world.arm.task.epsilon > outcomes.near[1]


def test_a_task_that_goes_on_is_done_from_the_first_target_on():
    """The share of its steps from then on, and how many it reached."""
    world = world_of(Onward(horizon=40, epsilon=0.2))
    (policy,) = [it.act for it in world.scripts([0]) if it.act is not None]
    outcomes, taken = world.act(np.array([0]), policy)
    shown = world.show(0, taken[0])
    first = int(np.argmax(shown.measures["targets"] > 0)) + 1
    assert outcomes.success[0]
    assert outcomes.time[0] == first
    assert outcomes.share[0] == (40 - first + 1) / 40 == shown.success.mean()
    assert outcomes.measures["targets"][0] > 1


def test_a_policy_is_given_what_its_arm_observes():
    """Actions that it took are paid the same when they are played."""
    world = world_of()
    outcomes, taken = world.act(STARTS, lambda seen: np.tanh(5.0 * seen[:6]))
    padded = np.stack([np.resize(it, (world.horizon, 6)) for it in taken])
    assert_array_equal(world.play(STARTS, padded).paid, outcomes.paid)
    assert outcomes.paid[0] == outcomes.paid[2] != outcomes.paid[1]


def test_a_reward_that_pays_no_number_is_refused():
    """In a sentence."""
    world = world_of(reward=Broken())
    with pytest.raises(SimulationDiverged, match="pay was NaN at step"):
        world.play(STARTS, drawn(world, 4))


def test_a_simulator_that_forgets_its_seed_is_told():
    """One whose arms are elsewhere at every reset."""

    @dataclass(frozen=True)
    class Restless(IdealSimulator):
        def open(self, robot, num_envs, control_period):
            simulation = super().open(robot, num_envs, control_period)
            reset, rng = simulation.reset, default_rng(0)
            simulation.reset = lambda qpos, mask: reset(qpos + 1e-9 * rng.random(), mask)
            return simulation

    world = world_of()
    assert world.is_repeated
    world = world_of()
    world.arm = replace(world.arm, simulator=Restless())
    assert not world.is_repeated


def test_starts_that_are_alike_are_searched_once():
    """The published task begins all its episodes in one pose with one target."""
    arp = [choose(REGISTRY, "rewards", "arp")]
    for task, count in (("arp-2021", 1), ("fd100-reach", 3)):
        (place,) = places_on_task(REGISTRY, arp, task, None, None, 0.95)
        world = world_at(place, REGISTRY)
        assert len(world.distinct([5, 6, 7])) == count
        world.close()


def test_a_decision_of_five_steps_counts_five():
    """Played, and shown."""
    world = world_of(Held(horizon=20))
    still = np.zeros((1, world.horizon, ROBOT.dof), np.float32)
    assert (world.play(np.array([0]), still).steps.tolist(), world.taken) == ([4], 20)
    world.show(0, still[0])
    assert world.taken == 40

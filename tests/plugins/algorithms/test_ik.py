"""IK: the ceiling reaches next to every target, from the observation alone, and comes back from its folder."""

import json

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_array_equal

import harness
from harness.algorithm import learns, why_not
from harness.env.arm_observation import ArmObservation, kinematics_policy
from harness.errors import SchemaError
from harness.experiment.arm_evaluation import EVALUATION_SEED
from harness.experiment.plan import check_experiment, expand
from harness.policy import Uniform, load_policy
from harness.policy.inverse_kinematics import InverseKinematics
from harness.record.folder import CARD
from harness.registry import choose
from harness.task import ReachTask
from harness_plugins.algorithms.ik import Ik
from harness_plugins.kit.trainings import observations, train
from tests.registered import FD100, REGISTRY

MODES = ("movej", "movej-absolute", "set-joints")


def _policy(task, robot="fd100", mode="movej"):
    arm = harness.load_robot(robot, REGISTRY)
    return InverseKinematics.of(arm, task.motion(arm).limits, mode, "ik")  # type: ignore[attr-defined]


def _success(simulator, mode, robot, episodes, task="fd100-reach"):
    env = harness.make_env(simulator, f"{task}:action={mode}", "dense", robot, num_envs=episodes)
    policy = kinematics_policy(env.task, env.robot)
    seen, _ = env.reset(seed=EVALUATION_SEED)
    running, reached = np.ones(episodes, bool), np.zeros(episodes, bool)
    while running.any():
        seen, _, terminated, truncated, infos = env.step(policy.act(seen))
        reached |= running & infos["is_success"]
        running &= ~(terminated | truncated)
    env.close()
    return float(reached.mean())


@pytest.mark.parametrize("mode", MODES)
def test_it_reaches_the_targets_without_dynamics(mode):
    """99 of 100 and more, in every mode."""
    assert _success("kinematic", mode, "fd100", 500) >= 0.99


def test_it_reaches_the_targets_with_dynamics():
    """In MuJoCo as well: the arm follows."""
    pytest.importorskip("mujoco")
    assert _success("mujoco", "movej", "fd100", 100) >= 0.99


@pytest.mark.parametrize("task", ["fd100-pose", "fd100-moving", "fd100-small-target", "fd100-low"])
def test_it_does_the_harder_tasks(task):
    """A pose by inverse kinematics of position and orientation, a moving target by going to where it is now."""
    assert _success("kinematic", "movej", "fd100", 50, task) >= 0.95


def test_policy_of_a_pose_comes_back_from_its_folder(tmp_path):
    """With what it sees beside the target's place; a card whose observation has no room for it is refused."""
    task = choose(REGISTRY, "tasks", "fd100-pose").build(REGISTRY, "tasks")
    policy = kinematics_policy(task, FD100, "ik")
    policy.save(tmp_path)
    seen, _ = harness.make_env("kinematic", "fd100-pose", "dense", num_envs=4).reset(seed=0)
    assert_array_equal(policy.act(seen), load_policy(tmp_path).act(seen))
    card = json.loads((tmp_path / CARD).read_text())
    assert (card["observation"]["size"], card["turns"]) == (37, True)
    card["observation"]["size"] = 28
    (tmp_path / CARD).write_text(json.dumps(card))
    with pytest.raises(SchemaError, match="28 numbers"):
        load_policy(tmp_path)


def test_it_reaches_with_another_arm():
    """With five joints, and targets scaled by its reach; some of them lie behind the arm's ranges."""
    assert _success("kinematic", "movej", "unity-arm", 200) >= 0.9


@pytest.mark.parametrize("mode", MODES)
def test_policy_comes_back_from_its_folder(tmp_path, mode):
    """It acts the same, bit for bit, and says of which arm it is."""
    policy = _policy(ReachTask(action=mode), mode=mode)
    policy.save(tmp_path)
    loaded = load_policy(tmp_path)
    assert_array_equal(policy.act(observations()), loaded.act(observations()))
    card = json.loads((tmp_path / CARD).read_text())
    assert card["robot"]["name"] == FD100.name
    assert len(card["robot"]["urdf_sha256"]) == 64
    assert isinstance(loaded.floor(), Uniform)


def test_nothing_is_drawn():
    """With a generator it does the same as without."""
    policy = _policy(ReachTask())
    assert_array_equal(policy.act(observations(), default_rng(0)), policy.act(observations()))


def test_card_has_the_size_of_the_observation():
    """Joint angles, speeds and accelerations, and ten numbers more."""
    assert _policy(ReachTask()).card()["observation"]["size"] == len(ArmObservation(FD100, 0.1).low)


DAMAGES = {
    "'mode' is missing": lambda card: card.pop("mode"),
    "no action mode 'fly'": lambda card: card.update(mode="fly"),
    "no arm has the joints": lambda card: card.update(joint_kinds=["ball"] * 6),
    "joints is": lambda card: card.update(joint_kinds=["revolute"] * 5),
}


@pytest.mark.parametrize(("message", "damage"), DAMAGES.items(), ids=DAMAGES)
def test_damaged_card_is_refused(tmp_path, message, damage):
    """By name, before it acts."""
    _policy(ReachTask()).save(tmp_path)
    card = json.loads((tmp_path / CARD).read_text())
    damage(card)
    (tmp_path / CARD).write_text(json.dumps(card))
    with pytest.raises(SchemaError, match=message):
        load_policy(tmp_path)


def test_it_says_that_it_does_not_learn():
    """So that nobody asks it to."""
    assert not learns(Ik())


def test_training_yields_the_policy():
    """It spends its budget acting."""
    done = train(Ik(), 200)
    assert (done.env.steps, done.told[-1]) == (200, 200)
    assert isinstance(done.policy, InverseKinematics)


def test_what_it_cannot_do_has_a_reason(subtests):
    """Of the action mode, and of the observation."""
    for task, reason in [
        ("fd100-reach", ""),
        ("fd100-reach:action=movej-absolute", ""),
        ("fd100-reach:action=movel", "ik knows the action modes movej, movej-absolute, set-joints"),
        ("fd100-pose", ""),
        ("fd100-moving", ""),
        ("unity-reach", "ik reads joint angles and target from the observation of fd100-reach"),
    ]:
        with subtests.test(task=task, reason=reason):
            built = choose(REGISTRY, "tasks", task).build(REGISTRY, "tasks")
            said = why_not(Ik(), built, harness.load_robot(built.robot, REGISTRY))
            assert said.startswith(reason)
            assert bool(said) == bool(reason)


def test_plan_skips_what_it_cannot_do():
    """With the reason, and nothing fails later."""
    plan = expand(
        check_experiment({"sim": "kinematic", "algo": ["ik"], "task": "fd100-reach:action=movel", "seeds": 1}), REGISTRY
    )
    assert not plan.cells
    assert {reason.split(",")[0] for _, reason in plan.skipped} == {"ik knows the action modes movej"}

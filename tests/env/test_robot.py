"""Which arm a task is done with."""

import gymnasium
import pytest

import harness

OWN = {"fd100-reach": "fd100", "unity-reach": "unity-arm", "arp-2021": "unity-arm"}


@pytest.mark.parametrize(("task", "own"), OWN.items())
def test_task_has_its_own_robot(task: str, own: str):
    """Without a robot the vector env has the one that the task was made for."""
    env = harness.make_env("kinematic", task)
    assert env.robot.name == env.task.robot == own
    env.close()


@pytest.mark.parametrize(("task", "own"), OWN.items())
def test_task_has_its_own_robot_in_the_single_env(task: str, own: str):
    """So has the env of one arm."""
    env = gymnasium.make("harness/Reach-v0", simulator="kinematic", task=task)
    assert env.unwrapped.vector_env.robot.name == own
    env.close()


def test_another_robot_can_be_given():
    """It goes before the task's own."""
    env = harness.make_env("kinematic", "fd100-reach", robot="unity-arm")
    assert env.robot.name == "unity-arm"
    env.close()

"""Which arm a task is done with."""

import gymnasium
import pytest

import harness

OWN = {"fd100-reach": "fd100", "unity-reach": "unity-arm", "arp-2021": "unity-arm"}


@pytest.mark.parametrize(("task", "own"), OWN.items())
def test_task_has_its_own_robot(task, own):
    """Without a robot the vector env has the one that the task was made for, and so has the env of one arm."""
    env = harness.make_env("kinematic", task)
    single = gymnasium.make("harness/Reach-v0", simulator="kinematic", task=task)
    assert env.robot.name == env.task.robot == single.unwrapped.vector_env.robot.name == own
    env.close()
    single.close()


def test_another_robot_can_be_given():
    """It goes before the task's own."""
    env = harness.make_env("kinematic", "fd100-reach", robot="unity-arm")
    assert env.robot.name == "unity-arm"
    env.close()

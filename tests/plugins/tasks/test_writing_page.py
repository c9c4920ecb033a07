"""docs/writing/task.md: the task that is not a reach."""

import re

import numpy as np
import pytest

from harness.env.arm_observation import why_not_kinematics
from harness.task import Situation
from harness_plugins.kit import check_contract
from tests.project import page_of
from tests.registered import FD100 as ROBOT

PAGE = page_of("writing/task")


@pytest.fixture
def task():
    """The page's, which is not the one that `harness new-plugin` writes."""
    (code,) = [code for code in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL) if "(Goal)" in code]
    names = {"__name__": __name__}
    exec(code, names)
    return names["ReachFromAbove"]()


def test_task_of_the_page_passes_every_check(task):
    """As it stands there."""
    check_contract("task", task, ROBOT)


def test_tilt_is_an_error(task):
    """In the home pose the flange is tilted: the error is more than the distance to a target where it is."""
    goal, here = task.goal(ROBOT), ROBOT.end_effector(ROBOT.home[None])
    none = np.zeros(1)
    tilt = np.degrees(np.arccos(0.64))
    now = Situation(ROBOT.home[None], here, here, np.zeros((1, 0)), none, none)
    assert goal.errors(now)[0] == pytest.approx(0.005 * tilt, abs=0.01)


def test_kinematics_say_why_they_cannot(task):
    """With the name of the error."""
    assert "distance or tilt" in why_not_kinematics(task, ROBOT)

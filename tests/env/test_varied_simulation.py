"""A simulation for each arm."""

from dataclasses import dataclass

import numpy as np
from numpy.testing import assert_allclose

from harness.env.ideal import IdealSimulation
from harness.env.surroundings import MOST_IDLE, VariedSimulation
from harness_plugins.kit import IdealSimulator
from tests.registered import FD100 as ROBOT


@dataclass(frozen=True)
class Counting:
    """Keeps what it opened."""

    opened: list["Counted"]

    def open(self, robot, num_envs, control_period):
        self.opened.append(Counted(robot, num_envs))
        return self.opened[-1]


class Counted(IdealSimulation):
    """Knows whether it was closed."""

    is_closed = False

    def close(self):
        self.is_closed = True


def met(arms):
    """A simulation that has met these arms, and what it opened."""
    opened = []
    varied = VariedSimulation(Counting(opened), lambda number: ROBOT, ROBOT.dof, 1, 0.1)
    for arm in arms:
        varied.arms[:] = arm
        varied.reset(ROBOT.home[None], np.ones(1, bool))
    return varied, opened


def test_arms_are_opened_when_first_met_and_kept():
    """An env that comes back to an arm finds the same simulation."""
    assert len(met((0, 1, 0, 1, 2))[1]) == 3


def test_no_more_than_a_few_wait():
    """Those that were left first are closed, and in the end all are."""
    varied, opened = met(range(MOST_IDLE + 3))
    assert [simulation.is_closed for simulation in opened] == [True] * 2 + [False] * (MOST_IDLE + 1)
    varied.close()
    varied.close()
    assert all(simulation.is_closed for simulation in opened)


def test_arms_of_a_batch_do_not_touch_one_another():
    """A reset of one leaves the others, and those at rest are not driven."""
    varied = VariedSimulation(IdealSimulator(), lambda number: ROBOT, ROBOT.dof, 3, 0.1)
    varied.reset(np.tile(ROBOT.home, (3, 1)), np.ones(3, bool))
    varied.rest(np.array([False, True, False]))
    varied.drive(np.tile(ROBOT.home + 0.1, (3, 1)), 0.1)
    state = varied.reset(np.tile(ROBOT.home + 0.2, (3, 1)), np.array([True, False, False]))
    assert_allclose(state.qpos - ROBOT.home, np.array([[0.2], [0.0], [0.1]]) * np.ones(6))
    assert_allclose(state.end_effector, ROBOT.end_effector(state.qpos))

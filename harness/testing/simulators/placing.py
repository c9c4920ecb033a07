"""Arms that are put somewhere: they are there, at rest, and no other arm moves."""

import numpy as np

from harness.arrays import Float
from harness.robot import Robot
from harness.simulator import Simulator, State
from harness.testing.simulators.simulations import NUM_ENVS, drive_out_and_back, opened, part, poses_near_home, same
from harness.testing.violations import check, require

MAX_PLACEMENT_ERROR = 1e-6
"""[rad], or [m] where a joint slides."""


@check("sim-reset")
def reset_puts_the_arm_there_at_rest(simulator: Simulator, robot: Robot) -> None:
    """After `reset` the joints of the masked envs rest where the call put them, also after a motion."""
    with opened(simulator, robot) as simulation:
        drive_out_and_back(simulation, robot)
        qpos = poses_near_home(robot, NUM_ENVS)
        _require_there_at_rest(simulation.reset(qpos, np.ones(NUM_ENVS, bool)), qpos)


@check("sim-place")
def place_puts_the_arm_there_at_rest(simulator: Simulator, robot: Robot) -> None:
    """After `place` the joints of all envs rest where the call put them, also after a motion."""
    with opened(simulator, robot) as simulation:
        drive_out_and_back(simulation, robot)
        qpos = poses_near_home(robot, NUM_ENVS)
        _require_there_at_rest(simulation.place(qpos), qpos)


@check("sim-reset-mask")
def reset_leaves_the_other_envs_alone(simulator: Simulator, robot: Robot) -> None:
    """`reset` changes nothing in the envs outside its mask."""
    mask = np.arange(NUM_ENVS) == 0
    with opened(simulator, robot) as simulation:
        before = drive_out_and_back(simulation, robot)[-1]
        after = simulation.reset(poses_near_home(robot, NUM_ENVS), mask)
        require(same([part(before, ~mask)], [part(after, ~mask)]), "the envs outside the mask changed")


def _require_there_at_rest(state: State, qpos: Float) -> None:
    error = np.abs(state.qpos - qpos).max()
    require(error < MAX_PLACEMENT_ERROR, f"the joints are {error:.2g} rad or m from where they were put")
    require((state.qvel == 0.0).all(), f"the joints are not at rest: {state.qvel} rad/s or m/s")

"""What the environment costs on top of dm_control's own."""

from collections import OrderedDict

import numpy as np
import pytest
from dm_control import mujoco
from dm_control.rl import control
from dm_control.suite import base
from dm_control.utils import rewards
from numpy.linalg import norm
from numpy.testing import assert_array_equal

from harness_plugins.mujoco_model import TARGET, TOUCH

pytestmark = pytest.mark.bench
SUBSTEPS = 20


class Reach(base.Task):
    """The same task as those of the control suite are written: by name, with controls for actions.

    It shows what the harness shows (angles, speeds, accelerations, target, end effector, offset, distance) and ends
    where the harness ends an episode.
    """

    def __init__(self, starts: list[np.ndarray], tip: str, epsilon: float) -> None:
        super().__init__(random=0)
        self.starts, self.tip, self.epsilon = starts, tip, epsilon
        self.episode = 0

    def initialize_episode(self, physics):
        """The next start, [rad]."""
        physics.data.qpos[:] = physics.data.act[:] = self.starts[self.episode]
        self.episode += 1
        super().initialize_episode(physics)

    def to_target(self, physics):
        """From the end effector to the target, (3,), [m]."""
        return physics.named.data.xpos[TARGET] - physics.named.data.xpos[self.tip]

    def get_observation(self, physics):
        """What the harness shows to a learner."""
        xpos = physics.named.data.xpos
        return OrderedDict(
            position=physics.position(),
            velocity=physics.velocity(),
            acceleration=physics.data.qacc.copy(),
            target=xpos[TARGET].copy(),
            end_effector=xpos[self.tip].copy(),
            to_target=self.to_target(physics),
            distance=norm(self.to_target(physics)),
        )

    def get_reward(self, physics):
        """1 at the target, less around it."""
        return rewards.tolerance(norm(self.to_target(physics)), (0.0, self.epsilon), margin=1.0)

    def get_termination(self, physics):
        """At the target, or on the ground."""
        touched = physics.named.data.sensordata[TOUCH][0] > 0.0
        return 0.0 if touched or norm(self.to_target(physics)) <= self.epsilon else None


def recorded(arm, run):
    """What `run` tells an arm: where episodes start, and the controls of each period, None where one starts."""
    starts, told, set_control, reset = [], [], arm.physics.set_control, arm.reset
    arm.physics.set_control = lambda controls: (told.append(controls.copy()), set_control(controls))
    arm.reset = lambda: (starts.append(arm.task.start.copy()), told.append(None), reset())[-1]
    run()
    del arm.physics.set_control, arm.reset
    return starts, told


def test_one_env_beside_an_environment_of_dm_control(recorded_env, require_speed):
    """Observation, reward and trace on, one env does nearly as many steps as `control.Environment`."""
    env, through_the_env = recorded_env("dm_control", 500)

    arm = env.simulation.arms[0]
    starts, told = recorded(arm, through_the_env)
    physics = mujoco.Physics.from_model(arm.physics.model.copy())
    bare = control.Environment(
        physics, Reach(starts, env.robot.end_effector_link, env.task.epsilon), n_sub_steps=SUBSTEPS
    )

    def through_dm_control():
        bare.task.episode = 0
        for controls in told:
            _ = bare.reset() if controls is None else bare.step(controls)

    require_speed(through_dm_control, through_the_env, at_least=0.8)
    assert_array_equal(physics.position(), arm.physics.position())

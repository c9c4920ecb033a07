"""One arm in the world of one client. A client is a connection to Bullet that has a world of its own."""

import math
from pathlib import Path

import numpy as np
import pybullet

from harness import Float
from harness.robot import Robot
from harness.simulator import State, Substeps

from .free_arm import scale_masses, share_of
from .world import (
    BASE,
    LOAD_FLAGS,
    add_ground,
    contact_distances,
    exact_timestep,
    load_body,
    numbers,
    part_neighbours,
    set_iterations,
    set_joints,
    set_options,
    set_steps,
)

FORCE = 1e6
"""Largest force of a motor, [N m] or [N]: ideal drives are strong enough, no matter which effort a URDF gives."""
LEFT, MOST, POSES = 1e-3, 1_000, 16
"""What the solver may leave of an error, its iterations at most, and the random poses that tell how many it needs."""
NO_MASS = 1e-12
"""Added to a joint's inertia, [kg m^2] or [kg]: a matrix of zeros has no inverse."""
LINK, DISTANCE, NORMAL_FORCE = 3, 8, 9
"""The indices of these values in a contact point of Bullet's."""


class Arm:
    """One arm on the ground in the world of one client."""

    def __init__(
        self, client: int, robot: Robot, path: Path, substeps: Substeps, iterations: int, self_collision: bool = False
    ) -> None:
        self.client, self._substeps = client, substeps
        self._timestep, self._duration = exact_timestep(substeps.period, substeps.count), substeps.period
        set_options(client, self._timestep, substeps.count, iterations)
        flags = pybullet.URDF_USE_SELF_COLLISION if self_collision else 0
        self.body = load_body(client, robot, path, LOAD_FLAGS | pybullet.URDF_IGNORE_VISUAL_SHAPES | flags)
        links, self.joints = numbers(client, self.body, robot)
        if self_collision:
            part_neighbours(client, self.body, self.joints, robot.home)
        set_iterations(client, max(iterations, needed_iterations(client, self.body, robot)))
        self.forces = [FORCE] * robot.dof
        self.tip, self._touches = links[robot.end_effector_link], contact_distances(links, robot)
        self.ground = add_ground(client, self.body, self.joints)
        pybullet.changeDynamics(self.body, BASE, linearDamping=0.0, angularDamping=0.0, physicsClientId=client)
        self._new = pybullet.saveState(physicsClientId=client)
        self._has_moved = False

    def put(self, qpos: Float) -> None:
        """Put the arm at rest at `qpos`, (dof,), as if the world were new, contacts included."""
        pybullet.restoreState(self._new, physicsClientId=self.client)
        set_joints(self.client, self.body, self.joints, qpos)
        self._has_moved = False

    def turn(self, speeds: Float, duration: float) -> None:
        if duration != self._duration:
            set_steps(self.client, self._timestep, self._substeps.within(duration))
            self._duration = duration
        pybullet.setJointMotorControlArray(
            self.body, self.joints, pybullet.VELOCITY_CONTROL,
            targetVelocities=speeds.tolist(), forces=self.forces, physicsClientId=self.client,
        )  # fmt: skip
        pybullet.stepSimulation(physicsClientId=self.client)
        self._has_moved = True

    def read(self, state: State, env: int) -> None:
        client, has_moved, touches = self.client, self._has_moved, self._touches
        joints = pybullet.getJointStates(self.body, self.joints, physicsClientId=client)
        state.qpos[env] = [joint[0] for joint in joints]
        state.qvel[env] = [joint[1] for joint in joints]
        tip = pybullet.getLinkState(self.body, self.tip, computeForwardKinematics=1, physicsClientId=client)
        state.end_effector[env] = tip[4]  # the link's frame, not that of its inertia
        pybullet.performCollisionDetection(physicsClientId=client)  # a step leaves the contacts of its beginning
        points = pybullet.getContactPoints(self.body, self.ground, physicsClientId=client)
        state.ground_contact[env] = any(
            # Bullet also reports near misses. A point that bears a load is a contact. After `put`, loads are old.
            point[DISTANCE] <= touches[point[LINK]] or (has_moved and point[NORMAL_FORCE] > 0.0)
            for point in points
        )


def needed_iterations(client: int, body: int, robot: Robot) -> int:
    """How many iterations Bullet's solver needs until the motors hold their speeds up to `LEFT` of the error.

    It goes from one motor to the next, which is the method of Gauss and Seidel for the inverse of the mass matrix: each
    iteration leaves the spectral radius of that method. It is near 1 where a light link carries others, or is carried
    by a heavy one, as in arms of a few grams. With too few iterations such an arm is centimetres from its targets.
    """
    drawn = np.random.default_rng(0).uniform(robot.lower, robot.upper, (POSES, robot.dof))
    share, left = share_of(client, body, np.zeros(robot.dof)), 0.0
    if share < 1.0:
        scale_masses(client, body, share)  # which changes no share of an error
    for qpos in (robot.home, *drawn):
        mass = np.array(pybullet.calculateMassMatrix(body, qpos.tolist(), physicsClientId=client))
        response = np.linalg.inv(mass + NO_MASS * np.eye(robot.dof))
        before = np.tril(response)
        left = max(left, float(np.abs(np.linalg.eigvals(np.linalg.solve(before, before - response))).max()))
    if share < 1.0:
        scale_masses(client, body, 1.0 / share)
    return min(MOST, math.ceil(math.log(LEFT) / math.log(left))) if 0.0 < left < 1.0 else 1

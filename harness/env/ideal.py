"""Simulations without an engine: one whose joints are where they are told to be, one that keeps what it passes on."""

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import SchemaError, UsageError
from harness.record.progress import TrainingState, as_state
from harness.robot import Robot
from harness.robot.ground_clearance import build_solids
from harness.robot.kinematics import child_frames, link_frames
from harness.simulator import Simulation, State


@dataclass(frozen=True)
class IdealSimulator:
    """No dynamics and no delay. The ground is touched by a solid, or where the end effector or a joint is at z <= 0."""

    def open(self, robot: Robot, num_envs: int, control_period: float) -> "IdealSimulation":
        return IdealSimulation(robot, num_envs)


class IdealSimulation:
    """See `harness.simulator.Simulation`. Each call returns arrays of its own.

    Attributes:
        robot: The arm.
        qpos: Joint positions, (num_envs, dof), [rad].
        qvel: Joint velocities, (num_envs, dof), [rad/s].
    """

    def __init__(self, robot: Robot, num_envs: int) -> None:
        self.robot, self._solids = robot, build_solids(robot.joint_shapes)
        self.qpos = np.tile(robot.home, (num_envs, 1))
        self.qvel = np.zeros_like(self.qpos)
        self._asleep, self._awake = np.zeros(num_envs, bool), cast(NDArray[np.intp] | slice, slice(None))
        self._tip, self._contact = np.zeros((num_envs, 3)), np.zeros(num_envs, bool)

    def reset(self, qpos: Float, mask: Mask) -> State:
        self.qpos[mask], self.qvel[mask] = qpos[mask], 0.0
        self._let_sleep(self._asleep & ~mask)
        return self.state()

    def drive(self, qpos: Float, duration: float) -> State:
        self.qvel[:] = (qpos - self.qpos) / duration
        self.qpos[:] = qpos
        return self.state()

    def place(self, qpos: Float) -> State:
        self.qpos[:], self.qvel[:] = qpos, 0.0
        return self.state()

    def read(self) -> State:
        return self.state()

    def rest(self, mask: Mask) -> None:
        """Compute nothing of the arms of `mask`, (num_envs,), until they are reset or another mask is given."""
        self._let_sleep(mask)

    def _let_sleep(self, mask: Mask) -> None:
        self._asleep, self._awake = mask.copy(), np.flatnonzero(~mask) if mask.any() else slice(None)

    def state(self) -> State:
        """What every call tells."""
        qpos = self.qpos[self._awake]
        frames = child_frames(self.robot.chain, qpos)
        tip = (frames[-1] @ self.robot.chain.T_last_tip)[:, :3, 3]
        upward = np.array([frame[:, 2].T for frame in frames])
        heights = upward[1:, 3]  # the first joint's origin stands still
        contact = np.minimum(tip[:, 2], heights.min(axis=0, initial=np.inf)) <= 0.0
        near = self._solids.is_near_ground(upward) & ~contact
        if near.any():
            contact[near] = self._solids.touch_ground(link_frames(self.robot.chain, qpos[near]))
        self._tip[self._awake], self._contact[self._awake] = tip, contact
        return State(self.qpos.copy(), self.qvel.copy(), self._tip.copy(), self._contact.copy())

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """Raises UsageError, always."""
        raise UsageError("The ideal simulator has no renderer: take another simulator to see the arm")

    def close(self) -> None:
        """Does nothing: there is no engine."""


class LoggedSimulation:
    """Passes on every call, and keeps the calls since each arm's last reset.

    That is all that a checkpoint needs to hold of the physics, whatever the engine: what is reset and driven in the
    same way stands where the other stood, bit for bit. An episode is short: it is little to keep, and soon done again.
    """

    def __init__(self, simulation: Simulation, robot: Robot, num_envs: int) -> None:
        self._simulation = simulation
        self._starts = np.tile(robot.home, (num_envs, 1))
        self._placed = np.zeros(num_envs, bool)  # rather than reset
        self._begun = np.zeros(num_envs, int)  # so many of the drives came before
        self._drives: list[tuple[Float, float]] = []

    def reset(self, qpos: Float, mask: Mask) -> State:
        self._starts[mask], self._placed[mask], self._begun[mask] = qpos[mask], False, len(self._drives)
        over = int(self._begun.min())
        if over:
            del self._drives[:over]
            self._begun -= over
        return self._simulation.reset(qpos, mask)

    def drive(self, qpos: Float, duration: float) -> State:
        self._drives.append((qpos.copy(), duration))
        return self._simulation.drive(qpos, duration)

    def place(self, qpos: Float) -> State:
        self._starts[...], self._placed[:], self._begun[:] = qpos, True, 0
        self._drives.clear()
        return self._simulation.place(qpos)

    def read(self) -> State:
        return self._simulation.read()

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        return self._simulation.render(env, target, width, height)

    def close(self) -> None:
        self._simulation.close()

    def state(self) -> TrainingState:
        """The calls that brought the arms to where they are, and the present state."""
        seen = {f"seen.{name}": array.copy() for name, array in self.read()._asdict().items()}
        targets = np.array([qpos for qpos, _ in self._drives]).reshape(-1, *self._starts.shape)
        durations = np.array([duration for _, duration in self._drives], float)
        starts = {"starts": self._starts.copy(), "placed": self._placed.copy(), "begun": self._begun.copy()}
        return as_state({**starts, **seen, "targets": targets, "durations": durations})

    def restore(self, state: TrainingState) -> None:
        """Bring the arms to where those of `state` stood.

        Raises:
            SchemaError: They stand elsewhere: the simulator does not do the same again.
        """
        starts, placed, begun = (state[name] for name in ("starts", "placed", "begun"))
        if placed.any():
            self.place(starts)
        self._reset_again(starts, ~placed)
        for number, (targets, duration) in enumerate(zip(state["targets"], state["durations"], strict=True)):
            if number:
                self._reset_again(starts, begun == number)
            # An arm whose episode began later waits at its start.
            self.drive(np.where((begun <= number)[:, None], targets, starts), float(duration))
        if len(state["targets"]):
            self._reset_again(starts, begun == len(state["targets"]))
        for name, array in self.read()._asdict().items():
            if not np.array_equal(array, state[f"seen.{name}"], equal_nan=True):
                raise SchemaError(f"the simulator does not repeat itself: {name} differs after the same commands")

    def _reset_again(self, starts: Float, mask: Mask) -> None:
        if mask.any():
            self.reset(starts, mask)

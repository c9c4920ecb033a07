"""Commands to the arms of a batch: from actions to what the simulator does in a control period."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from harness.arrays import Float, Mask
from harness.motion import Motion, Move
from harness.simulator import Simulation, State


class Commands:
    """Joint targets. Each move of an arm begins where the move before it led.

    Attributes:
        qpos: Those commanded last, (num_envs, dof), [rad] or [m]; another array after every call.
    """

    def __init__(self, motion: Motion, num_envs: int, dof: int, duration: float) -> None:
        """Begin with all joints at rest at zero.

        Args:
            motion: Turns actions into moves.
            num_envs: How many arms.
            dof: Joints of each.
            duration: A control period, [s].
        """
        self._motion, self._jumps, self._duration = motion, motion.jumps, duration
        self.qpos, self._qvel = np.zeros((num_envs, dof)), np.zeros((num_envs, dof))

    def begin(self, mask: Mask, qpos: Float) -> None:
        """Begin anew with the arms of `mask`, which rest at `qpos`, (num_envs, dof)."""
        self.qpos, self._qvel = qpos, self._qvel.copy()
        self._qvel[mask] = 0.0

    def advance(self, action: Float) -> Move:
        """The next move. The joint targets to which it leads become the last commanded ones.

        Args:
            action: (num_envs, action_size).
        """
        move = self._motion.advance(self.qpos, self._qvel, action)
        self.qpos, self._qvel = move.waypoints[-1], move.qvel
        return move

    def drive(self, simulation: Simulation, move: Move) -> tuple[State, Mask]:
        """Let the engine do a move; contact with the ground, (num_envs,), counts at any of its waypoints."""
        if self._jumps:
            state = simulation.place(move.waypoints[-1])
            return state, state.ground_contact
        if len(move.waypoints) == 1:
            state = simulation.drive(move.waypoints[0], self._duration)
            return state, state.ground_contact
        ground = np.zeros(len(self.qpos), bool)
        for waypoint in move.waypoints:
            state = simulation.drive(waypoint, self._duration / len(move.waypoints))
            ground |= state.ground_contact
        return state, ground

    def state(self) -> dict[str, Any]:
        """Everything that `restore` needs."""
        return {"command": self.qpos.copy(), "command_speed": self._qvel.copy()}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`, which the method of this name returned."""
        self.qpos, self._qvel = state["command"].copy(), state["command_speed"].copy()

"""A simulation that knows how its arms came to where they are, so that another one can bring its arms there."""

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import SchemaError
from harness.progress import TrainingState, as_state
from harness.robot import Robot
from harness.simulator import Simulation, State


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

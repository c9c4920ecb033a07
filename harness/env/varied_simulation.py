"""One simulation of many arms that differ. Each arm has an engine of its own."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.robot import Robot
from harness.simulator import Simulation, Simulator, State

MOST_IDLE = 16
"""The most unused simulations that are kept open. The one that was left first is closed first."""
ALONE = np.ones(1, bool)


class VariedSimulation:
    """`num_envs` simulations of one arm, of any simulator. An env gets the arm that `arms` names at its next reset.

    Simulations are opened when first met, and kept for the next env that draws the same arm.

    Attributes:
        arms: Number of the arm that each env is to have, (num_envs,).
    """

    def __init__(
        self, simulator: Simulator, robot: Callable[[int], Robot], dof: int, num_envs: int, control_period: float
    ) -> None:
        """Open nothing yet.

        Args:
            simulator: Of all arms.
            robot: The arm of a number.
            dof: Joints of each.
            num_envs: How many envs.
            control_period: See `harness.simulator.Simulator.open`.
        """
        self.arms: NDArray[np.int64] = np.zeros(num_envs, np.int64)
        self._simulator, self._robot, self._period = simulator, robot, control_period
        self._present = np.full(num_envs, -1)
        self._open: list[Simulation | None] = [None] * num_envs
        self._idle: list[tuple[int, Simulation]] = []
        self._awake = np.ones(num_envs, bool)
        joints = (num_envs, dof)
        self._state = State(np.zeros(joints), np.zeros(joints), np.zeros((num_envs, 3)), np.zeros(num_envs, bool))

    def reset(self, qpos: Float, mask: Mask) -> State:
        """See `harness.simulator.Simulation`."""
        self._awake |= mask
        for k in np.flatnonzero(mask).tolist():
            self._copy(k, self._take(k).reset(qpos[k : k + 1], ALONE))
        return self._state

    def drive(self, qpos: Float, duration: float) -> State:
        """See `harness.simulator.Simulation`."""
        for k in np.flatnonzero(self._awake).tolist():
            self._copy(k, self._arm(k).drive(qpos[k : k + 1], duration))
        return self._state

    def place(self, qpos: Float) -> State:
        """See `harness.simulator.Simulation`."""
        for k in np.flatnonzero(self._awake).tolist():
            self._copy(k, self._arm(k).place(qpos[k : k + 1]))
        return self._state

    def read(self) -> State:
        """See `harness.simulator.Simulation`."""
        return self._state

    def rest(self, mask: Mask) -> None:
        """See `harness.simulator.Simulation`."""
        self._awake = ~mask

    def render(self, env: int, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """See `harness.simulator.Simulation`."""
        return self._arm(env).render(0, target, width, height)

    def close(self) -> None:
        """See `harness.simulator.Simulation`."""
        for simulation in (*self._open, *(idle for _, idle in self._idle)):
            if simulation is not None:
                simulation.close()
        self._open, self._idle = [None] * len(self._open), []

    def _arm(self, env: int) -> Simulation:
        return self._open[env] or self._take(env)

    def _take(self, env: int) -> Simulation:
        """Give an env the simulation of its next arm. Its last simulation waits for another env."""
        wanted, present = int(self.arms[env]), self._open[env]
        if present is None or self._present[env] != wanted:
            if present is not None:
                self._idle.append((int(self._present[env]), present))
            self._open[env] = present = self._idle_one(wanted) or self._start(wanted)
            self._present[env] = wanted
            while len(self._idle) > MOST_IDLE:
                self._idle.pop(0)[1].close()
        return present

    def _idle_one(self, wanted: int) -> Simulation | None:
        place = next((place for place, (arm, _) in enumerate(self._idle) if arm == wanted), None)
        return None if place is None else self._idle.pop(place)[1]

    def _start(self, arm: int) -> Simulation:
        return self._simulator.open(self._robot(arm), 1, self._period)

    def _copy(self, env: int, state: State) -> None:
        for mine, of_one in zip(self._state, state, strict=True):
            mine[env] = of_one[0]

"""The mechanical work of the episodes of an evaluation, measured from the rows that it leaves."""

import numpy as np

from harness.arrays import Float
from harness.env.make import World
from harness.record.trace import COLUMN, SCALARS, Recorder, Rows
from harness.robot.energy import least_work, read_bodies


class WorkMeter:
    """A `Recorder` that hands on its rows, and keeps the joint positions in each env's first episode."""

    def __init__(self, recorder: Recorder, world: World) -> None:
        self._recorder, self._world = recorder, world
        jumps = world.task.motion(world.robot).jumps
        self._bodies = None if jumps else read_bodies(world.robot)
        self._kept: list[Float] = []
        self._columns = [COLUMN["env"], *range(len(SCALARS), len(SCALARS) + world.robot.dof)]

    def append(self, rows: Rows) -> None:
        """See `Recorder`."""
        self._recorder.append(rows)
        if self._bodies is not None:
            self._kept.append(rows[rows[:, COLUMN["episode"]] == 0.0][:, self._columns])

    def work(self) -> tuple[float, ...] | None:
        """The work by env, [J]; None if the arm jumps from pose to pose, or if its links have no mass."""
        if self._bodies is None:
            return None
        rows = np.concatenate(self._kept)
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        episodes = np.split(rows[:, 1:], np.flatnonzero(np.diff(rows[:, 0])) + 1)
        chain, period = self._world.robot.chain, self._world.task.control_period
        return tuple(least_work(chain, self._bodies, qpos, period) for qpos in episodes)

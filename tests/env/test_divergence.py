"""A simulation that leaves the finite numbers."""

import numpy as np
import pytest

from harness.env import IdealSimulation
from harness.errors import SimulationDiverged
from harness.record import TraceWriter
from harness_plugins.kit import IdealSimulator


class LosesTheEndEffector(IdealSimulation):
    """After a drive the end effector of env 1 is nowhere."""

    number = np.nan

    def drive(self, qpos, duration):
        """As any drive, but for env 1."""
        state = super().drive(qpos, duration)
        state.end_effector[1] = self.number
        return state


class LosesItAtInfinity(LosesTheEndEffector):
    """The same, with a number that can be compared."""

    number = np.inf


def simulator_of(simulation):
    """The simulator that opens a simulation."""

    class Simulator(IdealSimulator):
        def open(self, robot, num_envs, control_period):
            return simulation(robot, num_envs)

    return Simulator()


def test_diverging_simulation_is_told_at_once(make, stand):
    """A number that is none raises SimulationDiverged in the step where it comes, with the env and the step."""
    env = make(3, simulator=simulator_of(LosesTheEndEffector), seed=0)
    with pytest.raises(SimulationDiverged, match=r"env \[1\] is nowhere at step 1"):
        stand(env)


def test_diverging_simulation_never_gets_into_a_trace(tmp_path, make, stand):
    """An infinite number raises SimulationDiverged when the trace is written, at the latest."""
    recorder = TraceWriter(tmp_path / "trace.parquet", dof=6, action_size=6)
    stand(make(3, simulator=simulator_of(LosesItAtInfinity), recorder=recorder, seed=0))
    with pytest.raises(SimulationDiverged, match="distance is not finite at env 1, episode 0, step 1"):
        recorder.close()

"""Numbers of an arm that are not finite: none gets to a learner or into a trace, whatever they are of."""

import numpy as np
import pytest

from harness.env.ideal import IdealSimulation
from harness.errors import SimulationDiverged
from harness.record import TraceWriter, read_trace
from harness_plugins.kit import IdealSimulator


def _simulator_of(field, number, late):
    """One whose env 1 says such a number in one field after so many drives."""

    class Loses(IdealSimulation):
        drives = 0

        def drive(self, qpos, duration):
            state = super().drive(qpos, duration)
            self.drives += 1
            if self.drives == late:
                getattr(state, field)[1, 1] = number
            return state

    class Simulator(IdealSimulator):
        def open(self, robot, num_envs, control_period):
            return Loses(robot, num_envs)

    return Simulator()


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("late", [1, 3])
@pytest.mark.parametrize("field", ["end_effector", "qpos", "qvel"])
def test_a_simulation_that_diverges_is_told_at_once(make, stand, tmp_path, field, number, late):
    """With field, step and env; the trace has the starts and all steps before, and not that one."""
    path = tmp_path / "trace.parquet"
    recorder = TraceWriter(path, dof=6, action_size=6)
    env = make(3, simulator=_simulator_of(field, number, late), recorder=recorder, seed=0)
    for _ in range(late - 1):
        stand(env)
    told = "NaN" if np.isnan(number) else "infinite"
    with pytest.raises(SimulationDiverged, match=f"{field} 1 was {told} at step {late} of episode 0, env 1"):
        stand(env)
    recorder.close()
    assert len(read_trace(path)) == 3 * late


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
def test_an_action_that_is_not_finite_moves_no_arm(make, number):
    """It is refused before the simulator is told anything."""
    env, actions = make(3, seed=0), np.zeros((3, 6))
    before = env.simulation.read().qpos.copy()
    actions[2, 4] = number
    with pytest.raises(SimulationDiverged, match=r"action 4 was .* at step 1 of episode 0, env 2"):
        env.step(actions)
    np.testing.assert_array_equal(env.simulation.read().qpos, before)


def test_an_arm_at_rest_may_say_anything(make, stand):
    """Its episode is over: nothing of it is used."""
    env = make(3, simulator=_simulator_of("qpos", np.nan, 2), seed=0)
    stand(env)
    env.rest(np.array([False, True, False]))
    stand(env)

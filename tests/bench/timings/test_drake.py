"""What the environment costs on top of Drake."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from harness import load_registry

pytestmark = pytest.mark.bench
SUBSTEPS, PERIOD = 20, 0.1


def bare_loop(arm, told):
    """The API alone: torques, the steps of a period in one call, and what is read at the end.

    Args:
        arm: In a context of its own.
        told: What the arm is told, in this order: a pose to start at, [rad], or the speeds of a period, [rad/s].
    """
    model, simulator, context = arm.model, arm.simulator, arm.context
    plant, root = model.plant, simulator.get_mutable_context()
    servos = plant.get_actuation_input_port(model.arm)
    query, shapes = model.shapes.get_query_output_port(), model.shapes.GetMyContextFromRoot(root)

    def run():
        steps = 0
        for what, values in told:
            if what == "put":
                steps = 0
                root.SetTime(0.0)
                plant.SetPositions(context, values)  # the FD100's joints are in Drake's order
                plant.SetVelocities(context, np.zeros_like(values))
                simulator.Initialize()
                continue
            servos.FixValue(context, arm._damping * values)
            steps += SUBSTEPS
            simulator.AdvanceTo((steps - 0.5) * PERIOD / SUBSTEPS)
            plant.GetPositions(context)
            plant.GetVelocities(context)
            plant.EvalBodyPoseInWorld(context, model.tip).translation()
            query.Eval(shapes).HasCollisions()

    return run


def recorded(arm, run):
    """What `run` tells an arm."""
    told = []
    put, turn = arm.put, arm.turn
    arm.put = lambda qpos: (told.append(("put", qpos.copy())), put(qpos))
    arm.turn = lambda speeds, duration: (told.append(("turn", speeds.copy())), turn(speeds, duration))
    run()
    arm.put, arm.turn = put, turn
    return told


def test_one_env_beside_the_bare_loop(recorded_env, require_speed):
    """Observation, reward and trace on, one env does most of the steps of the bare API on the same motion."""
    pytest.importorskip("pydrake", reason="pydrake is not installed: pip install 'fd100-harness[drake]'")
    env, through_the_env = recorded_env("drake", 300)
    (reference,) = load_registry().get("simulators", "drake").load()(substeps=SUBSTEPS).open(env.robot, 1, PERIOD).arms

    (arm,) = env.simulation.arms
    require_speed(bare_loop(reference, recorded(arm, through_the_env)), through_the_env, at_least=0.7)
    first, second = (one.model.plant.GetPositions(one.context) for one in (reference, arm))
    assert_array_equal(first, second)

"""What tests of the simulators need: arms at home, moves, and another opinion on where the ground is."""

from dataclasses import replace
from functools import partial
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness.motion.motion import MoveJ
from harness.robot import parse_urdf
from harness.robot.shapes import attach_shapes, read_shapes
from harness.simulator import State
from tests.registered import FD100 as ROBOT, REGISTRY

PERIOD = 0.1
FALLEN = np.radians([[0.0, 120.0, 0.0, 0.0, 0.0, 0.0]])
"""A pose deep in the ground, (1, dof)."""
MOVING_LINKS = ("link2", "link3", "link4", "link5", "link6", "tool0")
"""Those that can get to the ground: the first one turns above it."""
MOTION = MoveJ.within_limits(ROBOT, speed=0.8, acceleration=0.6, period=PERIOD)


def home(num_envs):
    """The home pose for each of so many envs."""
    return np.tile(ROBOT.home, (num_envs, 1))


def open_simulator(simulator, num_envs, robot=ROBOT, period=PERIOD, **settings):
    """Opens arms at home, given the simulator's name; a simulation closes itself when nothing holds it any more."""
    simulation = REGISTRY.get("simulators", simulator).load()(**settings).open(robot, num_envs, period)
    simulation.reset(np.tile(robot.home, (num_envs, 1)), np.ones(num_envs, bool))
    return simulation


def random_poses(count):
    """So many poses anywhere in the joint ranges."""
    return default_rng(1).uniform(ROBOT.lower, ROBOT.upper, (count, ROBOT.dof))


def copied(state):
    """A state that outlives the next call."""
    return State._make(np.array(array) for array in state)


def wander(simulation, num_envs, periods, seed=0):
    """Random moves at full speed, some of them held for a while; an arm that touches the ground is reset to home.

    Returns copies of the states, and the targets of the joints, (periods, num_envs, dof).
    """
    rng = default_rng(seed)
    target, speed, states, targets = home(num_envs), np.zeros((num_envs, ROBOT.dof)), [], []
    for period in range(periods):
        if period % 4 == 0:
            action = rng.uniform(-2.0, 2.0, (num_envs, ROBOT.dof))
        (target,), speed, _ = MOTION.advance(target, speed, action)
        states.append(copied(simulation.drive(target, PERIOD)))
        targets.append(target)
        touching = states[-1].ground_contact
        if touching.any():
            target, speed = np.where(touching[:, None], ROBOT.home, target), np.where(touching[:, None], 0.0, speed)
            simulation.reset(target, touching)
    return states, np.array(targets)


def assert_same(first, second):
    """The states are the same, bit for bit."""
    for one, other in zip(first, second, strict=True):
        for field, array, another in zip(State._fields, one, other, strict=True):
            assert_array_equal(array, another, err_msg=field)


def press(simulation, periods=20):
    """Drives an arm into the ground, over 2 s or as many periods as said; returns copies of the states."""
    ways = np.linspace(0.0, 1.0, periods)[:, None, None] * (FALLEN - ROBOT.home)
    return [copied(simulation.drive(ROBOT.home + way, PERIOD)) for way in ways]


def bare_model(robot):
    """The arm on a plane, and nothing else."""
    spec = mujoco.MjSpec.from_string(robot.urdf)
    spec.compiler.fusestatic = False
    spec.worldbody.add_geom(name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3.0, 3.0, 0.1])
    return spec.compile()


BARE = bare_model(ROBOT)


def lowest_height(pose, model=BARE):
    """Distance of the moving links from the ground [m], negative inside it, by MuJoCo's geometry of the URDF alone."""
    data = mujoco.MjData(model)
    data.qpos[:] = pose
    mujoco.mj_kinematics(model, data)
    ground = model.geom("ground").id
    moving = [geom for geom in range(model.ngeom) if model.body(model.geom_bodyid[geom]).name in MOVING_LINKS]
    return min(mujoco.mj_geomDistance(model, data, ground, geom, 3.0, None) for geom in moving)


def with_urdf(tree):
    """The arm with another URDF."""
    urdf = parse_urdf(ElementTree.tostring(tree, encoding="unicode"))
    shapes = read_shapes(urdf)
    attached = attach_shapes(urdf, shapes, ROBOT.joint_names)
    return replace(ROBOT, urdf=urdf.text, link_shapes=shapes, joint_shapes=attached)


def only_shape_of(link):
    """The arm without the shapes of all links but one."""
    tree = ElementTree.fromstring(ROBOT.urdf)
    for element in tree.findall("link"):
        for shape in [*element.findall("collision"), *element.findall("visual")]:
            if element.get("name") != link:
                element.remove(shape)
    return with_urdf(tree)


@pytest.fixture
def simulator(request):
    """The one that the file is about, where a test does not say which."""
    return request.path.stem.removeprefix("test_")


@pytest.fixture
def open_arms(simulator, installed):
    """The same for the `simulator` that the test is about."""
    return partial(open_simulator, simulator)

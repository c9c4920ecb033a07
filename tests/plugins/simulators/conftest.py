"""What tests of the simulators need: arms at home, moves, and another opinion on where the ground is."""

from dataclasses import replace
from functools import partial
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

import harness
from harness.motion import MoveJ
from harness.registry import load_registry
from harness.robot import attach_shapes, parse_urdf, read_shapes
from harness.simulator import State

REGISTRY = load_registry()
ROBOT = harness.load_robot("fd100")
PERIOD = 0.1
MOTION = MoveJ.within_limits(ROBOT, speed=0.8, acceleration=0.6, period=PERIOD)


def _home(num_envs):
    return np.tile(ROBOT.home, (num_envs, 1))


def _open(simulator, num_envs, robot=ROBOT, period=PERIOD, **settings):
    simulation = REGISTRY.get("simulators", simulator).load()(**settings).open(robot, num_envs, period)
    simulation.reset(_home(num_envs), np.ones(num_envs, bool))
    return simulation


def _random_poses(count):
    return np.random.default_rng(1).uniform(ROBOT.lower, ROBOT.upper, (count, ROBOT.dof))


def _copied(state):
    return State._make(np.array(array) for array in state)


def _wander(simulation, num_envs, periods, seed=0):
    rng = np.random.default_rng(seed)
    target, speed, states, targets = _home(num_envs), np.zeros((num_envs, ROBOT.dof)), [], []
    for period in range(periods):
        if period % 4 == 0:
            action = rng.uniform(-2.0, 2.0, (num_envs, ROBOT.dof))
        (target,), speed, _ = MOTION.advance(target, speed, action)
        states.append(_copied(simulation.drive(target, PERIOD)))
        targets.append(target)
        touching = states[-1].ground_contact
        if touching.any():
            target, speed = np.where(touching[:, None], ROBOT.home, target), np.where(touching[:, None], 0.0, speed)
            simulation.reset(target, touching)
    return states, np.array(targets)


def _assert_same(first, second):
    for one, other in zip(first, second, strict=True):
        for field, array, another in zip(State._fields, one, other, strict=True):
            np.testing.assert_array_equal(array, another, err_msg=field)


def _bare_model():
    """The arm on a plane, and nothing else."""
    spec = mujoco.MjSpec.from_string(ROBOT.urdf)
    spec.compiler.fusestatic = False
    spec.worldbody.add_geom(name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3.0, 3.0, 0.1])
    return spec.compile()


BARE = _bare_model()


def _lowest_height(moving_links, pose):
    data = mujoco.MjData(BARE)
    data.qpos[:] = pose
    mujoco.mj_kinematics(BARE, data)
    ground = BARE.geom("ground").id
    moving = [geom for geom in range(BARE.ngeom) if BARE.body(BARE.geom_bodyid[geom]).name in moving_links]
    return min(mujoco.mj_geomDistance(BARE, data, ground, geom, 3.0, None) for geom in moving)


def _with_urdf(tree):
    urdf = parse_urdf(ElementTree.tostring(tree, encoding="unicode"))
    shapes = read_shapes(urdf)
    attached = attach_shapes(urdf, shapes, ROBOT.joint_names)
    return replace(ROBOT, urdf=urdf.text, link_shapes=shapes, joint_shapes=attached)


def _only_shape_of(link):
    tree = ElementTree.fromstring(ROBOT.urdf)
    for element in tree.findall("link"):
        for shape in [*element.findall("collision"), *element.findall("visual")]:
            if element.get("name") != link:
                element.remove(shape)
    return _with_urdf(tree)


@pytest.fixture(scope="session")
def open_simulator():
    """Opens arms at home, given the simulator's name; a simulation closes itself when nothing holds it any more."""
    return _open


@pytest.fixture
def open_arms(simulator, installed):
    """The same for the `simulator` that the test is about."""
    return partial(_open, simulator)


@pytest.fixture
def home():
    """The home pose for each of so many envs."""
    return _home


@pytest.fixture
def fallen():
    """A pose deep in the ground, (1, dof)."""
    return np.radians([[0.0, 120.0, 0.0, 0.0, 0.0, 0.0]])


@pytest.fixture(scope="session")
def random_poses():
    """So many poses anywhere in the joint ranges."""
    return _random_poses


@pytest.fixture
def copied():
    """A state that outlives the next call."""
    return _copied


@pytest.fixture(scope="session")
def wander():
    """Random moves at full speed, some of them held for a while; an arm that touches the ground is reset to home.

    Returns copies of the states, and the targets of the joints, (periods, num_envs, dof).
    """
    return _wander


@pytest.fixture
def assert_same():
    """The states are the same, bit for bit."""
    return _assert_same


@pytest.fixture
def moving_links():
    """Those that can get to the ground: the first one turns above it."""
    return ("link2", "link3", "link4", "link5", "link6", "tool0")


@pytest.fixture
def lowest_height(moving_links):
    """Distance of the moving links from the ground [m], negative inside it, by MuJoCo's geometry of the URDF alone."""
    return partial(_lowest_height, moving_links)


@pytest.fixture
def with_urdf():
    """The arm with another URDF."""
    return _with_urdf


@pytest.fixture
def only_shape_of():
    """The arm without the shapes of all links but one."""
    return _only_shape_of

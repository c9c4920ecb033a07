"""What every simulator does, beside the contract: arms go where they are told, ground contact, settings, frames."""

import importlib.util
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harness
from harness import load_registry
from tests.plugins.simulators.conftest import (
    FALLEN,
    MOVING_LINKS,
    PERIOD,
    REGISTRY,
    ROBOT,
    assert_same,
    copied,
    home,
    lowest_height,
    only_shape_of,
    press,
    random_poses,
    wander,
    with_urdf,
)
from tests.refusals import refused

FASTEST = 0.95 * 0.8 * ROBOT.max_speed
FOLLOWING = {"kinematic": 1e-9, "physx": 0.05, "pybullet": 0.05}
"""How far a joint may be off its target on the way [degrees]; else 0.5."""
RESTING = {"pybullet": 0.01}
"""How far a joint that rests [degrees]; else 0.001."""
ENGINES = {
    "dm_control": "dm_control", "drake": "pydrake", "mjx": "jax", "mujoco": "mujoco", "physx": "sapien",
    "pybullet": "pybullet",
}  # fmt: skip
"""What a simulator needs to be installed."""
ROUNDING = {"physx": 1e-6}
"""Of a joint position [rad] or place [m], of engines that compute in single precision; else 1e-12."""
BAD_SETTINGS = {
    "dm_control": ["substeps=0", "substeps=1.5", "bandwidth=0", "bandwidth=nan", "threads=2", "drive=strong"],
    "drake": ["substeps=0", "substeps=1.5", "bandwidth=0", "bandwidth=nan", "threads=2"],
    "kinematic": ["substeps=20", "drive=servo", "self_collision=true"],
    "mjx": ["substeps=0", "substeps=1.5", "bandwidth=0", "bandwidth=nan", "at_once=-1", "drive=servo"],
    "mujoco": ["substeps=0", "substeps=1.5", "bandwidth=0", "bandwidth=nan", "threads=0", "gpu=1", "drive=strong"],
    "physx": ["substeps=0", "substeps=1.5", "iterations=0", "iterations=256", "gpu=1"],
    "pybullet": ["substeps=0", "substeps=1.5", "iterations=0", "gpu=1"],
}

every_simulator = pytest.mark.parametrize("simulator", REGISTRY.names("simulators"))
every_engine = pytest.mark.parametrize("simulator", ENGINES)


def degrees_off(qpos, target):
    """Of the joint that is furthest from its target."""
    return float(np.degrees(np.abs(qpos - target).max()))


@every_simulator
@pytest.mark.parametrize("num_envs", [1, 8])
def test_joints_follow_random_moves_at_full_speed(simulator, num_envs, open_arms):
    """Over hundreds of random moves no joint in the air is ever further off its target than its engine allows."""
    states, targets = wander(open_arms(num_envs), num_envs, periods=1200 // num_envs)
    in_the_air = ~np.array([state.ground_contact for state in states])
    speeds = np.array([np.abs(state.qvel) for state in states])[in_the_air]
    assert in_the_air.sum() > 900
    assert (speeds.max(axis=0) > FASTEST).all()
    qpos = np.array([state.qpos for state in states])
    assert degrees_off(qpos[in_the_air], targets[in_the_air]) < FOLLOWING.get(simulator, 0.5)


@every_simulator
def test_arm_that_is_told_to_stay_stays(simulator, open_arms):
    """Gravity does not pull the arm down: after 10 s every joint is at home."""
    simulation = open_arms(1)
    for _ in range(100):
        state = simulation.drive(home(1), PERIOD)
    assert degrees_off(state.qpos, home(1)) < RESTING.get(simulator, 1e-3)


@every_simulator
def test_errors_do_not_add_up(simulator, open_arms):
    """After 400 small moves there and back the joints are where they began."""
    simulation = open_arms(1)
    for period in range(400):
        simulation.drive(home(1) + 0.03 * np.sin(0.1 * (period + 1)), PERIOD)
    for _ in range(20):
        state = simulation.drive(home(1), PERIOD)
    assert degrees_off(state.qpos, home(1)) < RESTING.get(simulator, 1e-3)


@every_simulator
def test_placed_arm_stays_where_it_is_placed(simulator, open_arms):
    """After `place` the servos hold the new pose: driving to it moves nothing."""
    simulation, pose = open_arms(1), home(1) + 0.5
    simulation.place(pose)
    assert degrees_off(simulation.drive(pose, PERIOD).qpos, pose) < RESTING.get(simulator, 1e-3)


@every_simulator
def test_joints_are_in_the_order_of_the_robot(simulator, open_arms):
    """Where each joint is told another angle, each has its own."""
    pose = np.radians([[-50.0, -30.0, 20.0, 70.0, 110.0, 200.0]])
    assert_allclose(open_arms(1).place(pose).qpos, pose, atol=ROUNDING.get(simulator, 1e-12))


@every_simulator
def test_order_of_the_elements_in_the_urdf_does_not_matter(simulator, open_arms):
    """A URDF that lists its joints and links backwards is the same arm."""
    tree = ElementTree.fromstring(ROBOT.urdf)
    tree[:] = tree[::-1]
    first, second = (open_arms(1, robot).place(random_poses(1)) for robot in (ROBOT, with_urdf(tree)))
    rounding = ROUNDING.get(simulator, 1e-12)
    assert_allclose(first.qpos, second.qpos, atol=rounding)
    assert_allclose(first.end_effector, second.end_effector, atol=rounding)


@pytest.fixture
def contacts(open_arms):
    """Whether an arm touches the ground at each of some poses, (len(poses),)."""

    def place(robot, poses):
        simulation = open_arms(1, robot)
        return np.array([simulation.place(pose[None]).ground_contact[0] for pose in poses])

    return place


@every_simulator
def test_ground_contact_is_that_of_the_geometry(contacts):
    """On 200 random poses there is contact exactly where a moving link's shape is below the ground."""
    poses = random_poses(200)
    contact, heights = contacts(ROBOT, poses), np.array([lowest_height(pose) for pose in poses])
    clear = np.abs(heights) > 1e-3
    assert 20 < contact.sum() < 180
    assert_array_equal(contact[clear], heights[clear] < 0.0)


@every_simulator
def test_every_moving_link_touches_the_ground(contacts):
    """An arm of which only one link has a shape touches the ground with it."""
    touching = {link: contacts(only_shape_of(link), random_poses(150)).any() for link in MOVING_LINKS}
    assert touching == dict.fromkeys(MOVING_LINKS, True)


@every_simulator
@pytest.mark.parametrize("is_mounted", [False, True])
def test_base_does_not_touch_the_ground(contacts, is_mounted):
    """The base, which stands on the ground, is no contact; nor is one that the URDF's root carries."""
    tree = ElementTree.fromstring(only_shape_of("base_link").urdf)
    if is_mounted:
        tree.insert(0, ElementTree.fromstring('<link name="world"/>'))
        mount = '<joint name="mount" type="fixed"><parent link="world"/><child link="base_link"/></joint>'
        tree.append(ElementTree.fromstring(mount))
    assert not contacts(with_urdf(tree), random_poses(100)).any()


@every_simulator
def test_links_do_not_touch_one_another(simulator, open_arms):
    """Folded into itself high above the ground, the arm touches nothing and is not pushed apart."""
    folded = np.radians([[0.0, -60.0, 80.0, 0.0, 135.0, 0.0]])
    assert lowest_height(folded[0]) > 0.1
    simulation = open_arms(1)
    assert not simulation.place(folded).ground_contact.any()
    assert degrees_off(simulation.drive(folded, PERIOD).qpos, folded) < RESTING.get(simulator, 1e-3)


@every_simulator
@pytest.mark.parametrize("begins_fallen", [False, True])
def test_reset_in_the_middle_forgets_all(open_arms, begins_fallen):
    """After moves, contacts and resets an arm goes on, bit for bit, as a new one: from home, and from in the ground."""
    start, used, runs = FALLEN if begins_fallen else home(1), open_arms(1), []
    wander(used, 1, 300, seed=1)
    used.place(FALLEN)
    for _ in range(3):
        used.drive(FALLEN + 0.1, PERIOD)
    for simulation in (used, open_arms(1)):
        first = copied(simulation.reset(start, np.ones(1, bool)))
        held = [copied(simulation.drive(start, PERIOD)) for _ in range(5)]
        runs.append([first, *held, *wander(simulation, 1, 200)[0]])
    assert_same(*runs)


@every_simulator
def test_reset_of_one_arm_does_not_touch_the_others(open_arms):
    """An arm beside one that is reset again and again moves, bit for bit, as one alone."""
    pair, alone = open_arms(2), open_arms(1)
    for period in range(40):
        target = home(1) + 0.3 * np.sin(0.1 * period)
        state = copied(pair.drive(np.repeat(target, 2, 0), PERIOD))
        assert_same([type(state)._make(array[1:] for array in state)], [alone.drive(target, PERIOD)])
        pair.reset(np.repeat(FALLEN, 2, 0), np.array([True, False]))


loose_contacts = pytest.mark.parametrize("simulator", ["physx", "pybullet"])


@loose_contacts
def test_ground_contact_is_that_of_the_end_of_the_period(open_arms):
    """Contact is told of the joint positions that are told with it, not of those of the physics step before."""
    states, _ = wander(open_arms(1), 1, 600)
    told = np.array([state.ground_contact[0] for state in states])
    heights = np.array([lowest_height(state.qpos[0]) for state in states])
    clear = np.abs(heights) > 3e-3  # a loaded contact may hover
    assert told.sum() > 5
    assert_array_equal(told[clear], heights[clear] < 0.0)


@loose_contacts
def test_arm_that_was_held_up_by_the_ground_catches_up(open_arms):
    """Targets below the ground, asked for over 2 s, are forgotten with the first target above it."""
    simulation = open_arms(1)
    held = press(simulation)[-1].qpos
    assert degrees_off(held, FALLEN) > 5.0
    above = held + np.radians([[0.0, -5.0, 0.0, 0.0, 0.0, 0.0]])
    assert degrees_off(simulation.drive(above, PERIOD).qpos, above) < 0.5


@pytest.mark.parametrize(("simulator", "depth"), [("drake", 0.02), ("physx", 5e-3), ("pybullet", 5e-3)])
def test_pressed_on_arm_touches_the_ground(open_arms, depth):
    """An arm that pushes against the ground touches it in every period, also while its engine lets it hover.

    Its end effector sinks in by 2 cm at most in Drake, else by 5 mm.
    """
    simulation = open_arms(1)
    press(simulation)
    for _ in range(50):
        state = simulation.drive(FALLEN, PERIOD)
        assert state.ground_contact[0]
    assert state.end_effector[0, 2] > -depth


@pytest.mark.parametrize(("simulator", "engine"), [("drake", "Drake"), ("physx", "SAPIEN")])
def test_urdf_that_cannot_be_read_is_a_usage_error(open_arms, engine):
    """One line names the robot."""
    broken = replace(ROBOT, urdf=ROBOT.urdf.replace('<mass value="', '<mass value="heavy'))
    with refused(f"^{engine} cannot load the URDF of robot 'fd100': [^\\n]*$"):
        open_arms(1, broken)


@pytest.mark.parametrize(("simulator", "given"), [(name, given) for name, bad in BAD_SETTINGS.items() for given in bad])
def test_bad_setting_is_a_usage_error(installed, simulator, given):
    """A setting that cannot be is refused, in one line that names it."""
    with refused(given.partition("=")[0]):
        harness.make_env(f"{simulator}:{given}")


@every_engine
def test_without_the_library_the_extra_is_named(simulator, monkeypatch):
    """Where the engine is not installed, the simulator is listed as missing, with the extra that brings it."""
    engine, found = ENGINES[simulator], importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *package: None if name == engine else found(name, *package)
    )
    spec = load_registry().get("simulators", simulator)
    others = {"mujoco.mjx"} if simulator == "mjx" else set()  # which may be there or not
    missing = {need.partition(">=")[0] for need in spec.missing} - others
    extra = simulator.replace("_", "-")
    assert (missing, spec.remedy) == ({engine}, f"pip install 'fd100-harness[{extra}]'")


def test_listing_imports_no_engine(run_without_display):
    """The registry knows the simulators without importing what they are built on, or looking at what renders."""
    done = run_without_display(
        "import sys\nfrom harness.registry.registry import load_registry\n"
        "assert load_registry().get('simulators', 'dm_control').missing == ()\n"
        "engines = {'dm_control', 'mujoco', 'pybullet', 'pydrake', 'sapien', 'jax', 'glfw', 'OpenGL'}\n"
        "sys.stdout.write(str(engines & set(sys.modules)))"
    )
    assert done.stdout == "set()"


NEAR, FAR = np.array([0.6, 0.3, 0.6]), np.array([0.9, -0.4, 0.9])
"""Targets, [m]."""


@every_engine
def test_frame_shows_something(egl, open_arms):
    """A frame has the size asked for, a second one another, and neither is of one colour."""
    simulation = open_arms(1)
    for width, height in ((320, 240), (64, 48), (75, 33), (1024, 768)):
        frame = simulation.render(0, NEAR, width, height)
        assert (frame.shape, frame.dtype) == ((height, width, 3), np.uint8)
        assert frame.std() > 10.0


@every_engine
def test_frame_shows_the_arm_and_the_target(egl, open_arms):
    """Another arm, another pose and another target give another frame; the same ones give the same."""
    simulation, poses = open_arms(2), np.stack([ROBOT.home, ROBOT.home + 0.5])
    simulation.place(poses)
    frame = simulation.render(0, NEAR, 320, 240)
    assert (simulation.render(0, NEAR, 320, 240) == frame).all()
    assert (simulation.render(0, FAR, 320, 240) != frame).any()
    assert (simulation.render(1, NEAR, 320, 240) != frame).any()
    simulation.place(poses[::-1])
    assert (simulation.render(1, NEAR, 320, 240) == frame).all()


@every_engine
def test_frames_change_nothing(egl, open_arms):
    """An arm that is looked at moves, bit for bit, as one that is not."""
    seen, unseen = open_arms(1), open_arms(1)
    for period in range(5):
        target = home(1) + 0.3 * np.sin(0.3 * period)
        seen.render(0, NEAR, 32, 24)
        assert_same([seen.drive(target, PERIOD)], [unseen.drive(target, PERIOD)])


@every_engine
def test_frame_is_the_callers(egl, open_arms):
    """A frame stays as it is when the next one is drawn."""
    simulation = open_arms(1)
    frame = simulation.render(0, NEAR, 64, 48)
    kept = frame.copy()
    simulation.render(0, FAR, 64, 48)
    assert_array_equal(frame, kept)


@every_engine
def test_closing_one_leaves_the_frames_of_another(egl, open_arms):
    """Whichever of two simulations drew last, closing one changes no frame of the other."""
    first, second = open_arms(1), open_arms(1)
    first.render(0, NEAR, 320, 240)
    frame = second.render(0, NEAR, 320, 240)
    first.close()
    assert_array_equal(second.render(0, NEAR, 320, 240), frame)

"""MuJoCo: servos that track, contact of every link, batches that are exactly their arms, frames."""

import os
import subprocess
import sys
from ctypes.util import find_library
from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

import harness
from harness.errors import UsageError
from harness.motion import MoveJ
from harness.robot import Robot
from harness.simulator import Simulation, State
from harness_plugins.simulators.mujoco import Mujoco

ROBOT = harness.load_robot("fd100")
PERIOD = 0.1
MOTION = MoveJ.within_limits(ROBOT, speed=0.8, acceleration=0.6, period=PERIOD)
MOVING_LINKS = ("link2", "link3", "link4", "link5", "link6", "tool0")
"""Those that can get to the ground: the first one turns above it."""


def open_arms(num_envs: int, robot: Robot = ROBOT, **settings: int) -> Simulation:
    """Arms at home."""
    simulation = Mujoco(**settings).open(robot, num_envs, PERIOD)
    simulation.reset(home(num_envs), np.ones(num_envs, bool))
    return simulation


def home(num_envs: int) -> np.ndarray:
    """The home pose for each env."""
    return np.tile(ROBOT.home, (num_envs, 1))


def random_poses(count: int) -> np.ndarray:
    """Poses anywhere in the joint ranges."""
    return np.random.default_rng(1).uniform(ROBOT.lower, ROBOT.upper, (count, ROBOT.dof))


def wander(simulation: Simulation, num_envs: int, periods: int, same: bool = False) -> list[State]:
    """Random moves at full speed, some of them held for a while; an arm that touches the ground is reset to home.

    Returns copies of the states, with the target of each joint in the place of `end_effector`.
    """
    rng = np.random.default_rng(0)
    target, speed, states = home(num_envs), np.zeros((num_envs, ROBOT.dof)), []
    for period in range(periods):
        if period % 4 == 0:
            action = np.repeat(rng.uniform(-2.0, 2.0, (1 if same else num_envs, ROBOT.dof)), num_envs if same else 1, 0)
        (target,), speed, _ = MOTION.advance(target, speed, action)
        state = State._make(np.array(array) for array in simulation.drive(target, PERIOD))
        states.append(state._replace(end_effector=target))
        touching = state.ground_contact
        if touching.any():
            target, speed = np.where(touching[:, None], ROBOT.home, target), np.where(touching[:, None], 0.0, speed)
            simulation.reset(target, touching)
    return states


@pytest.mark.parametrize("num_envs", [1, 32])
def test_joints_follow_random_moves_at_full_speed(num_envs: int):
    """Over hundreds of random moves no joint in the air is ever 0.5 degrees off its target."""
    states = wander(open_arms(num_envs), num_envs, periods=3200 // num_envs)
    errors = np.array([np.abs(state.qpos - state.end_effector) for state in states])
    in_the_air = ~np.array([state.ground_contact for state in states])
    speeds = np.array([np.abs(state.qvel) for state in states])[in_the_air]
    assert in_the_air.sum() > 2500
    assert (speeds.max(axis=0) > 0.95 * MOTION.limits.max_speed).all()
    assert np.degrees(errors[in_the_air].max()) < 0.5


def test_arm_that_is_told_to_stay_stays():
    """Gravity does not pull the arm down: after 10 s every joint is within a thousandth of a degree of home."""
    simulation = open_arms(1)
    for _ in range(100):
        state = simulation.drive(home(1), PERIOD)
    assert np.degrees(np.abs(state.qpos - ROBOT.home).max()) < 1e-3


def test_errors_do_not_add_up():
    """After 500 small moves there and back the joints are where they began."""
    simulation = open_arms(1)
    for period in range(1000):
        state = simulation.drive(home(1) + 0.03 * np.sin(0.1 * (period + 1)), PERIOD)
    for _ in range(20):
        state = simulation.drive(home(1), PERIOD)
    assert np.degrees(np.abs(state.qpos - ROBOT.home).max()) < 1e-3


def test_placed_arm_stays_where_it_is_placed():
    """After `place` the servos hold the new pose: driving to it moves nothing."""
    simulation = open_arms(1)
    pose = ROBOT.home[None] + 0.5
    simulation.place(pose)
    state = simulation.drive(pose, PERIOD)
    assert np.degrees(np.abs(state.qpos - pose).max()) < 1e-3


def test_ground_contact_is_that_of_the_geometry():
    """On 500 random poses there is contact exactly where a moving link's shape is below the ground."""
    poses = random_poses(500)
    heights = np.array([lowest_height(pose) for pose in poses])
    contact = np.array(open_arms(500).place(poses).ground_contact)
    clear = np.abs(heights) > 1e-3
    assert 50 < contact.sum() < 450
    np.testing.assert_array_equal(contact[clear], heights[clear] < 0.0)


def lowest_height(pose: np.ndarray) -> float:
    """Distance of the moving links from the ground [m], negative inside it, by a model of the arm's URDF alone."""
    data = mujoco.MjData(BARE)
    data.qpos[:] = pose
    mujoco.mj_forward(BARE, data)
    ground = BARE.geom("ground").id
    moving = [geom for geom in range(BARE.ngeom) if BARE.body(BARE.geom_bodyid[geom]).name in MOVING_LINKS]
    return min(mujoco.mj_geomDistance(BARE, data, ground, geom, 3.0, None) for geom in moving)


def bare_model() -> mujoco.MjModel:
    """The arm on a plane, and nothing else."""
    spec = mujoco.MjSpec.from_string(ROBOT.urdf)
    spec.compiler.fusestatic = False
    spec.worldbody.add_geom(name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3.0, 3.0, 0.1])
    return spec.compile()


BARE = bare_model()


@pytest.mark.parametrize("link", MOVING_LINKS)
def test_every_moving_link_touches_the_ground(link: str):
    """An arm of which only one link has a shape touches the ground with it."""
    assert open_arms(500, only_shape_of(link)).place(random_poses(500)).ground_contact.any()


def test_base_does_not_touch_the_ground():
    """The base, which stands on the ground, is no contact."""
    assert not open_arms(100, only_shape_of("base_link")).place(random_poses(100)).ground_contact.any()


def only_shape_of(link: str) -> Robot:
    """The arm without the shapes of all links but one."""
    tree = ElementTree.fromstring(ROBOT.urdf)
    for element in tree.findall("link"):
        for shape in [*element.findall("collision"), *element.findall("visual")]:
            if element.get("name") != link:
                element.remove(shape)
    return replace(ROBOT, urdf=ElementTree.tostring(tree, encoding="unicode"))


def test_links_do_not_touch_one_another():
    """Folded into itself high above the ground, the arm touches nothing: only the ground counts."""
    folded = np.radians([[0.0, -60.0, 80.0, 0.0, 135.0, 0.0]])
    assert lowest_height(folded[0]) > 0.1
    assert not open_arms(1).place(folded).ground_contact.any()


def test_batch_moves_as_one_arm_alone():
    """Through the threads of rollout an arm moves, bit for bit, as with one call in this process."""
    (alone, batch) = (wander(open_arms(num_envs), num_envs, 60, same=True) for num_envs in (1, 5))
    for one, many in zip(alone, batch, strict=True):
        for env in range(5):
            for array, arrays in zip(one, many, strict=True):
                np.testing.assert_array_equal(array[0], arrays[env])


def test_number_of_threads_does_not_show():
    """One thread and two give the same states, bit for bit."""
    runs = [wander(open_arms(7, threads=threads), 7, 60) for threads in (1, 2)]
    for first, second in zip(*runs, strict=True):
        for one, other in zip(first, second, strict=True):
            np.testing.assert_array_equal(one, other)


def test_more_threads_than_arms():
    """Threads without an arm are no error."""
    assert open_arms(2, threads=4).drive(home(2), PERIOD).qpos.shape == (2, 6)


def test_joints_are_in_the_order_of_the_robot():
    """Where each joint is told another angle, each has its own."""
    pose = np.radians([[-50.0, -30.0, 20.0, 70.0, 110.0, 200.0]])
    np.testing.assert_allclose(open_arms(1).place(pose).qpos, pose, atol=1e-12)


def test_order_of_the_elements_in_the_urdf_does_not_matter():
    """A URDF that lists its joints and links backwards is the same arm."""
    tree = ElementTree.fromstring(ROBOT.urdf)
    tree[:] = tree[::-1]
    backwards = replace(ROBOT, urdf=ElementTree.tostring(tree, encoding="unicode"))
    pose = random_poses(1)
    first, second = (open_arms(1, robot).place(pose) for robot in (ROBOT, backwards))
    np.testing.assert_allclose(first.qpos, second.qpos, atol=1e-12)
    np.testing.assert_allclose(first.end_effector, second.end_effector, atol=1e-12)


@pytest.mark.parametrize("given", ["substeps=0", "substeps=1.5", "bandwidth=0", "bandwidth=nan", "threads=0", "gpu=1"])
def test_bad_setting_is_a_usage_error(given: str):
    """A setting that cannot be is refused, in one line that names it."""
    with pytest.raises(UsageError, match=given.partition("=")[0]):
        harness.make_env(f"mujoco:{given}")


needs_egl = pytest.mark.skipif(find_library("EGL") is None, reason="no EGL library on this machine: install libegl1")


def render(code: str, library: str = "egl") -> "subprocess.CompletedProcess[str]":
    """Run code with an arm at hand, in a process of its own: MuJoCo chooses what renders when it is imported."""
    prelude = (
        "import harness, numpy as np\n"
        "from harness_plugins.simulators.mujoco import Mujoco\n"
        "robot = harness.load_robot('fd100')\n"
        "arms = Mujoco().open(robot, 2, 0.1)\n"
        "poses = np.stack([robot.home, robot.home + 0.5])\n"
        "arms.place(poses)\n"
        "near, far = np.array([0.6, 0.3, 0.6]), np.array([0.9, -0.4, 0.9])\n"
    )
    without_screen = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    return subprocess.run(
        [sys.executable, "-c", f"{prelude}{code}\narms.close()"],
        env={**without_screen, "MUJOCO_GL": library}, capture_output=True, text=True, check=False,
    )  # fmt: skip


def assert_fine(done: "subprocess.CompletedProcess[str]") -> None:
    """The code ran to its end and said nothing."""
    assert (done.returncode, done.stderr) == (0, "")


@needs_egl
def test_frame_shows_something():
    """A frame has the size asked for and is not of one colour."""
    assert_fine(
        render(
            "frame = arms.render(0, near, 320, 240)\n"
            "assert frame.shape == (240, 320, 3) and frame.dtype == np.uint8\n"
            "assert frame.std() > 10.0"
        )
    )


@needs_egl
def test_frame_shows_the_arm_and_the_target():
    """Another arm, another pose and another target give another frame; the same ones give the same."""
    assert_fine(
        render(
            "frame = arms.render(0, near, 320, 240).copy()\n"
            "assert (arms.render(0, near, 320, 240) == frame).all()\n"
            "assert (arms.render(0, far, 320, 240) != frame).any()\n"
            "assert (arms.render(1, near, 320, 240) != frame).any()\n"
            "arms.place(poses[::-1])\n"
            "assert (arms.render(1, near, 320, 240) == frame).all()"
        )
    )


@needs_egl
def test_each_frame_has_the_size_asked_for():
    """A second frame may have another size than the first."""
    assert_fine(render("arms.render(0, near, 320, 240)\nassert arms.render(0, near, 64, 48).shape == (48, 64, 3)"))


def test_machine_without_a_screen_says_what_to_do():
    """Where the chosen library cannot render, UsageError names the others and what to install."""
    done = render("arms.render(0, near, 320, 240)", library="glfw")
    assert done.returncode == 1
    assert "harness.errors.UsageError" in done.stderr
    assert "MUJOCO_GL=egl" in done.stderr
    assert "libegl1" in done.stderr
